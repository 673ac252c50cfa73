#include "liggghts/pair/fix_ball_rows.h"

#include <algorithm>

#include "comm.h"
#include "domain.h"

using namespace LAMMPS_NS;
namespace kernels = millscale::kernels;

namespace {

constexpr int sent_numbers = 10;  ///< position, velocity, spin, damping share

}  // namespace

FixBallRows::FixBallRows(LAMMPS* lmp, int narg, char** arg) : Fix(lmp, narg, arg)
{
  comm_forward = sent_numbers;
}

void FixBallRows::send_ghosts()
{
  comm->forward_comm_fix(this);
}

int FixBallRows::pack_comm(int count, int* balls, double* buffer, int crosses, int* periods)
{
  const double shift[3] = {crosses ? periods[0] * domain->xprd : 0.0,
                           crosses ? periods[1] * domain->yprd : 0.0,
                           crosses ? periods[2] * domain->zprd : 0.0};
  const kernels::Rows rows = store.rows();
  for (int k = 0; k < count; ++k, buffer += sent_numbers) {
    const kernels::PositionRow& at = rows.position[balls[k]];
    const kernels::VelocityRow& motion = rows.velocity[balls[k]];
    buffer[0] = at.x + shift[0];
    buffer[1] = at.y + shift[1];
    buffer[2] = at.z + shift[2];
    std::copy(motion.velocity, motion.velocity + 3, buffer + 3);
    std::copy(motion.spin, motion.spin + 3, buffer + 6);
    buffer[9] = motion.damping_share;
  }
  return sent_numbers;
}

void FixBallRows::unpack_comm(int count, int first, double* buffer)
{
  const kernels::Rows rows = store.rows();
  for (int i = first; i < first + count; ++i, buffer += sent_numbers) {
    kernels::PositionRow& at = rows.position[i];
    at.x = buffer[0];
    at.y = buffer[1];
    at.z = buffer[2];
    kernels::VelocityRow& motion = rows.velocity[i];  // ghosts of ghosts copy them
    std::copy(buffer + 3, buffer + 6, motion.velocity);
    std::copy(buffer + 6, buffer + 9, motion.spin);
    motion.damping_share = buffer[9];
    if (single) kernels::to_single(motion, rows.single_velocity[i]);
  }
}

double FixBallRows::memory_usage()
{
  return static_cast<double>(store.bytes());
}
