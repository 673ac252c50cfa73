#include "liggghts/wall/fix_mill_liner_loads.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <stdexcept>

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "modify.h"

#include "core/liner/profile_file.h"
#include "core/math/format.h"
#include "liggghts/common/keywords.h"
#include "liggghts/mill/mill_of.h"
#include "liggghts/wall/fix_wall_mill.h"

using namespace LAMMPS_NS;
using namespace FixConst;
namespace charge = millscale::charge;
namespace liner = millscale::liner;
using millscale::format;

namespace {

constexpr double layout = 1.0;          // of restart files
constexpr double widest_place = 0.035;  // interval of the mill angle, about 2 degrees [rad]
constexpr int ends = 2;                 // bins behind those of the profile

constexpr const char* load_columns =
    "normal_impulse_Ns,tangential_impulse_Ns,torque_impulse_Nms,slip_work_J,normal_dissipation_J,"
    "impacts,impact_energy_J,finnie_energy_J";

void put(FILE* out, const charge::LinerLoads& loads)
{
  for (const double load : loads) std::fprintf(out, ",%.17g", load);
  std::fputs("\n", out);
}

bool any(const charge::LinerLoads& loads)
{
  return std::any_of(loads.begin(), loads.end(), [](double load) { return load != 0.0; });
}

bool closed(FILE* out)
{
  const bool complete = std::ferror(out) == 0;
  return std::fclose(out) == 0 && complete;
}

}  // namespace

struct FixMillLinerLoads::State {
  double layout, classes, sectors, bins, steps;
  Window window;
};

FixMillLinerLoads::FixMillLinerLoads(LAMMPS* lmp, int narg, char** arg) : Fix(lmp, narg, arg)
{
  vector_flag = 1;
  size_vector = charge::liner_loads;
  global_freq = 1;
  extvector = 1;
  restart_global = 1;
  try {
    if (igroup != 0)
      throw std::invalid_argument("group: the loads are those of all balls; use `all`");
    parse(narg, arg);
    find_wall_and_mill();
  } catch (const std::invalid_argument& problem) {
    error->fix_error(FLERR, this, problem.what());
  }
}

void FixMillLinerLoads::parse(int narg, char** arg)
{
  millscale::Keywords()
      .word("mill", mill_id_)
      .word("wall", wall_id_)
      .number("from", from_)
      .number("to", to_)
      .count("bins", bins_)
      .word("map", map_file_)
      .word("lifters", lifters_file_)
      .parse({narg, arg, 3});
  if (!(from_ >= 0.0 && to_ > from_))
    throw std::invalid_argument("from, to: mill angles 0 <= from < to are needed [rad], got " +
                                format(from_) + " and " + format(to_));
  if (bins_ < 1 || bins_ > 10'000)
    throw std::invalid_argument("bins: expected 1 to 10000 bins in a pitch, got " +
                                std::to_string(bins_));
}

void FixMillLinerLoads::find_wall_and_mill()
{
  mill_fix_ = mill_of(modify, mill_id_);
  wall_ = dynamic_cast<FixWallMill*>(modify->find_fix_id(wall_id_.c_str()));
  if (!wall_ || wall_->mill_id() != mill_id_)
    throw std::invalid_argument("wall: '" + wall_id_ + "' is not the id of a fix wall/mill of '" +
                                mill_id_ + "'; define that fix first");
  for (int i = 0; i < modify->nfix; ++i) {
    const auto* other = dynamic_cast<const FixMillLinerLoads*>(modify->fix[i]);
    if (other && other != this && other->wall_id_ == wall_id_)
      throw std::invalid_argument("wall: fix mill/liner_loads (id " + std::string(other->id) +
                                  ") has the loads of '" + wall_id_ + "'; leave one out");
  }
}

int FixMillLinerLoads::setmask()
{
  return POST_RUN;
}

void FixMillLinerLoads::init()
{
  try {
    find_wall_and_mill();
    make_sums();
  } catch (const std::invalid_argument& problem) {
    error->fix_error(FLERR, this, problem.what());
  }
}

/// Return the number of classes of balls, the largest type of a ball of any rank.
int FixMillLinerLoads::ball_classes() const
{
  int largest = 1;
  for (int i = 0; i < atom->nlocal; ++i) largest = std::max(largest, atom->type[i]);
  MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_INT, MPI_MAX, world);
  return largest;
}

/// Make the sums, with the state of a restart file if there is one. A later run goes on with them.
void FixMillLinerLoads::make_sums()
{
  if (sums_) return;
  const liner::Profile& profile = wall_->contact_profile();
  arc_ = std::make_unique<liner::ArcBins>(profile, bins_);
  const int steps = static_cast<int>(std::ceil(profile.pitch() / widest_place - 1e-9));
  const charge::LinerLoadSums::Size size{ball_classes(), profile.sectors(), arc_->count() + ends,
                                         steps};
  sums_ = std::make_unique<charge::LinerLoadSums>(size);
  if (state_.empty()) return;
  State from{};
  std::memcpy(static_cast<void*>(&from), state_.data(), sizeof from);
  const std::size_t head = sizeof(State) / sizeof(double), times = sums_->times().size();
  const bool same = from.classes == size.classes && from.sectors == size.sectors &&
                    from.bins == size.bins && from.steps == size.steps;
  if (from.layout != layout || !same)
    throw std::invalid_argument(
        "the restart file holds " + format(from.classes) + " classes, " + format(from.sectors) +
        " sectors of " + format(from.bins) + " bins and " + format(from.steps) +
        " places, the deck asks for " + std::to_string(size.classes) + ", " +
        std::to_string(size.sectors) + ", " + std::to_string(size.bins) + " and " +
        std::to_string(size.steps) + "; give the fix another id to begin again");
  window_ = from.window;
  std::copy_n(state_.begin() + head, times, sums_->times().begin());
  if (comm->me == 0) sums_->set_parts(state_.data() + head + times);  // of all ranks
  state_.clear();
}

bool FixMillLinerLoads::begin_step(double dt)
{
  if (!(dt > 0.0) || window_.written != 0.0) return false;
  const double angle = mill_fix_->mill_angle();
  if (angle < from_) return false;
  if (angle >= to_) {
    if (window_.steps > 0.0) write();
    window_.written = 1.0;
    return false;
  }
  if (window_.steps == 0.0) window_.first_angle = angle;
  window_.last_angle = angle;
  window_.steps += 1.0;
  sums_->begin_step(angle, dt);
  return true;
}

void FixMillLinerLoads::add(int type, int patch, liner::Point centre,
                            const charge::LinerLoads& loads)
{
  const int of_end = patch - wall_->liner_patches();
  const liner::ArcBins::Place place =
      of_end >= 0 ? liner::ArcBins::Place{0, arc_->count() + of_end} : arc_->place(patch, centre);
  sums_->add(type - 1, place.sector, place.bin, loads);
}

/// A run that ends within the window writes the loads so far.
void FixMillLinerLoads::post_run()
{
  if (window_.steps > 0.0 && window_.written == 0.0) write();
}

/// Sum up over the ranks: rank 0 keeps the sums, the others begin anew.
void FixMillLinerLoads::gather()
{
  sums_->advance();
  std::vector<double> mine = sums_->parts();
  std::vector<double> all(mine.size(), 0.0);
  MPI_Reduce(mine.data(), all.data(), static_cast<int>(mine.size()), MPI_DOUBLE, MPI_SUM, 0, world);
  sums_->set_parts(all.data());
}

/// Write under other names, then rename: an existing file is complete.
void FixMillLinerLoads::write()
{
  gather();
  int done = 1;
  if (comm->me == 0) {
    const auto part = [](const std::string& name) { return name + ".part"; };
    const auto rename = [&](const std::string& name) {
      return std::rename(part(name).c_str(), name.c_str()) == 0;
    };
    done = put_map(part(map_file_)) && put_lifters(part(lifters_file_)) && rename(map_file_) &&
           rename(lifters_file_);
  }
  MPI_Bcast(&done, 1, MPI_INT, 0, world);
  if (done) return;
  const std::string message = "cannot write '" + map_file_ + "' and '" + lifters_file_ +
                              "'; check the folder and the disk space";
  error->fix_error(FLERR, this, message.c_str());
}

/// Write the loads by place of the sectors and arc length, without empty rows.
bool FixMillLinerLoads::put_map(const std::string& name) const
{
  FILE* out = std::fopen(name.c_str(), "w");
  if (!out) return false;
  std::fprintf(out, "ball_class,bin,sector_angle_low_rad,sector_angle_high_rad,sectors_time_s,%s\n",
               load_columns);
  const charge::LinerLoadSums::Size& size = sums_->size();
  const double width = 2.0 * millscale::pi / size.places();
  for (int c = 0; c < size.classes; ++c)
    for (int place = 0; place < size.places(); ++place)
      for (int bin = 0; bin < arc_->count(); ++bin) {
        const charge::LinerLoads& loads = sums_->of_place(c, place, bin);
        if (!any(loads)) continue;
        const double low = wall_->contact_profile().phase() + place * width;
        std::fprintf(out, "%d,%d,%.10g,%.10g,%.17g", c + 1, bin, low, low + width,
                     sums_->time(place));
        put(out, loads);
      }
  return closed(out);
}

/// Write the bins, and the loads of each sector and of the ends.
bool FixMillLinerLoads::put_lifters(const std::string& name) const
{
  FILE* out = std::fopen(name.c_str(), "w");
  if (!out) return false;
  std::fprintf(out,
               "mill_angle_from_rad,mill_angle_to_rad,steps,ball_class,sector,bin,face,lifter,"
               "arc_low_m,arc_high_m,radial_m,tangential_m,tangent_radial,tangent_tangential,%s\n",
               load_columns);
  const charge::LinerLoadSums::Size& size = sums_->size();
  const auto row = [&](int c, int sector, int bin, const char* face, const liner::ArcBin& at) {
    std::fprintf(out, "%.10g,%.10g,%.0f,%d,%d,%d,%s,%d,%.10g,%.10g,%.10g,%.10g,%.10g,%.10g",
                 window_.first_angle, window_.last_angle, window_.steps, c + 1, sector, bin, face,
                 at.groove, at.begin, at.end, at.middle.radial, at.middle.tangential,
                 at.tangent.radial, at.tangent.tangential);
    put(out, sums_->of_sector(c, sector, bin));
  };
  const char* end_names[ends] = {"lower_end", "upper_end"};
  for (int c = 0; c < size.classes; ++c) {
    for (int sector = 0; sector < size.sectors; ++sector)
      for (int bin = 0; bin < arc_->count(); ++bin) {
        const liner::ArcBin& at = arc_->bins()[static_cast<std::size_t>(bin)];
        row(c, sector, bin, liner::detail::face_names[static_cast<int>(at.face)], at);
      }
    if (!wall_->has_ends()) continue;
    for (int end = 0; end < ends; ++end)
      row(c, 0, arc_->count() + end, end_names[end], liner::ArcBin{});
  }
  return closed(out);
}

/// Return a load of all contacts of the window so far.
double FixMillLinerLoads::compute_vector(int k)
{
  double mine = sums_ ? sums_->total()[static_cast<std::size_t>(k)] : 0.0, all = 0.0;
  MPI_Allreduce(&mine, &all, 1, MPI_DOUBLE, MPI_SUM, world);
  return all;
}

/// An uninterrupted run adds its sums up here too. So a continued run with as many ranks rounds
/// like it.
void FixMillLinerLoads::write_restart(FILE* file)
{
  gather();
  if (comm->me != 0) return;
  const charge::LinerLoadSums::Size& size = sums_->size();
  const State head{layout,
                   static_cast<double>(size.classes),
                   static_cast<double>(size.sectors),
                   static_cast<double>(size.bins),
                   static_cast<double>(size.steps),
                   window_};
  const std::vector<double>&times = sums_->times(), parts = sums_->parts();
  const int bytes = static_cast<int>(sizeof head + (times.size() + parts.size()) * sizeof(double));
  fwrite(&bytes, sizeof bytes, 1, file);
  fwrite(&head, sizeof head, 1, file);
  fwrite(times.data(), sizeof(double), times.size(), file);
  fwrite(parts.data(), sizeof(double), parts.size(), file);
}

void FixMillLinerLoads::restart(char* buffer)
{
  State from{};
  std::memcpy(&from, buffer, sizeof from);
  const double places = from.sectors * from.steps;
  const auto sums = static_cast<std::size_t>(from.layout == layout
                                                 ? places + charge::liner_loads * from.classes *
                                                                from.bins * (from.sectors + places)
                                                 : 0.0);
  state_.resize(sizeof(State) / sizeof(double) + sums);
  std::memcpy(state_.data(), buffer, state_.size() * sizeof(double));
}
