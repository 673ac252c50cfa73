#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "core/liner/liner.h"

namespace millscale::liner {

/// Width of a groove between the top corners of its two lifters [m].
inline double groove_mouth_width(const Liner& liner)
{
  const double half_pitch = 0.5 * liner.pitch();
  const Local corner = liner.corner();
  return 2.0 * (corner.radial * std::sin(half_pitch) - corner.tangential * std::cos(half_pitch));
}

/// Width of a groove where it is narrowest, at its foot or at its mouth [m].
inline double narrowest_groove_width(const Liner& liner)
{
  return std::min(liner.groove_width(), groove_mouth_width(liner));
}

/// Corners of the box that holds groove 0 at rest [m], in order of increasing polar angle along the
/// liner, then back along the lifter tops: between the planes of the facing lifter faces, from the
/// tangent to the groove's arc at its middle (so that no ball in the groove is missed) to the line
/// through the top corners. Throws std::invalid_argument for a plain drum.
inline std::array<Point, 4> groove_box(const Liner& liner)
{
  if (liner.lifters() == 0)
    throw std::invalid_argument("groove box: a plain drum (lifters = 0) has no groove");
  const double half_pitch = 0.5 * liner.pitch();
  const Local corner = liner.corner();
  const double inner =
      corner.radial * std::cos(half_pitch) + corner.tangential * std::sin(half_pitch);
  const double inner_half = 0.5 * groove_mouth_width(liner);
  // Seen from the groove's centre line the faces open or close by half the pitch.
  const double opening = std::tan(half_pitch - liner.face_angle());
  const double outer_half = inner_half + (liner.radius() - inner) * opening;
  const Frame frame(liner.groove_angle(0));
  return {frame.point({liner.radius(), -outer_half}), frame.point({liner.radius(), outer_half}),
          frame.point({inner, inner_half}), frame.point({inner, -inner_half})};
}

}  // namespace millscale::liner
