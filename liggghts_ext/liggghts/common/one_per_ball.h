#pragma once

#include <mpi.h>

#include <stdexcept>
#include <string>

#include "atom.h"
#include "fix.h"
#include "group.h"
#include "modify.h"

namespace LAMMPS_NS {

/// Check that no other fix of this class acts on a ball that `asker` acts on: the same group, a
/// group `all`, or a ball of any rank in both groups. Throws std::invalid_argument.
template <class Style>
void require_one_per_ball(const Style& asker, const Modify* modify, const Atom* atom,
                          const Group* group, MPI_Comm world)
{
  constexpr int all = 0;  // the engine's first group
  for (int f = 0; f < modify->nfix; ++f) {
    const auto* other = dynamic_cast<const Style*>(modify->fix[f]);
    if (!other || other == &asker) continue;
    int shared = asker.igroup == other->igroup || asker.igroup == all || other->igroup == all;
    for (int i = 0; i < atom->nlocal && !shared; ++i)
      shared = (atom->mask[i] & asker.groupbit) && (atom->mask[i] & other->groupbit);
    MPI_Allreduce(MPI_IN_PLACE, &shared, 1, MPI_INT, MPI_MAX, world);
    if (!shared) continue;
    throw std::invalid_argument(
        std::string("acts on balls of group ") + group->names[asker.igroup] + ", on which fix " +
        other->style + " (id " + other->id + ") of group " + group->names[other->igroup] +
        " acts too; leave out one of the two fixes, or give them groups that share "
        "no ball");
  }
}

}  // namespace LAMMPS_NS
