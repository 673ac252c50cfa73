#include "liggghts/pair/fix_adaptive_skin.h"

#include "atom.h"
#include "comm.h"
#include "modify.h"
#include "neighbor.h"
#include "update.h"

#include "liggghts/common/first_fix.h"
#include "liggghts/mill/fix_mill_similarity.h"

using namespace LAMMPS_NS;
namespace pairs = millscale::pairs;

FixPairMargins::FixPairMargins(LAMMPS* lmp, int narg, char** arg) : Fix(lmp, narg, arg)
{
  comm_forward = 1;
  force_reneighbor = 1;
  next_reneighbor = -1;
}

int FixPairMargins::setmask()
{
  return FixConst::POST_INTEGRATE;
}

void FixPairMargins::init()
{
  margins_ = {};  // nothing to watch, should another pair style make the lists from here on
  mill_ = first_fix<FixMillSimilarity>(modify);
}

const double* FixPairMargins::at_birth(const pairs::Balls& balls, pairs::CellGrid& grid,
                                       bool by_places)
{
  const double most = 0.5 * neighbor->skin;  // what the engine's ghosts and its own look allow
  grid.sort(balls, most);
  double fastest = 0.0;
  for (int i = 0; i < balls.owned; ++i) {
    const double* v = balls.velocity[i];
    fastest = std::max(fastest, v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  }
  MPI_Allreduce(MPI_IN_PLACE, &fastest, 1, MPI_DOUBLE, MPI_MAX, world);
  if (by_places || !(fastest > 0.0)) {
    margins_.set_same(balls, most);
    return margins_.of_balls();
  }
  pairs::TurningFrame frame;
  if (mill_) frame = {mill_->origin(), mill_->axis(), mill_->speed_now()};
  // The engine asks for a list when the fastest ball has gone as far as the largest margin.
  margins_.set_by_speed(balls, grid, frame, most, most / std::sqrt(fastest));
  birth_ = update->ntimestep;
  comm->forward_comm_fix(this);
  return margins_.of_balls();
}

void FixPairMargins::post_integrate()
{
  if (!margins_.by_speed()) return;  // so for all ranks
  const auto* x = reinterpret_cast<const double(*)[3]>(atom->x ? atom->x[0] : nullptr);
  const double time = static_cast<double>(update->ntimestep - birth_) * update->dt;
  int outrun = margins_.outrun(x, atom->nlocal, time);
  MPI_Allreduce(MPI_IN_PLACE, &outrun, 1, MPI_INT, MPI_MAX, world);
  if (outrun) next_reneighbor = update->ntimestep;
}

int FixPairMargins::pack_comm(int count, int* balls, double* buffer, int, int*)
{
  for (int k = 0; k < count; ++k) buffer[k] = margins_[balls[k]];
  return 1;
}

void FixPairMargins::unpack_comm(int count, int first, double* buffer)
{
  for (int k = 0; k < count; ++k) margins_[first + k] = buffer[k];
}
