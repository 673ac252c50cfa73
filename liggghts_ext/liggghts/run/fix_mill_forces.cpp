#include "liggghts/run/fix_mill_forces.h"

#include <algorithm>

#include "atom.h"
#include "error.h"

using namespace LAMMPS_NS;

namespace {

constexpr int width = 6;  // force and torque

}  // namespace

FixMillForces::FixMillForces(LAMMPS* lmp, int narg, char** arg)
    : FixPerBallRows(lmp, narg, arg, width)
{
  if (narg != 3) error->fix_error(FLERR, this, "takes no arguments");
}

int FixMillForces::setmask()
{
  return 0;
}

void FixMillForces::init()
{
  restored_ = recent_restart != 0;  // the engine clears its flag before set-up
}

void FixMillForces::setup(int)
{
  if (!restored_) return;
  restored_ = false;
  for (int i = 0; i < atom->nlocal; ++i) {
    std::copy(row(i), row(i) + 3, atom->f[i]);
    std::copy(row(i) + 3, row(i) + width, atom->torque[i]);
  }
}

int FixMillForces::pack_restart(int i, double* buffer)
{
  std::copy(atom->f[i], atom->f[i] + 3, row(i));
  std::copy(atom->torque[i], atom->torque[i] + 3, row(i) + 3);
  return FixPerBallRows::pack_restart(i, buffer);
}
