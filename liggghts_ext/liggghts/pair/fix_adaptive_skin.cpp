#include "liggghts/pair/fix_adaptive_skin.h"

#include "atom.h"
#include "comm.h"
#include "modify.h"
#include "neighbor.h"
#include "update.h"

#include "liggghts/common/first_fix.h"
#include "liggghts/mill/fix_mill_similarity.h"

using namespace LAMMPS_NS;
namespace neighbor = millscale::neighbor;

FixAdaptiveSkin::FixAdaptiveSkin(LAMMPS* lmp, int narg, char** arg) : Fix(lmp, narg, arg)
{
  comm_forward = 1;
  force_reneighbor = 1;
  next_reneighbor = -1;
}

int FixAdaptiveSkin::setmask()
{
  return FixConst::POST_INTEGRATE;
}

void FixAdaptiveSkin::init()
{
  if (!in_use_) skin_ = {};  // another pair style makes the lists from now on
  in_use_ = false;
  mill_fix_ = first_fix<FixMillSimilarity>(modify);
}

const double* FixAdaptiveSkin::at_build(const neighbor::Particles& particles, bool by_position_only)
{
  const double most = 0.5 * neighbor->skin;  // limit of the engine's ghosts and of its own check
  double fastest = 0.0;
  for (int i = 0; i < particles.nlocal; ++i) {
    const double* v = particles.velocity[i];
    fastest = std::max(fastest, v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  }
  MPI_Allreduce(MPI_IN_PLACE, &fastest, 1, MPI_DOUBLE, MPI_MAX, world);
  if (by_position_only || !(fastest > 0.0)) {
    skin_.set_uniform(particles, most);
    return skin_.data();
  }
  neighbor::TurningFrame frame;
  if (mill_fix_) frame = {mill_fix_->origin(), mill_fix_->axis(), mill_fix_->speed_now()};
  // The engine's own check requests a list when the fastest particle has moved by the largest skin.
  skin_.set_by_speed(particles, frame, most, most / std::sqrt(fastest));
  build_step_ = update->ntimestep;
  comm->forward_comm_fix(this);
  return skin_.data();
}

void FixAdaptiveSkin::post_integrate()
{
  if (!skin_.by_speed()) return;  // the same on all ranks
  const auto* x = reinterpret_cast<const double(*)[3]>(atom->x ? atom->x[0] : nullptr);
  int exceeded = skin_.exceeded(x, atom->nlocal, time_since_build(update->ntimestep));
  MPI_Allreduce(MPI_IN_PLACE, &exceeded, 1, MPI_INT, MPI_MAX, world);
  if (exceeded) next_reneighbor = update->ntimestep;
}

double FixAdaptiveSkin::time_since_build(bigint step) const
{
  return static_cast<double>(step - build_step_) * update->dt;
}

int FixAdaptiveSkin::pack_comm(int count, int* particles, double* buffer, int, int*)
{
  for (int k = 0; k < count; ++k) buffer[k] = skin_[particles[k]];
  return 1;
}

void FixAdaptiveSkin::unpack_comm(int count, int first, double* buffer)
{
  for (int k = 0; k < count; ++k) skin_[first + k] = buffer[k];
}
