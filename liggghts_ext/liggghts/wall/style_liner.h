#pragma once

#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>

#include "modify.h"

#include "core/liner/lifters.h"
#include "core/math/format.h"
#include "liggghts/mill/fix_mill_similarity.h"
#include "liggghts/mill/liner_arguments.h"
#include "liggghts/wall/fix_wall_mill.h"

namespace LAMMPS_NS {

/// The liner of a style: the liner that its fix mill/similarity states, if any. Older decks state
/// the liner in the arguments of each style. All liners of a mill, stated by its fix or by
/// arguments, must agree within rounding of a deck.
class StyleLiner {
 public:
  StyleLiner(const Modify* modify, const FixMillSimilarity& mill) : modify_(modify), mill_(mill) {}

  /// The liner of a wall with these arguments. Throws std::invalid_argument with both numbers if
  /// the arguments differ from the mill's liner.
  std::shared_ptr<const millscale::liner::Profile> of_wall(
      const millscale::LinerArguments& arguments) const
  {
    const millscale::liner::Widths ours = arguments.widths(mill_.scaled().mill.radius);
    if (!mill_.states_liner()) return std::make_shared<const millscale::liner::Lifters>(ours);
    if (arguments.given()) require_same(ours, widths_of_mill(), name_of(mill_));
    return mill_.liner();
  }

  /// The liner of a style that is not a wall; it must agree with the liner of every wall.
  std::shared_ptr<const millscale::liner::Profile> of(
      const millscale::LinerArguments& arguments) const
  {
    auto liner = of_wall(arguments);
    if (mill_.states_liner()) return liner;
    const millscale::liner::Widths ours = arguments.widths(mill_.scaled().mill.radius);
    for_each_wall(
        [&](const FixWallMill& wall) { require_same(ours, wall.widths(), name_of(wall)); });
    return liner;
  }

  /// Check the arguments of a style that needs only the sectors and the lifters' tops.
  void require_same_lifters(const millscale::liner::Widths& ours) const
  {
    if (mill_.states_liner()) {
      require_same_lifters(ours, widths_of_mill(), name_of(mill_));
      return;
    }
    for_each_wall(
        [&](const FixWallMill& wall) { require_same_lifters(ours, wall.widths(), name_of(wall)); });
  }

 private:
  using Widths = millscale::liner::Widths;

  const Widths& widths_of_mill() const
  {
    if (!mill_.widths())
      throw std::invalid_argument(name_of(mill_) +
                                  " has its liner from a profile file; leave out the arguments " +
                                  millscale::LinerArguments::keywords);
    return *mill_.widths();
  }

  static std::string name_of(const Fix& fix)
  {
    return std::string("fix ") + fix.style + " (id " + fix.id + ")";
  }

  template <class Check>
  void for_each_wall(const Check& check) const
  {
    for (int i = 0; i < modify_->nfix; ++i) {
      const auto* wall = dynamic_cast<const FixWallMill*>(modify_->fix[i]);
      if (wall && wall->mill_id() == mill_.id) check(*wall);
    }
  }

  static void require_same_lifters(const Widths& ours, const Widths& its, const std::string& whose)
  {
    require("lifters", ours.lifters, its.lifters, whose);
    require("lifter_top_radius", ours.lifter_top_radius, its.lifter_top_radius, whose);
    require("phase", ours.phase, its.phase, whose);
  }

  static void require_same(const Widths& ours, const Widths& its, const std::string& whose)
  {
    require_same_lifters(ours, its, whose);
    require("lifter_top_width", ours.lifter_top_width, its.lifter_top_width, whose);
    require("groove_width", ours.groove_width, its.groove_width, whose);
  }

  static void require(const char* key, double ours, double its, const std::string& whose)
  {
    if (std::abs(ours - its) <= 1e-9 * std::fmax(1.0, std::abs(its))) return;
    throw std::invalid_argument(std::string(key) + ": got " + millscale::format(ours) + ", " +
                                whose + " of the same mill has " + millscale::format(its) +
                                "; state the liner once, in fix mill/similarity");
  }

  const Modify* modify_;
  const FixMillSimilarity& mill_;
};

}  // namespace LAMMPS_NS
