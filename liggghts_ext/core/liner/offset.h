#pragma once

#include <cmath>
#include <stdexcept>
#include <string>

#include "core/liner/liner.h"

namespace millscale::liner {

/// The liner shrunk by S in every length; phase and angles stay.
inline Liner scaled(const Liner& liner, double S)
{
  if (!(S > 0.0 && std::isfinite(S))) detail::reject("S", "must be > 0", S);
  return Liner(Widths{liner.radius() / S, liner.lifter_top_radius() / S,
                      liner.lifter_top_width() / S, liner.groove_width() / S, liner.lifters(),
                      liner.phase()});
}

/// The liner with every groove arc, face and top moved by `distance` towards the axis (negative:
/// away from it), corners mitred; face angles stay. Moved by a ball's radius it is the path of the
/// ball's centre, but for convex lifter edges, which the centre rounds on an arc.
/// Throws std::invalid_argument if nothing is left of lifter, groove or drum.
inline Liner offset(const Liner& liner, double distance)
{
  detail::require_finite("offset", distance);
  const double radius = liner.radius() - distance;
  if (!(radius > 0.0))
    detail::reject("offset", "must be < " + format(liner.radius()) + " m, the liner radius",
                   distance);
  if (liner.lifters() == 0) return Liner(Slopes{radius, 0.0, 0.0, 0.0, 0, liner.phase()});

  const double top_radius = liner.lifter_top_radius() - distance;
  const double half_angle_tangent = std::tan((0.25 * pi) - 0.5 * liner.face_angle());
  // The corner moves by `distance` along both normals, so across by distance * tan(half the turn).
  const double top_width = liner.lifter_top_width() + 2.0 * distance * half_angle_tangent;
  if (!(top_width > 0.0))
    throw std::invalid_argument("offset: moved by " + format(distance) +
                                " m the lifter vanishes, its top would be " + format(top_width) +
                                " m wide; accepted are offsets > " +
                                format(-0.5 * liner.lifter_top_width() / half_angle_tangent) +
                                " m (a smaller S or ball, or a wider lifter, helps)");
  return Liner(
      Slopes{radius, top_radius, top_width, liner.face_angle(), liner.lifters(), liner.phase()});
}

/// Liner of policy offset-liner: the path of a ball's centre is offset out of the physical liner,
/// shrunk by S, and offset back, so that flats and arcs of the centre path scale exactly while the
/// ball keeps its radius [m]. Derived here. At convex lifter edges the centre path is an arc of the
/// ball's radius and does not scale.
inline Liner offset_scaled(const Liner& physical, double S, double ball_radius)
{
  if (!(ball_radius >= 0.0)) detail::reject("ball radius", "must be >= 0 m", ball_radius);
  try {
    return offset(scaled(offset(physical, ball_radius), S), -ball_radius);
  } catch (const std::invalid_argument& cause) {
    throw std::invalid_argument("offset liner for S = " + format(S) + " and ball radius " +
                                format(ball_radius) + " m: " + cause.what());
  }
}

}  // namespace millscale::liner
