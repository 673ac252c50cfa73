#include "liggghts/measure/fix_mill_occupancy.h"

#include <cmath>
#include <cstdio>
#include <cstring>
#include <stdexcept>

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "modify.h"

#include "liggghts/common/keywords.h"
#include "liggghts/mill/mill_of.h"

using namespace LAMMPS_NS;
using namespace FixConst;
namespace charge = millscale::charge;
using millscale::Vector;

FixMillOccupancy::FixMillOccupancy(LAMMPS* lmp, int narg, char** arg) : Fix(lmp, narg, arg)
{
  scalar_flag = 1;
  global_freq = 1;
  extscalar = 0;
  restart_global = 1;
  try {
    parse(narg, arg);
    mill_fix_ = mill_of(modify, mill_id_);
    const auto& mill = mill_fix_->scaled().mill;
    grid_ = std::make_unique<charge::OccupancyGrid>(
        charge::PolarCells{static_cast<std::size_t>(rings_), static_cast<std::size_t>(sectors_),
                           mill_fix_->liner()->radius() - mill.ball_radius});
  } catch (const std::invalid_argument& problem) {
    error->fix_error(FLERR, this, problem.what());
  }
}

void FixMillOccupancy::parse(int narg, char** arg)
{
  millscale::Keywords()
      .word("mill", mill_id_)
      .count("every", nevery)
      .number("from", from_)
      .number("to", to_)
      .count("rings", rings_)
      .count("sectors", sectors_)
      .word("file", file_)
      .parse({narg, arg, 3});
  if (file_.empty()) throw std::invalid_argument("file: the name of the file to write is needed");
  if (nevery < 1) throw std::invalid_argument("every: expected a number of steps >= 1");
  if (!(from_ >= 0.0 && to_ > from_))
    throw std::invalid_argument("from, to: mill angles 0 <= from < to are needed [rad], got " +
                                millscale::format(from_) + " and " + millscale::format(to_));
}

int FixMillOccupancy::setmask()
{
  return END_OF_STEP | POST_RUN;
}

void FixMillOccupancy::init()
{
  try {
    mill_fix_ = mill_of(modify, mill_id_);
  } catch (const std::invalid_argument& problem) {
    error->fix_error(FLERR, this, problem.what());
  }
}

void FixMillOccupancy::end_of_step()
{
  if (window_.written != 0.0) return;
  const double angle = mill_fix_->mill_angle();
  if (angle >= from_ && angle <= to_) sample(angle);
  if (angle < to_) return;
  if (window_.samples > 0.0) write();
  window_.written = 1.0;
}

/// A run that ends within the window writes the average so far.
void FixMillOccupancy::post_run()
{
  if (window_.samples > 0.0 && window_.written == 0.0) write();
}

void FixMillOccupancy::sample(double mill_angle)
{
  if (window_.samples == 0.0) window_.first_angle = mill_angle;
  window_.last_angle = mill_angle;
  window_.samples += 1.0;
  const millscale::MillFrame frame = mill_fix_->frame();
  for (int i = 0; i < atom->nlocal; ++i) {
    if (!(atom->mask[i] & groupbit)) continue;
    grid_->add(millscale::liner::section(frame.point(atom->x[i])), atom->radius[i]);
  }
}

/// Return the sums on rank 0, and nothing on other ranks.
std::vector<double> FixMillOccupancy::volumes_of_all_ranks() const
{
  const std::vector<double>& mine = grid_->volumes();
  std::vector<double> all(comm->me == 0 ? mine.size() : 0);
  MPI_Reduce(mine.data(), all.data(), static_cast<int>(mine.size()), MPI_DOUBLE, MPI_SUM, 0, world);
  return all;
}

/// Write under another name, then rename: an existing file is complete.
void FixMillOccupancy::write()
{
  const std::vector<double> all = volumes_of_all_ranks();
  int done = 1;
  if (comm->me == 0) {
    const std::string part = file_ + ".part";
    done = put_file(part, all) && std::rename(part.c_str(), file_.c_str()) == 0;
  }
  MPI_Bcast(&done, 1, MPI_INT, 0, world);
  if (done) return;
  const std::string message =
      "file: cannot write '" + file_ + "'; check the folder and the disk space";
  error->fix_error(FLERR, this, message.c_str());
}

bool FixMillOccupancy::put_file(const std::string& name, const std::vector<double>& volumes) const
{
  FILE* out = std::fopen(name.c_str(), "w");
  if (!out) return false;
  std::fputs(
      "mill_angle_from_rad,mill_angle_to_rad,samples,radius_low,radius_high,angle_low_rad,"
      "angle_high_rad,solid_fraction\n",
      out);
  const double length = mill_length();
  for (std::size_t i = 0; i < volumes.size(); ++i) {
    const charge::OccupancyCell c = grid_->cell(i, volumes, window_.samples, length);
    std::fprintf(out, "%.10g,%.10g,%.0f,%.10g,%.10g,%.10g,%.10g,%.10g\n", window_.first_angle,
                 window_.last_angle, window_.samples, c.radius_low, c.radius_high, c.angle_low,
                 c.angle_high, c.solid_fraction);
  }
  const bool complete = std::ferror(out) == 0;
  return std::fclose(out) == 0 && complete;
}

/// Return the length of the box along the axis, which is parallel to an edge of the box [m].
double FixMillOccupancy::mill_length() const
{
  const Vector& axis = mill_fix_->axis();
  double length = 0.0;
  for (int d = 0; d < 3; ++d) length += std::abs(axis[d]) * domain->prd[d];
  return length;
}

double FixMillOccupancy::compute_scalar()
{
  return window_.samples;
}

void FixMillOccupancy::write_restart(FILE* file)
{
  const std::vector<double> all = volumes_of_all_ranks();
  if (comm->me != 0) return;
  std::vector<double> state{static_cast<double>(rings_),
                            static_cast<double>(sectors_),
                            window_.samples,
                            window_.first_angle,
                            window_.last_angle,
                            window_.written};
  state.insert(state.end(), all.begin(), all.end());
  const int bytes = static_cast<int>(state.size() * sizeof(double));
  fwrite(&bytes, sizeof bytes, 1, file);
  fwrite(state.data(), 1, static_cast<std::size_t>(bytes), file);
}

void FixMillOccupancy::restart(char* buffer)
{
  double state[6];
  std::memcpy(state, buffer, sizeof state);
  if (state[0] != rings_ || state[1] != sectors_) {
    const std::string message =
        "the restart file holds " + millscale::format(state[0]) + " rings of " +
        millscale::format(state[1]) +
        " sectors; give the same numbers, or give the fix another id to begin again";
    error->fix_error(FLERR, this, message.c_str());
  }
  window_ = {state[2], state[3], state[4], state[5]};
  if (comm->me == 0)
    std::memcpy(grid_->volumes().data(), buffer + sizeof state,
                grid_->volumes().size() * sizeof(double));
}
