#pragma once

#include "core/liner/profile.h"

namespace millscale::liner {

/// Flat walls across the mill at two positions on its axis [m].
struct EndWalls {
  double low, high;

  /// Throws std::invalid_argument unless low < high.
  void check() const
  {
    require_finite("ends, lower", low);
    require_finite("ends, upper", high);
    if (!(low < high))
      reject("ends", "the upper end must be > the lower end " + format(low) + " m", high);
  }

  /// Overlap of a ball [m] at a position on the axis with the lower and the upper end, <= 0 without
  /// contact. An end is a half space, so a ball beyond the end is forced back.
  double lower_overlap(double place, double ball_radius) const
  {
    return ball_radius - (place - low);
  }
  double upper_overlap(double place, double ball_radius) const
  {
    return ball_radius - (high - place);
  }
};

}  // namespace millscale::liner
