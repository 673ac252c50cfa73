#pragma once

#include "modify.h"

namespace LAMMPS_NS {

/// Return the first fix of this class in the deck; null if there is none.
template <class Style>
Style* first_fix(const Modify* modify)
{
  for (int i = 0; i < modify->nfix; ++i)
    if (auto* found = dynamic_cast<Style*>(modify->fix[i])) return found;
  return nullptr;
}

}  // namespace LAMMPS_NS
