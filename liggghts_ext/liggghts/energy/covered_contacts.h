#pragma once

#include <stdexcept>
#include <string>

#include "force.h"
#include "modify.h"
#include "pair_gran.h"

namespace LAMMPS_NS {

/// Check that all contacts of the deck can be recorded. what: the quantity, for the error. Throws
/// std::invalid_argument.
inline void require_recorded_contacts(const Force* force, const Modify* modify,
                                      const std::string& what)
{
  if (force->pair) {
    auto* pair = dynamic_cast<PairGran*>(force->pair);
    if (!pair || !pair->contact_match("surface", "fast"))
      throw std::invalid_argument(
          "contacts of balls must be `pair_style gran ... surface fast`; other styles compute no " +
          what);
  }
  for (int i = 0; i < modify->nfix; ++i) {
    const std::string other = modify->fix[i]->style;
    if (other.rfind("wall/", 0) == 0 && other != "wall/mill")
      throw std::invalid_argument("walls must be fix wall/mill, got fix " + other +
                                  "; other walls compute no " + what);
  }
}

}  // namespace LAMMPS_NS
