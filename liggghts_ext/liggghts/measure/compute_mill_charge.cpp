#include "liggghts/measure/compute_mill_charge.h"

#include <cstdio>
#include <stdexcept>
#include <vector>

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "group.h"
#include "modify.h"
#include "update.h"

#include "core/liner/groove_box.h"
#include "core/math/constants.h"
#include "liggghts/common/first_fix.h"
#include "liggghts/common/keywords.h"
#include "liggghts/mill/mill_of.h"
#include "liggghts/pair/fix_ball_rows.h"
#include "liggghts/pair/pair_gran_fast.h"
#include "liggghts/wall/style_liner.h"

using namespace LAMMPS_NS;
namespace charge = millscale::charge;
namespace liner = millscale::liner;
using millscale::Vector;

namespace {

constexpr int published_size = 17;
constexpr int all_balls = 0;  // the engine's first group

void merge_numbers(void* from, void* into, int* count, MPI_Datatype* type)
{
  int bytes = 0;
  MPI_Type_size(*type, &bytes);
  const std::size_t size = static_cast<std::size_t>(bytes) / sizeof(double);
  for (int i = 0; i < *count; ++i)
    charge::ChargeSums::merge(static_cast<const double*>(from) + i * size,
                              static_cast<double*>(into) + i * size, size);
}

double squared(const double* v)
{
  return v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
}

}  // namespace

ComputeMillCharge::ComputeMillCharge(LAMMPS* lmp, int& iarg, int narg, char** arg)
    : Compute(lmp, iarg, narg, arg)
{
  vector_flag = 1;
  timeflag = 1;  // the engine adds the steps at which it will read this compute
  size_vector = published_size;
  extvector = 0;
  vector = new double[published_size];
  try {
    parse(narg, arg, iarg);
  } catch (const std::invalid_argument& problem) {
    error->compute_error(FLERR, this, problem.what());
  }
  iarg = narg;
}

ComputeMillCharge::~ComputeMillCharge()
{
  if (merge_ != MPI_OP_NULL) MPI_Op_free(&merge_);
  if (numbers_type_ != MPI_DATATYPE_NULL) MPI_Type_free(&numbers_type_);
  delete[] vector;
}

void ComputeMillCharge::parse(int narg, char** arg, int first)
{
  millscale::Keywords keywords;
  keywords.word("mill", mill_id_);
  liner_arguments_.add_to(keywords);
  keywords
      .add("box_angle",
           [this](millscale::ArgumentList& list) { box_angle_ = list.number("box_angle"); })
      .parse({narg, arg, first});
  if (mill_id_.empty())
    throw std::invalid_argument("mill: the id of a fix mill/similarity is needed");
}

void ComputeMillCharge::init()
{
  try {
    mill_fix_ = mill_of(modify, mill_id_);
    frame_ = mill_fix_->frame();
    liner_ = StyleLiner(modify, *mill_fix_).of(liner_arguments_);
    sums_ = std::make_unique<charge::ChargeSums>(
        charge::Plan{*liner_, mill_fix_->scaled().mill.ball_radius, mill_fix_->gravity(),
                     box_angle_.value_or(millscale::liner::groove_middle(*liner_))});
  } catch (const std::invalid_argument& problem) {
    error->compute_error(FLERR, this, problem.what());
  }
  if (merge_ == MPI_OP_NULL) MPI_Op_create(&merge_numbers, 1, &merge_);
  if (numbers_type_ != MPI_DATATYPE_NULL) MPI_Type_free(&numbers_type_);
  MPI_Type_contiguous(static_cast<int>(sums_->numbers().size()), MPI_DOUBLE, &numbers_type_);
  MPI_Type_commit(&numbers_type_);
  last_balls_ = 0.0;
}

void ComputeMillCharge::compute_vector()
{
  invoked_vector = update->ntimestep;
  matchstep(update->ntimestep);  // drops the steps that have passed, if no pair style asks
  sums_->start(mill_fix_->mill_angle());
  read_balls();
  sums_->add_overlap(largest_overlap());
  sum_over_ranks();
  const charge::Summary all = sums_->summary();
  if (all.outside > 0.0) report_outside(all.outside);
  check_all_are_there(all.balls);
  const double published[published_size] = {all.balls,
                                            all.mass,
                                            all.kinetic_translation,
                                            all.kinetic_rotation,
                                            all.potential,
                                            all.centre_x,
                                            all.centre_z,
                                            all.box_fixed,
                                            all.box_rotating,
                                            all.toe,
                                            all.shoulder,
                                            std::max(all.overlap_with_ball, all.overlap_with_wall),
                                            all.overlap_with_ball,
                                            all.overlap_with_wall,
                                            all.largest_speed,
                                            all.angular_momentum,
                                            all.liner_slip(mill_fix_->speed_now())};
  std::copy(published, published + published_size, vector);
}

liner::Point ComputeMillCharge::centre(int i) const
{
  return liner::section(frame_.point(atom->x[i]));
}

/// Return the angular momentum of a ball's path about the mill's axis [kg m^2/s].
double ComputeMillCharge::path_momentum(int i) const
{
  const double* v = atom->v[i];
  const Vector of_path = millscale::cross(frame_.arm(atom->x[i]), {v[0], v[1], v[2]});
  return atom->rmass[i] * millscale::dot(frame_.axis(), of_path);
}

/// Return the angular momentum of a ball's spin about the mill's axis [kg m^2/s].
double ComputeMillCharge::spin_momentum(int i) const
{
  const double* spin = atom->omega[i];
  return atom->rmass[i] * millscale::sphere_inertia * atom->radius[i] * atom->radius[i] *
         millscale::dot(frame_.axis(), {spin[0], spin[1], spin[2]});
}

void ComputeMillCharge::read_balls()
{
  for (int i = 0; i < atom->nlocal; ++i)
    if (atom->mask[i] & groupbit)
      sums_->add({centre(i), atom->rmass[i], atom->radius[i], squared(atom->v[i]),
                  squared(atom->omega[i]), path_momentum(i), spin_momentum(i)});
}

bool ComputeMillCharge::reads_overlap_now()
{
  return matchstep(update->ntimestep);
}

/// Return the largest overlap among this rank's balls and ghosts. Ghost positions are those of this
/// step, and ghosts reach as far as a contact. The kernel may have noted the overlap of all balls.
double ComputeMillCharge::largest_overlap()
{
  const auto* rows = first_fix<FixBallRows>(modify);
  if (igroup == all_balls && rows && rows->pair)
    if (const auto noted = rows->pair->largest_overlap()) return *noted;
  search_.clear();
  for (int i = 0; i < atom->nlocal + atom->nghost; ++i)
    if (atom->mask[i] & groupbit)
      search_.add(
          {atom->x[i][0], atom->x[i][1], atom->x[i][2], atom->radius[i], i >= atom->nlocal});
  return search_.largest();
}

void ComputeMillCharge::sum_over_ranks()
{
  if (comm->nprocs > 1)
    MPI_Allreduce(MPI_IN_PLACE, sums_->numbers().data(), 1, numbers_type_, merge_, world);
}

/// Check that no ball is lost: the engine deletes balls that leave the box, without an error.
void ComputeMillCharge::check_all_are_there(double found)
{
  const double before = last_balls_;
  last_balls_ = found;
  if (igroup != all_balls || found >= before) return;
  char message[300];
  std::snprintf(message, sizeof message,
                "%.0f of %.0f balls lost since the last sample, seen at step " BIGINT_FORMAT
                "%s; reduce the time step, or look for large overlaps",
                before - found, before, update->ntimestep, missing_ids(before).c_str());
  error->all(FLERR, message);
}

/// Return the first few missing ids, if the balls were numbered from 1 without a gap.
std::string ComputeMillCharge::missing_ids(double before) const
{
  std::vector<unsigned char> present(static_cast<std::size_t>(before) + 1, 0);
  for (int i = 0; i < atom->nlocal; ++i)
    if (atom->tag[i] <= before) present[static_cast<std::size_t>(atom->tag[i])] = 1;
  MPI_Allreduce(MPI_IN_PLACE, present.data(), static_cast<int>(present.size()), MPI_UNSIGNED_CHAR,
                MPI_MAX, world);
  std::string ids;
  int named = 0;
  for (std::size_t id = 1; id < present.size() && named < 5; ++id)
    if (!present[id]) ids += (named++ == 0 ? ", id " : ", ") + std::to_string(id);
  return ids;
}

/// End the run with the first ball outside, of the lowest rank that has one.
void ComputeMillCharge::report_outside(double count)
{
  char message[400] = {};
  int owner = comm->nprocs;
  for (int i = 0; i < atom->nlocal && owner == comm->nprocs; ++i) {
    const liner::Point p = centre(i);
    if (!(atom->mask[i] & groupbit) || sums_->inside(p.x * p.x + p.z * p.z)) continue;
    owner = comm->me;
    const double* x = atom->x[i];
    std::snprintf(
        message, sizeof message,
        "%.0f balls outside the liner at step " BIGINT_FORMAT
        ": id %d with its centre at (%.6g, %.6g, %.6g) m, %.6g m from the axis, where the "
        "liner's radius is %.6g m; reduce the time step, or look for large overlaps",
        count, update->ntimestep, atom->tag[i], x[0], x[1], x[2], liner::length(p),
        liner_->radius());
  }
  MPI_Allreduce(MPI_IN_PLACE, &owner, 1, MPI_INT, MPI_MIN, world);
  MPI_Bcast(message, sizeof message, MPI_CHAR, owner, world);
  error->all(FLERR, message);
}
