#pragma once

#include <algorithm>
#include <cmath>

#include "core/liner/liner.h"

namespace millscale::liner {

/// Where the liner is nearest to a point.
struct Nearest {
  double distance;  ///< to the liner, > 0 inside the cavity, < 0 inside the wall [m]
  Face face;        ///< what is nearest; of an edge between two faces the groove, then the lifter's
                    ///< side, then its top
  int sector;       ///< of the groove, or of the lifter for its faces and top
  Point point;      ///< on the liner [m]
  Point normal;     ///< unit vector into the cavity, along which the distance is measured [-]
};

namespace detail {

/// A point folded into half a sector. Mirror planes run through lifters and grooves, so the nearest
/// point of the whole liner lies in the same half sector.
struct Folded {
  int groove;   ///< index of the point's sector
  bool ahead;   ///< in the direction of rotation from the groove's centre
  Local local;  ///< in the frame of the near lifter's centre line, tangential >= 0 to the groove
};

inline int wrapped(int k, int n)
{
  return ((k % n) + n) % n;
}

inline Folded fold(const Liner& liner, Point p)
{
  const double turns = (polar_angle(p) - liner.phase()) / liner.pitch();
  const double groove = std::floor(turns + 0.5);
  const bool ahead = turns >= groove;
  const double from_lifter = 0.5 * liner.pitch() - std::abs(turns - groove) * liner.pitch();
  const double distance = length(p);
  const int n = std::max(liner.lifters(), 1);
  return {wrapped(static_cast<int>(std::fmod(groove, n)), n),
          ahead,
          {distance * std::cos(from_lifter), distance * std::sin(from_lifter)}};
}

/// In the wall, or on its surface from inside: beyond the circle, or in a lifter.
inline bool in_wall(const Liner& liner, Local p)
{
  if (std::hypot(p.radial, p.tangential) > liner.radius()) return true;
  if (liner.lifters() == 0 || !(p.radial > liner.lifter_top_radius())) return false;
  const Local corner = liner.corner();
  const double along = std::cos(liner.face_angle()), across = std::sin(liner.face_angle());
  return (p.tangential - corner.tangential) * along < (p.radial - corner.radial) * across;
}

inline Local nearest_on_segment(Local p, Local a, Local b)
{
  const double r = b.radial - a.radial, t = b.tangential - a.tangential;
  const double along =
      ((p.radial - a.radial) * r + (p.tangential - a.tangential) * t) / (r * r + t * t);
  const double share = std::clamp(along, 0.0, 1.0);
  return {a.radial + share * r, a.tangential + share * t};
}

inline Local nearest_on_arc(const Liner& liner, Local p)
{
  const double angle = std::max(std::atan2(p.tangential, p.radial), liner.foot_half_angle());
  return {liner.radius() * std::cos(angle), liner.radius() * std::sin(angle)};
}

/// Nearest point in the lifter's frame, with the liner's own normal there. `face` is groove,
/// leading (either side) or top.
struct Candidate {
  Local point, normal;
  Face face;
};

inline Candidate nearest_candidate(const Liner& liner, Local p)
{
  const Local on_arc = nearest_on_arc(liner, p);
  Candidate best{
      on_arc, {-on_arc.radial / liner.radius(), -on_arc.tangential / liner.radius()}, Face::groove};
  if (liner.lifters() == 0) return best;
  const Local foot = liner.foot(), corner = liner.corner();
  const auto distance = [p](Local q) {
    return std::hypot(p.radial - q.radial, p.tangential - q.tangential);
  };
  const Candidate face{nearest_on_segment(p, corner, foot),
                       {-std::sin(liner.face_angle()), std::cos(liner.face_angle())},
                       Face::leading};
  const Candidate top{
      {corner.radial, std::min(p.tangential, corner.tangential)}, {-1.0, 0.0}, Face::top};
  for (const Candidate& candidate : {face, top})
    if (distance(candidate.point) < distance(best.point)) best = candidate;
  return best;
}

}  // namespace detail

/// Whether a point lies in the cavity; the liner itself counts as inside.
inline bool inside(const Liner& liner, Point p)
{
  return !detail::in_wall(liner, detail::fold(liner, p).local);
}

/// Nearest point of the liner, with exact arcs. Ties are resolved the same way every time: on the
/// centre line of a groove its far side (in the direction of rotation) counts as nearer, between
/// faces the order groove, lifter's side, top.
inline Nearest nearest(const Liner& liner, Point p)
{
  const detail::Folded folded = detail::fold(liner, p);
  const detail::Candidate found = detail::nearest_candidate(liner, folded.local);
  const bool wall = detail::in_wall(liner, folded.local);

  const Local gap{folded.local.radial - found.point.radial,
                  folded.local.tangential - found.point.tangential};
  const double distance = std::hypot(gap.radial, gap.tangential);
  // Close to the liner the direction to it is lost to rounding, and its own normal is exact.
  const bool resolved = distance > 1e-9 * liner.radius();
  const double towards_cavity = wall ? -1.0 / distance : 1.0 / distance;
  const Local normal =
      resolved ? Local{gap.radial * towards_cavity, gap.tangential * towards_cavity} : found.normal;

  // Ahead of the groove's centre the near lifter is the next one, and this is its trailing side.
  const int n = std::max(liner.lifters(), 1);
  const int lifter = folded.ahead ? detail::wrapped(folded.groove + 1, n) : folded.groove;
  const double mirror = folded.ahead ? -1.0 : 1.0;
  const Frame frame(liner.lifter_angle(folded.groove + (folded.ahead ? 1 : 0)));
  const Face side = folded.ahead ? Face::trailing : Face::leading;
  return {wall ? -distance : distance, found.face == Face::leading ? side : found.face,
          found.face == Face::groove ? folded.groove : lifter,
          frame.point({found.point.radial, mirror * found.point.tangential}),
          frame.point({normal.radial, mirror * normal.tangential})};
}

}  // namespace millscale::liner
