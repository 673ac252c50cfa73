#include "liggghts/pair/fix_ball_rows.h"

#include <mpi.h>

#include <algorithm>
#include <cstddef>

#include "comm.h"
#include "domain.h"

using namespace LAMMPS_NS;
namespace kernels = millscale::kernels;

namespace {

constexpr std::size_t sent_numbers = 10;  ///< position, velocity, spin, damping share

// Protected members of the engine, named through a derived class as the language allows.
struct Swaps : Comm {
  static constexpr int Comm::*count = &Swaps::nswap;
  static constexpr int* Comm::*to = &Swaps::sendproc;
  static constexpr int* Comm::*from = &Swaps::recvproc;
  static constexpr int* Comm::*sent = &Swaps::sendnum;
  static constexpr int* Comm::*received = &Swaps::recvnum;
  static constexpr int* Comm::*first = &Swaps::firstrecv;
  static constexpr int** Comm::*balls = &Swaps::sendlist;
  static constexpr int* Comm::*crosses = &Swaps::pbc_flag;
  static constexpr int** Comm::*periods = &Swaps::pbc;
};

}  // namespace

/// One exchange of the engine: the balls sent, and where the ghosts received begin.
struct FixBallRows::Swap {
  int to, from, sent, received, first;
  const int* balls;
  bool crosses;     ///< a periodic boundary
  double shift[3];  ///< of the positions, if so [m]

  kernels::PositionRow moved(kernels::PositionRow at) const
  {
    if (!crosses) return at;
    return {at.x + shift[0], at.y + shift[1], at.z + shift[2], at.radius};
  }
};

FixBallRows::FixBallRows(LAMMPS* lmp, int narg, char** arg) : Fix(lmp, narg, arg) {}

void FixBallRows::send_ghosts()
{
  for (int k = 0; k < comm->*Swaps::count; ++k) {
    const int* periods = (comm->*Swaps::periods)[k];
    const Swap swap{
        (comm->*Swaps::to)[k],
        (comm->*Swaps::from)[k],
        (comm->*Swaps::sent)[k],
        (comm->*Swaps::received)[k],
        (comm->*Swaps::first)[k],
        (comm->*Swaps::balls)[k],
        (comm->*Swaps::crosses)[k] != 0,
        {periods[0] * domain->xprd, periods[1] * domain->yprd, periods[2] * domain->zprd}};
    if (swap.to == comm->me)
      copy_within_rank(swap);
    else
      exchange_with_rank(swap);
  }
}

void FixBallRows::copy_within_rank(const Swap& swap)
{
  constexpr int ahead = 8;
  const kernels::Rows rows = store.rows();
  for (int k = 0; k < swap.sent; ++k) {
    const int i = swap.balls[k], ghost = swap.first + k;
    if (k + ahead < swap.sent) {
      __builtin_prefetch(rows.position + swap.balls[k + ahead]);
      __builtin_prefetch(rows.velocity + swap.balls[k + ahead]);
    }
    rows.position[ghost] = swap.moved(rows.position[i]);
    rows.velocity[ghost] = rows.velocity[i];  // ghosts of ghosts copy them
    if (single) rows.single_velocity[ghost] = rows.single_velocity[i];
  }
}

void FixBallRows::exchange_with_rank(const Swap& swap)
{
  const kernels::Rows rows = store.rows();
  sent_.resize(swap.sent * sent_numbers);
  received_.resize(swap.received * sent_numbers);
  double* to = sent_.data();
  for (int k = 0; k < swap.sent; ++k, to += sent_numbers) {
    const kernels::PositionRow at = swap.moved(rows.position[swap.balls[k]]);
    const kernels::VelocityRow& motion = rows.velocity[swap.balls[k]];
    to[0] = at.x;
    to[1] = at.y;
    to[2] = at.z;
    std::copy(motion.velocity, motion.velocity + 3, to + 3);
    std::copy(motion.spin, motion.spin + 3, to + 6);
    to[9] = motion.damping_share;
  }
  MPI_Request request = MPI_REQUEST_NULL;
  if (swap.received > 0)
    MPI_Irecv(received_.data(), static_cast<int>(received_.size()), MPI_DOUBLE, swap.from, 0, world,
              &request);
  if (swap.sent > 0)
    MPI_Send(sent_.data(), static_cast<int>(sent_.size()), MPI_DOUBLE, swap.to, 0, world);
  MPI_Wait(&request, MPI_STATUS_IGNORE);
  const double* from = received_.data();
  for (int i = swap.first; i < swap.first + swap.received; ++i, from += sent_numbers) {
    kernels::PositionRow& at = rows.position[i];
    at.x = from[0];
    at.y = from[1];
    at.z = from[2];
    kernels::VelocityRow& motion = rows.velocity[i];
    std::copy(from + 3, from + 6, motion.velocity);
    std::copy(from + 6, from + 9, motion.spin);
    motion.damping_share = from[9];
    if (single) kernels::to_single(motion, rows.single_velocity[i]);
  }
}

double FixBallRows::memory_usage()
{
  return static_cast<double>(store.bytes()) +
         static_cast<double>((sent_.capacity() + received_.capacity()) * sizeof(double));
}
