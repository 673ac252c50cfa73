#pragma once

#include <string>

#include "core/liner/lifters.h"
#include "liggghts/common/argument_list.h"

namespace millscale {

/// The liner as the arguments of a style state it.
class LinerArguments {
 public:
  /// Keywords, for the error that names what a style accepts.
  static constexpr const char* keywords =
      "lifters, lifter_top_radius, lifter_top_width, groove_width, phase";

  /// Reads the value of a keyword of the liner's shape [m, rad]; false if it is none.
  bool read(const std::string& key, ArgumentList& list)
  {
    if (key == "lifters")
      widths_.lifters = list.count(key, liner::most_sectors);
    else if (key == "lifter_top_radius")
      widths_.lifter_top_radius = list.number(key);
    else if (key == "lifter_top_width")
      widths_.lifter_top_width = list.number(key);
    else if (key == "groove_width")
      widths_.groove_width = list.number(key);
    else if (key == "phase")
      widths_.phase = list.number(key);
    else
      return false;
    given_ = true;
    return true;
  }

  /// Whether any keyword was read; if not, the liner is a plain drum.
  bool given() const { return given_; }

  /// The liner in a mill of a radius [m].
  liner::Widths widths(double radius) const
  {
    liner::Widths widths = widths_;
    widths.radius = radius;
    return widths;
  }

 private:
  liner::Widths widths_;
  bool given_ = false;
};

}  // namespace millscale
