#pragma once

#include <array>
#include <cmath>

#include "liner/nearest.h"
#include "liner/polygon.h"

namespace millscale::liner {

/// Chords for a wall, which counts all chords of a groove as one surface. That holds while two
/// neighbours' contacts lie within one Hertz patch, so for small folds; as in the engine's meshes
/// (`curvature`) a fold of 60 degrees is refused. Throws std::invalid_argument.
inline GrooveChords wall_chords(const Liner& liner, double chord_error)
{
  const GrooveChords chords = groove_chords(liner, chord_error);
  const double fold = 2.0 * chords.half_angle;
  if (chords.count > 1 && !(fold < pi / 3.0))
    detail::reject("chord error",
                   "gives " + std::to_string(chords.count) + " chords a groove that fold by " +
                       format(fold) + " rad; a wall takes folds < pi/3 rad, so chord errors < " +
                       format(liner.radius() * (1.0 - std::cos(pi / 6.0))) + " m",
                   chord_error);
  return chords;
}

/// Distance from the axis that no part of the liner falls below [m].
inline double clear_radius(const Liner& liner, const GrooveChords& chords)
{
  const double groove = chords.count > 0 ? chords.inner_radius : liner.radius();
  return liner.lifters() > 0 ? std::min(liner.lifter_top_radius(), groove) : groove;
}

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

/// A point in polar coordinates about the axis, its angle from the centre of its groove [m, rad].
struct InGroove {
  int groove;
  double distance, angle;
};

inline void touch_arc(const Liner& liner, InGroove at, Point p, double ball_radius, Touches& found)
{
  const double overlap = at.distance - (liner.radius() - ball_radius);
  if (overlap > 0.0 && (liner.lifters() == 0 || std::abs(at.angle) <= liner.groove_half_angle()))
    found.add({overlap, Face::groove, at.groove, {-p.x / at.distance, -p.z / at.distance}});
}

/// The nearest chord of the groove, where the centre projects onto it. The nearest one is that of
/// the centre's angle, since all middles have the same distance from the axis.
inline void touch_chord(const Liner& liner, const GrooveChords& chords, InGroove at,
                        double ball_radius, Touches& found)
{
  const double chord_angle = 2.0 * chords.half_angle;
  const double place = (at.angle + liner.groove_half_angle()) / chord_angle;
  const int chord = std::clamp(static_cast<int>(std::floor(place)), 0, chords.count - 1);
  const double middle = (chord + 0.5) * chord_angle - liner.groove_half_angle();
  const double beside = at.distance * std::sin(at.angle - middle);
  const double overlap =
      ball_radius - (chords.inner_radius - at.distance * std::cos(at.angle - middle));
  if (!(overlap > 0.0) || std::abs(beside) > liner.radius() * std::sin(chords.half_angle)) return;
  const Frame frame(liner.groove_angle(at.groove) + middle);
  found.add({overlap, Face::groove, at.groove, frame.point({-1.0, 0.0})});
}

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

/// Where a ball of a radius [m] at a point of the cavity touches the liner, with exact arcs or the
/// given chords: one contact for each surface the centre projects onto, so two at the concave
/// corner of groove and face, and the nearest point at a convex edge. The chords of a groove stand
/// for one smooth arc and are one surface: the nearest counts. Counting each would double the
/// force, at a jump, over every joint. `p` is in the frame of the mill at rest.
inline Touches touches(const Liner& liner, Point p, double ball_radius,
                       const GrooveChords& chords = {})
{
  Touches found;
  const double distance = length(p);
  if (distance < clear_radius(liner, chords) - ball_radius) return found;

  const int n = std::max(liner.lifters(), 1);
  const double turns = (polar_angle(p) - liner.phase()) / liner.pitch();
  const int groove = detail::wrapped(static_cast<int>(std::lround(turns)), n);
  const detail::InGroove at{groove, distance, std::remainder(turns, 1.0) * liner.pitch()};
  if (chords.count > 0)
    detail::touch_chord(liner, chords, at, ball_radius, found);
  else
    detail::touch_arc(liner, at, p, ball_radius, found);
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
