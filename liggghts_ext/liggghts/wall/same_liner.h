#pragma once

#include <cmath>
#include <stdexcept>
#include <string>

#include "modify.h"

#include "core/liner/liner.h"
#include "core/math/format.h"
#include "liggghts/wall/fix_wall_mill.h"

namespace LAMMPS_NS {

/// Compares a style's liner with that of each fix wall/mill of the same mill. Throws
/// std::invalid_argument with both numbers where they differ by more than rounding of a deck.
class LinerOfWalls {
 public:
  LinerOfWalls(const Modify* modify, const std::string& mill_id)
      : modify_(modify), mill_id_(mill_id)
  {
  }

  /// What every style with a liner needs to know of it: the sectors and the lifters' tops.
  void require_same_lifters(const millscale::liner::Widths& ours) const
  {
    for_each([&](const FixWallMill& wall) {
      const millscale::liner::Widths& its = wall.widths();
      require("lifters", ours.lifters, its.lifters, wall);
      require("lifter_top_radius", ours.lifter_top_radius, its.lifter_top_radius, wall);
      require("phase", ours.phase, its.phase, wall);
    });
  }

  void require_same(const millscale::liner::Widths& ours) const
  {
    require_same_lifters(ours);
    for_each([&](const FixWallMill& wall) {
      const millscale::liner::Widths& its = wall.widths();
      require("lifter_top_width", ours.lifter_top_width, its.lifter_top_width, wall);
      require("groove_width", ours.groove_width, its.groove_width, wall);
    });
  }

 private:
  template <class Check>
  void for_each(const Check& check) const
  {
    for (int i = 0; i < modify_->nfix; ++i) {
      const auto* wall = dynamic_cast<const FixWallMill*>(modify_->fix[i]);
      if (wall && wall->mill_id() == mill_id_) check(*wall);
    }
  }

  static void require(const char* key, double ours, double its, const FixWallMill& wall)
  {
    if (std::abs(ours - its) <= 1e-9 * std::fmax(1.0, std::abs(its))) return;
    throw std::invalid_argument(std::string(key) + ": got " + millscale::format(ours) +
                                ", fix wall/mill (id " + wall.id + ") of the same mill has " +
                                millscale::format(its) + "; give both the same liner");
  }

  const Modify* modify_;
  std::string mill_id_;
};

}  // namespace LAMMPS_NS
