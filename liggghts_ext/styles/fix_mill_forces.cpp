#include "fix_mill_forces.h"

#include <algorithm>

#include "atom.h"
#include "error.h"
#include "memory.h"

using namespace LAMMPS_NS;

FixMillForces::FixMillForces(LAMMPS* lmp, int narg, char** arg) : Fix(lmp, narg, arg)
{
  if (narg != 3) error->fix_error(FLERR, this, "takes no arguments");
  restart_peratom = 1;
  grow_arrays(atom->nmax);
  atom->add_callback(0);
  atom->add_callback(1);
}

FixMillForces::~FixMillForces()
{
  atom->delete_callback(id, 0);
  atom->delete_callback(id, 1);
  memory->destroy(stored_);
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
    std::copy(stored_[i], stored_[i] + 3, atom->f[i]);
    std::copy(stored_[i] + 3, stored_[i] + width, atom->torque[i]);
  }
}

void FixMillForces::grow_arrays(int nmax)
{
  memory->grow(stored_, nmax, width, "mill/forces:stored");
}

void FixMillForces::copy_arrays(int i, int j, int)
{
  std::copy(stored_[i], stored_[i] + width, stored_[j]);
}

int FixMillForces::pack_exchange(int i, double* buffer)
{
  std::copy(stored_[i], stored_[i] + width, buffer);
  return width;
}

int FixMillForces::unpack_exchange(int i, double* buffer)
{
  std::copy(buffer, buffer + width, stored_[i]);
  return width;
}

int FixMillForces::pack_restart(int i, double* buffer)
{
  buffer[0] = width + 1;
  std::copy(atom->f[i], atom->f[i] + 3, buffer + 1);
  std::copy(atom->torque[i], atom->torque[i] + 3, buffer + 4);
  return width + 1;
}

void FixMillForces::unpack_restart(int i, int nth)
{
  const double* extra = atom->extra[i];
  for (int skipped = 0; skipped < nth; ++skipped) extra += static_cast<int>(*extra);
  std::copy(extra + 1, extra + 1 + width, stored_[i]);
}

int FixMillForces::size_restart(int)
{
  return width + 1;
}

int FixMillForces::maxsize_restart()
{
  return width + 1;
}
