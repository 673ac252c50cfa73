#pragma once

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "core/liner/frame.h"
#include "core/math/checks.h"
#include "core/math/constants.h"
#include "core/math/format.h"

namespace millscale::liner {

/// Part of the liner that a piece belongs to. The leading face of a lifter lifts the balls of its
/// groove. A shape without lifters is groove all over.
enum class Face { groove = 0, leading = 1, top = 2, trailing = 3 };

/// Where a piece of the profile begins; it ends at the next node.
struct Node {
  Local point;              ///< in the frame of the sector's centre line [m]
  double arc_radius = 0.0;  ///< 0: line; > 0: arc with its centre on the cavity's side; < 0: on the
                            ///< wall's side [m]. An arc is at most half a turn.
  Face face = Face::groove;  ///< of the piece
  int ahead = 0;             ///< 1: the piece belongs to the first lifter of the next sector
  bool continues = false;    ///< no corner here: the fold is between chords of one arc
  bool corner = false;  ///< a corner here, whatever the fold: in a turn too narrow for the ball
};

/// A line or an arc of the profile in the direction of rotation; the cavity is on its left.
struct Piece {
  Local begin, end;                  ///< in the frame of the sector's centre line [m]
  Local tangent_begin, tangent_end;  ///< unit vectors along the piece
  double length;                     ///< [m]
  double arc_radius;                 ///< as in Node [m]
  Local centre, middle;              ///< of an arc: its centre [m], unit vector to its middle
  double half_angle;                 ///< half the angle an arc spans [rad]
  Face face;
  int ahead;          ///< as in Node
  int groove = 0;     ///< its groove or lifter, counted from the first of the sector: -1, 0, 1 ...
  double turn = 0.0;  ///< angle by which the profile turns to the left at the piece's beginning;
                      ///< > 0: concave corner, < 0: convex edge, 0: smooth [rad]
  bool corner = false;    ///< it begins at a concave corner, where a surface ends
  int surface = 0;        ///< number of its surface in the sector
  int surface_ahead = 0;  ///< 1: it belongs to that surface of the next sector

  bool is_arc() const { return arc_radius != 0.0; }
};

namespace detail {

inline std::string between(double low, double high, const char* unit)
{
  return "must be > " + format(low) + " and < " + format(high) + " " + unit;
}

inline void require_between(const char* what, double low, double high, double got,
                            const char* reason)
{
  if (!(got > low && got < high)) reject(what, between(low, high, "m") + " (" + reason + ")", got);
}

/// Smallest turn of the profile's direction that does not count as smooth [rad].
inline constexpr double smooth_turn = 1e-6;
/// Smallest concave fold that counts as a corner, and smallest convex one that counts as the edge
/// of a groove [rad]. Before a fold f a ball of radius a that overlaps one side by d projects onto
/// the other side at a distance of (a - d) / cos f. If this is less than a, a second contact would
/// begin with an overlap, and the force would jump. So f^2 > 2 d / a is needed; this is d < 0.045
/// a. Derived here.
inline constexpr double smallest_corner = 0.3;

inline Piece line(Local begin, Local end)
{
  const Local along = end - begin;
  const double size = length(along);
  if (!(size > 0.0)) throw std::invalid_argument("profile: two nodes must not be the same point");
  const Local tangent = (1.0 / size) * along;
  return {begin, end, tangent, tangent, size, 0.0, {}, {}, 0.0, Face::groove, 0};
}

inline Piece arc(Local begin, Local end, double arc_radius)
{
  const Local chord = end - begin;
  const double half_chord = 0.5 * length(chord), radius = std::abs(arc_radius);
  if (!(half_chord > 0.0 && half_chord <= radius * (1.0 + 1e-12)))
    reject("profile, arc radius", "must be >= half the arc's chord, " + format(half_chord) + " m",
           radius);
  const double half_angle = std::asin(std::min(half_chord / radius, 1.0));
  const double side = arc_radius > 0.0 ? 1.0 : -1.0;
  const Local to_cavity = (0.5 / half_chord) * left_of(chord);
  Local centre = 0.5 * (begin + end) + (side * radius * std::cos(half_angle)) * to_cavity;
  if (length(centre) < 1e-12 * radius) centre = {0.0, 0.0};  // an arc around the axis
  const auto tangent = [&](Local point) { return (side / radius) * left_of(point - centre); };
  return {begin,      end,    tangent(begin),      tangent(end), 2.0 * radius * half_angle,
          arc_radius, centre, (-side) * to_cavity, half_angle,   Face::groove,
          0};
}

/// A full circle around the axis, from a point on it.
inline Piece circle(Local begin, double radius)
{
  if (!(radius > 0.0) || std::abs(length(begin) - radius) > 1e-12 * radius)
    throw std::invalid_argument("profile: a single piece must be a circle around the axis");
  const Local out = (1.0 / radius) * begin, tangent = left_of(out);
  return {begin,      begin, tangent,      tangent, 2.0 * pi * radius, radius, {0.0, 0.0},
          -1.0 * out, pi,    Face::groove, 0};
}

/// The piece as seen from a frame behind its own by an angle [rad].
inline Piece turned_piece(Piece piece, double angle)
{
  for (Local* v : {&piece.begin, &piece.end, &piece.tangent_begin, &piece.tangent_end,
                   &piece.centre, &piece.middle})
    *v = turned(*v, angle);
  return piece;
}

/// Point of a piece nearest to a given point, and which end of the piece it is, if any.
struct OnPiece {
  Local point;
  bool is_begin = false, is_end = false;
};

inline OnPiece nearest_on(const Piece& piece, Local p)
{
  if (!piece.is_arc()) {
    const double along = dot(p - piece.begin, piece.tangent_begin);
    if (along <= 0.0) return {piece.begin, true, false};
    if (along >= piece.length) return {piece.end, false, true};
    return {piece.begin + along * piece.tangent_begin};
  }
  const Local arm = p - piece.centre;
  const double distance = length(arm);
  const double radius = std::abs(piece.arc_radius);
  if (distance == 0.0) return {piece.centre + radius * piece.middle};
  if (dot(arm, piece.middle) >= distance * std::cos(piece.half_angle))
    return {piece.centre + (radius / distance) * arm};
  const bool begin = length(p - piece.begin) <= length(p - piece.end);
  return {begin ? piece.begin : piece.end, begin, !begin};
}

}  // namespace detail

}  // namespace millscale::liner
