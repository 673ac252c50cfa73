#pragma once

#include <array>
#include <cmath>

#include "liner/nearest.h"

namespace millscale::liner {

/// A place where a ball touches the liner.
struct Touch {
  double overlap;  ///< > 0 [m]
  Face face;       ///< of a lifter's edge: its side
  int sector;      ///< of the groove, or of the lifter for its faces and top
  Point normal;    ///< from the liner to the ball's centre, unit vector
};

/// All touches of a ball, at most one of each: groove, the two sides of the groove, a top.
struct Touches {
  int count = 0;
  std::array<Touch, 4> touch;

  void add(const Touch& t) { touch[static_cast<std::size_t>(count++)] = t; }
};

namespace detail {

/// The side of one lifter, in the frame of its centre line with the tangential axis towards the
/// groove: a touch of the face where the ball's centre projects onto it, or of the convex edge at
/// its top, or none. `edge` tells which.
struct SideTouch {
  double distance = 0.0;
  Local normal{0.0, 0.0};
  bool near = false;
};

inline SideTouch touch_of_side(const Liner& liner, Local p, double ball_radius)
{
  const Local corner = liner.corner(), foot = liner.foot();
  const double r = foot.radial - corner.radial, t = foot.tangential - corner.tangential;
  const double share =
      ((p.radial - corner.radial) * r + (p.tangential - corner.tangential) * t) / (r * r + t * t);
  SideTouch side;
  if (share > 1.0) return side;  // beyond the foot: the groove's arc has the contact
  if (share >= 0.0) {
    const double along = std::cos(liner.face_angle()), across = std::sin(liner.face_angle());
    side.normal = {-across, along};
    side.distance =
        (p.tangential - corner.tangential) * along - (p.radial - corner.radial) * across;
  } else {
    const Local gap{p.radial - corner.radial, p.tangential - corner.tangential};
    if (gap.tangential <= 0.0) return side;  // above the flat: the top has the contact
    side.distance = std::hypot(gap.radial, gap.tangential);
    side.normal = {gap.radial / side.distance, gap.tangential / side.distance};
  }
  side.near = side.distance < ball_radius;
  return side;
}

}  // namespace detail

/// Where a ball of a radius [m] at a point of the cavity touches the liner, with exact arcs: one
/// contact for each concave surface the centre projects onto, so two at a concave corner, and the
/// nearest point at a convex edge. `p` is in the frame of the mill at rest.
inline Touches touches(const Liner& liner, Point p, double ball_radius)
{
  Touches found;
  const double distance = length(p);
  const double inner = liner.lifters() > 0 ? liner.lifter_top_radius() : liner.radius();
  if (distance < inner - ball_radius) return found;

  const int n = std::max(liner.lifters(), 1);
  const double turns = (polar_angle(p) - liner.phase()) / liner.pitch();
  const int groove = detail::wrapped(static_cast<int>(std::lround(turns)), n);
  const double from_groove = std::remainder(turns, 1.0) * liner.pitch();
  if (distance > liner.radius() - ball_radius &&
      (liner.lifters() == 0 || std::abs(from_groove) <= liner.groove_half_angle()))
    found.add({distance - (liner.radius() - ball_radius),
               Face::groove,
               groove,
               {-p.x / distance, -p.z / distance}});
  if (liner.lifters() == 0) return found;

  for (const int side : {0, 1}) {  // the lifter behind the groove's centre, and the one ahead
    const int lifter = detail::wrapped(groove + side, n);
    const Frame frame(liner.lifter_angle(groove + side));
    Local local = frame.local(p);
    const double mirror = side == 0 ? 1.0 : -1.0;
    local.tangential *= mirror;
    const detail::SideTouch touch = detail::touch_of_side(liner, local, ball_radius);
    const auto in_section = [&](Local normal) {
      const Point origin = frame.point({0.0, 0.0});
      return frame.point({normal.radial, mirror * normal.tangential}) - origin;
    };
    if (touch.near)
      found.add({ball_radius - touch.distance, side == 0 ? Face::leading : Face::trailing, lifter,
                 in_section(touch.normal)});
    else if (local.tangential <= liner.corner().tangential &&
             local.radial > liner.lifter_top_radius() - ball_radius)
      found.add({ball_radius - (liner.lifter_top_radius() - local.radial), Face::top, lifter,
                 in_section({-1.0, 0.0})});
  }
  return found;
}

}  // namespace millscale::liner
