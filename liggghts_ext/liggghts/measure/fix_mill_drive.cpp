#include "liggghts/measure/fix_mill_drive.h"

#include <array>
#include <cstring>
#include <stdexcept>
#include <vector>

#include "comm.h"
#include "error.h"
#include "modify.h"
#include "update.h"

#include "core/math/format.h"
#include "liggghts/common/keywords.h"
#include "liggghts/mill/mill_of.h"
#include "liggghts/wall/fix_wall_mill.h"

using namespace LAMMPS_NS;
using namespace FixConst;
using millscale::charge::DriveSums;

namespace {

// Of restart files: the sums of the drive, and those with the sums of the ends.
constexpr double drive_layout = 1.0, ends_layout = 2.0;

enum Published {
  work_J = 1,
  impulse_Nms,
  torque_Nm,
  power_W,
  alternating_Nm,
  ends_work_J,
  ends_impulse_Nms
};
constexpr int published_size = ends_impulse_Nms;

// f_ID[4..6] of a wall is the torque on it.
constexpr int wall_numbers = 6, wall_torque = 3;

}  // namespace

/// Head of the state in a restart file. The sums of each rank follow.
struct FixMillDrive::State {
  double layout, begun, ranks;
  Interval interval;
};

FixMillDrive::FixMillDrive(LAMMPS* lmp, int narg, char** arg) : Fix(lmp, narg, arg)
{
  vector_flag = 1;
  size_vector = published_size;
  global_freq = 1;
  extvector = 0;
  restart_global = 1;
  nevery = 1;
  try {
    parse(narg, arg);
    find_wall_and_mill();
  } catch (const std::invalid_argument& problem) {
    error->fix_error(FLERR, this, problem.what());
  }
}

void FixMillDrive::parse(int narg, char** arg)
{
  millscale::Keywords()
      .word("mill", mill_id_)
      .word("wall", wall_id_)
      .count("every", every_)
      .parse({narg, arg, 3});
  if (every_ < 1)
    throw std::invalid_argument(
        "every: give the number of steps between two rows of the series, >= 1");
}

void FixMillDrive::find_wall_and_mill()
{
  mill_fix_ = mill_of(modify, mill_id_);
  wall_ = modify->find_fix_id(wall_id_.c_str());
  analytic_ = dynamic_cast<FixWallMill*>(wall_);
  const bool mesh = wall_ && std::string(wall_->style) == "mesh/surface/stress" &&
                    wall_->size_vector >= wall_numbers;
  if (!analytic_ && !mesh)
    throw std::invalid_argument("wall: '" + wall_id_ +
                                "' is not the id of a fix wall/mill or mesh/surface/stress; "
                                "define that fix first");
}

int FixMillDrive::setmask()
{
  return END_OF_STEP;
}

void FixMillDrive::init()
{
  try {
    find_wall_and_mill();
  } catch (const std::invalid_argument& problem) {
    error->fix_error(FLERR, this, problem.what());
  }
  forces_carried_ = recent_restart && modify->n_fixes_style("mill/forces") > 0;
}

/// Return this rank's share of the torque on the charge about the mill's axis, by all surfaces that
/// turn with the mill [N m].
double FixMillDrive::torque_of_drive()
{
  const millscale::Vector& axis = mill_fix_->axis();
  if (analytic_) return -millscale::dot(analytic_->torque_on_turning(), axis);
  double torque = 0.0;
  for (int d = 0; d < 3; ++d) torque -= axis[d] * wall_->compute_vector(wall_torque + d);
  return comm->me == 0 ? torque : 0.0;  // every rank has the sum over all ranks
}

/// Return this rank's share of the torque of the ends on the charge about the mill's axis [N m].
double FixMillDrive::torque_of_ends() const
{
  return analytic_ ? -millscale::dot(analytic_->torque_on_ends(), mill_fix_->axis()) : 0.0;
}

/// Return the speed of the ends [rad/s]: ends at rest do no work.
double FixMillDrive::speed_of_ends() const
{
  return analytic_ && analytic_->ends_turn() ? mill_fix_->speed_now() : 0.0;
}

void FixMillDrive::setup(int)
{
  const double torque = torque_of_drive(), of_ends = torque_of_ends();
  if (!forces_carried_) {
    sums_.wait_for(torque, torque * mill_fix_->speed_now(), update->dt);
    of_ends_.wait_for(of_ends, of_ends * speed_of_ends(), update->dt);
  }
  forces_carried_ = false;
  if (begun_ == 0.0) interval_.began = mill_fix_->mill_time();
  begun_ = 1.0;
}

void FixMillDrive::end_of_step()
{
  const double torque = torque_of_drive();
  sums_.add(torque, torque * mill_fix_->speed_now(), update->dt, update->ntimestep);
  const double of_ends = torque_of_ends();
  of_ends_.add(of_ends, of_ends * speed_of_ends(), update->dt, update->ntimestep);
  interval_.steps += 1.0;
  if (update->ntimestep % every_ == 0) end_interval();
}

DriveSums FixMillDrive::over_all_ranks(DriveSums mine) const
{
  static_assert(sizeof(DriveSums) % sizeof(double) == 0);
  DriveSums all;
  MPI_Allreduce(&mine, &all, sizeof(DriveSums) / sizeof(double), MPI_DOUBLE, MPI_SUM, world);
  return all;
}

void FixMillDrive::end_interval()
{
  const DriveSums all = over_all_ranks(sums_);
  const double now = mill_fix_->mill_time(), duration = now - interval_.began;
  interval_ = {now,
               all.impulse(),
               all.work(),
               0.0,
               (all.impulse() - interval_.impulse) / duration,
               (all.work() - interval_.work) / duration,
               all.alternating(update->ntimestep, static_cast<bigint>(interval_.steps))};
  sums_.begin_interval();
}

double FixMillDrive::compute_vector(int index)
{
  switch (index + 1) {
    case work_J:
      return over_all_ranks(sums_).work();
    case impulse_Nms:
      return over_all_ranks(sums_).impulse();
    case ends_work_J:
      return over_all_ranks(of_ends_).work();
    case ends_impulse_Nms:
      return over_all_ranks(of_ends_).impulse();
    case torque_Nm:
      return interval_.torque;
    case power_W:
      return interval_.power;
    case alternating_Nm:
      return interval_.alternating;
  }
  return 0.0;
}

/// Write the sums of each rank: a continued run with as many ranks then rounds like an
/// uninterrupted one. Sums of the ends follow if there are ends.
void FixMillDrive::write_restart(FILE* file)
{
  const bool ends = analytic_ && analytic_->has_ends();
  const std::array<DriveSums, 2> mine{sums_, of_ends_};
  const int kept = ends ? 2 : 1, size = kept * sizeof(DriveSums) / sizeof(double);
  std::vector<DriveSums> sums(comm->me == 0 ? kept * comm->nprocs : 0);
  MPI_Gather(mine.data(), size, MPI_DOUBLE, sums.data(), size, MPI_DOUBLE, 0, world);
  if (comm->me != 0) return;
  const State head{ends ? ends_layout : drive_layout, begun_, static_cast<double>(comm->nprocs),
                   interval_};
  const int bytes = static_cast<int>(sizeof head + sums.size() * sizeof(DriveSums));
  fwrite(&bytes, sizeof bytes, 1, file);
  fwrite(&head, sizeof head, 1, file);
  fwrite(sums.data(), sizeof(DriveSums), sums.size(), file);
}

void FixMillDrive::restart(char* buffer)
{
  State from{};
  std::memcpy(&from, buffer, sizeof from);
  if (from.layout != drive_layout && from.layout != ends_layout) {
    const std::string message =
        "the restart file holds layout " + millscale::format(from.layout) +
        " of this fix, this version reads layouts " + millscale::format(drive_layout) + " and " +
        millscale::format(ends_layout) + "; give the fix another id to begin again";
    error->fix_error(FLERR, this, message.c_str());
  }
  begun_ = from.begun;
  interval_ = from.interval;
  const int ranks = static_cast<int>(from.ranks), kept = from.layout == ends_layout ? 2 : 1;
  std::vector<DriveSums> sums(kept * ranks);
  std::memcpy(sums.data(), buffer + sizeof from, sums.size() * sizeof(DriveSums));
  sums_ = of_ends_ = {};
  for (int rank = 0; rank < ranks; ++rank) {
    if (ranks == comm->nprocs ? rank != comm->me : comm->me != 0) continue;
    sums_ += sums[kept * rank];
    if (kept == 2) of_ends_ += sums[kept * rank + 1];
  }
}
