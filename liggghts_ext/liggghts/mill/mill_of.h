#pragma once

#include <stdexcept>
#include <string>

#include "modify.h"

#include "liggghts/mill/fix_mill_similarity.h"

namespace LAMMPS_NS {

/// The fix mill/similarity that the keyword `mill` of a style names. Throws std::invalid_argument
/// if the id is of none.
inline FixMillSimilarity* mill_of(Modify* modify, const std::string& id)
{
  auto* mill = dynamic_cast<FixMillSimilarity*>(modify->find_fix_id(id.c_str()));
  if (!mill)
    throw std::invalid_argument("mill: '" + id +
                                "' is not the id of a fix mill/similarity; define that fix first");
  return mill;
}

}  // namespace LAMMPS_NS
