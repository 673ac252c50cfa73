#pragma once

#include <cmath>
#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/liner/lifters.h"
#include "core/liner/profile.h"

namespace millscale::liner {

namespace detail {

inline void check_scale(double S)
{
  if (!(S > 0.0 && std::isfinite(S))) reject("S", "must be > 0", S);
}

/// A piece moved by a distance along its normal, with no ends yet.
struct MovedPiece {
  Local point, tangent;  ///< of a line
  Local centre;          ///< of an arc
  double radius;         ///< of an arc; 0: a line [m]
};

inline MovedPiece moved(const Piece& piece, double distance)
{
  const double radius = piece.arc_radius - distance;  // either sign: an arc that bulges in grows
  if (piece.is_arc() && !(radius * piece.arc_radius > 0.0))
    reject("offset",
           "must be < " + format(piece.arc_radius) + " m, the radius of an arc, which vanishes",
           distance);
  return {piece.begin + distance * left_of(piece.tangent_begin), piece.tangent_begin, piece.centre,
          piece.is_arc() ? radius : 0.0};
}

/// The common point of two moved pieces that is nearest to a given point; none if the pieces do not
/// cross.
inline std::optional<Local> crossing(const MovedPiece& a, const MovedPiece& b, Local near)
{
  if (a.radius == 0.0 && b.radius == 0.0) {
    const double along = cross(b.point - a.point, b.tangent) / cross(a.tangent, b.tangent);
    return a.point + along * a.tangent;
  }
  if (a.radius == 0.0) return crossing(b, a, near);
  // Points of a's circle on a line: b itself, or the line through both points of two circles.
  const Local apart = b.centre - a.centre;
  Local base, along;
  if (b.radius == 0.0) {
    along = b.tangent;
    base = b.point + dot(a.centre - b.point, along) * along;
  } else {
    const double d2 = dot(apart, apart);
    const double share = 0.5 * (1.0 + (a.radius * a.radius - b.radius * b.radius) / d2);
    base = a.centre + share * apart;
    along = (1.0 / std::sqrt(d2)) * left_of(apart);
  }
  const Local from_centre = base - a.centre;
  const double square = a.radius * a.radius - dot(from_centre, from_centre);
  if (!(square >= 0.0)) return std::nullopt;
  const double half = std::sqrt(square);
  const Local one = base + half * along, other = base + (-half) * along;
  return length(one - near) <= length(other - near) ? one : other;
}

}  // namespace detail

/// The profile shrunk by S in every length; phase and angles stay.
inline Profile scaled(const Profile& profile, double S)
{
  detail::check_scale(S);
  std::vector<Node> nodes = profile.nodes();
  for (Node& node : nodes) {
    node.point = {node.point.radial / S, node.point.tangential / S};
    node.arc_radius /= S;
  }
  return {nodes, profile.sectors(), profile.phase()};
}

/// The profile with every piece moved by `distance` towards the cavity (negative: into the wall).
/// Corners are mitred, smooth joints stay smooth. With `distance` equal to a ball's radius the
/// result is the path of the ball's centre, except at convex edges. The centre passes a convex edge
/// on an arc. Throws std::invalid_argument if a piece vanishes.
inline Profile offset(const Profile& profile, double distance)
{
  require_finite("offset", distance);
  const std::vector<Piece>& pieces = profile.pieces();
  std::vector<Node> nodes = profile.nodes();
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const Piece& piece = pieces[i];
    const detail::MovedPiece own = detail::moved(piece, distance);
    nodes[i].arc_radius = own.radius;
    const Local straight = piece.begin + distance * left_of(piece.tangent_begin);
    nodes[i].point = straight;
    if (piece.turn == 0.0) continue;
    const Piece before =
        i > 0 ? pieces[i - 1] : detail::turned_piece(pieces.back(), -profile.pitch());
    const auto corner = detail::crossing(detail::moved(before, distance), own, straight);
    if (!corner)
      throw std::invalid_argument("offset: moved by " + format(distance) +
                                  " m two pieces of the profile no longer have a common point");
    nodes[i].point = *corner;
  }
  Profile result(nodes, profile.sectors(), profile.phase());
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const Piece &was = pieces[i], &is = result.pieces()[i];
    if (!(dot(was.is_arc() ? was.middle : was.tangent_begin,
              is.is_arc() ? is.middle : is.tangent_begin) > 0.0))
      throw std::invalid_argument("offset: moved by " + format(distance) + " m piece " +
                                  std::to_string(i) + " of the profile vanishes");
  }
  return result;
}

/// The liner shrunk by S in every length; phase and angles stay.
inline Lifters scaled(const Lifters& liner, double S)
{
  detail::check_scale(S);
  return Lifters(Widths{liner.radius() / S, liner.lifter_top_radius() / S,
                        liner.lifter_top_width() / S, liner.groove_width() / S, liner.lifters(),
                        liner.phase()});
}

/// The liner with arcs, faces and tops moved by `distance` towards the axis; face angles stay.
inline Lifters offset(const Lifters& liner, double distance)
{
  require_finite("offset", distance);
  const double radius = liner.radius() - distance;
  if (!(radius > 0.0))
    reject("offset", "must be < " + format(liner.radius()) + " m, the liner radius", distance);
  if (liner.lifters() == 0) return Lifters(Slopes{radius, 0.0, 0.0, 0.0, 0, liner.phase()});

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
  return Lifters(
      Slopes{radius, top_radius, top_width, liner.face_angle(), liner.lifters(), liner.phase()});
}

/// Liner of policy offset-liner, derived here. The path of a ball's centre is offset from the
/// physical liner, shrunk by S, and offset back. So flats and arcs of the centre path scale exactly
/// while the ball keeps its radius [m]. At convex edges the centre path is an arc of the ball's
/// radius and does not scale.
template <typename Shape>
Shape offset_scaled(const Shape& physical, double S, double ball_radius)
{
  if (!(ball_radius >= 0.0)) reject("ball radius", "must be >= 0 m", ball_radius);
  try {
    return offset(scaled(offset(physical, ball_radius), S), -ball_radius);
  } catch (const std::invalid_argument& cause) {
    throw std::invalid_argument("offset liner for S = " + format(S) + " and ball radius " +
                                format(ball_radius) + " m: " + cause.what());
  }
}

}  // namespace millscale::liner
