#pragma once

#include <string>

#include "core/liner/lifters.h"
#include "liggghts/common/keywords.h"

namespace millscale {

/// The liner as the arguments of a style state it.
class LinerArguments {
 public:
  /// The keywords, for error messages.
  static constexpr const char* keywords =
      "lifters, lifter_top_radius, lifter_top_width, groove_width, phase";

  /// Add the keywords of the liner's shape [m, rad].
  void add_to(Keywords& accepted)
  {
    accepted.add("lifters", [this](ArgumentList& list) {
      widths_.lifters = list.count("lifters", liner::most_sectors);
      given_ = true;
    });
    add_number(accepted, "lifter_top_radius", widths_.lifter_top_radius);
    add_number(accepted, "lifter_top_width", widths_.lifter_top_width);
    add_number(accepted, "groove_width", widths_.groove_width);
    add_number(accepted, "phase", widths_.phase);
  }

  /// Return whether any keyword was read; without one, the liner is a plain drum.
  bool given() const { return given_; }

  /// Return the widths of the liner in a mill of a radius [m].
  liner::Widths widths(double radius) const
  {
    liner::Widths widths = widths_;
    widths.radius = radius;
    return widths;
  }

 private:
  void add_number(Keywords& accepted, const char* key, double& value)
  {
    accepted.add(key, [this, key, &value](ArgumentList& list) {
      value = list.number(key);
      given_ = true;
    });
  }

  liner::Widths widths_;
  bool given_ = false;
};

}  // namespace millscale
