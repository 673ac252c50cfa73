#include "liggghts/pair/fix_contact_damping.h"

#include "atom.h"
#include "comm.h"

using namespace LAMMPS_NS;

FixContactDamping::FixContactDamping(LAMMPS* lmp, int narg, char** arg)
    : FixPerBallRows(lmp, narg, arg, 1)
{
  comm_forward = 1;
}

int FixContactDamping::pack_comm(int count, int* balls, double* buffer, int, int*)
{
  for (int k = 0; k < count; ++k) buffer[k] = *row(balls[k]);
  return 1;
}

void FixContactDamping::unpack_comm(int count, int first, double* buffer)
{
  for (int k = 0; k < count; ++k) *row(first + k) = buffer[k];
}

double* FixContactDamping::up_to_date()
{
  comm->forward_comm_fix(this);
  return atom->nmax > 0 ? row(0) : nullptr;
}
