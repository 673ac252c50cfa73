#pragma once

#include <algorithm>
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
  return {piece.begin + distance * left_of(piece.tangent_begin), piece.tangent_begin, piece.centre,
          piece.is_arc() ? piece.arc_radius - distance : 0.0};
}

/// The common point of two moved pieces that is nearest to a given point; none if the pieces do not
/// cross.
inline std::optional<Local> crossing(const MovedPiece& a, const MovedPiece& b, Local near)
{
  if (a.radius == 0.0 && b.radius == 0.0) {
    const double sine = cross(a.tangent, b.tangent);
    if (std::abs(sine) < 1e-12) return std::nullopt;
    return a.point + (cross(b.point - a.point, b.tangent) / sine) * a.tangent;
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

/// An outline whose pieces move along their normals and vanish.
class MovingOutline {
 public:
  explicit MovingOutline(const Profile& profile) : profile_(profile)
  {
    const std::vector<Piece>& pieces = profile.pieces();
    int group = 0;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      if (i > 0 && pieces[i].face != pieces[i - 1].face) ++group;
      groups_.push_back(group);
      left_.push_back(i);
    }
    if (pieces.front().face == pieces.back().face)
      std::replace(groups_.begin(), groups_.end(), group, 0);
  }

  /// Move all pieces by a distance [m], farther than before.
  void move_to(double distance)
  {
    distance_ = distance;
    for (std::size_t vanishing = find_vanishing(); vanishing < left_.size();
         vanishing = find_vanishing())
      leave_out(vanishing);
  }

  std::vector<Node> nodes() const
  {
    std::vector<Node> result;
    for (std::size_t k = 0; k < left_.size(); ++k) {
      Node node = profile_.nodes()[left_[k]];
      node.arc_radius = moved(pieces()[left_[k]], distance_).radius;
      node.point = *begin_of(k);
      node.continues = node.continues && follows(k);
      result.push_back(node);
    }
    return result;
  }

 private:
  const std::vector<Piece>& pieces() const { return profile_.pieces(); }
  std::size_t before(std::size_t k) const { return k > 0 ? k - 1 : left_.size() - 1; }
  /// Return whether nothing is left out before piece k of those left.
  bool follows(std::size_t k) const { return (left_[before(k)] + 1) % pieces().size() == left_[k]; }

  /// Where piece k of those left begins; nowhere if it does not meet the piece before it.
  std::optional<Local> begin_of(std::size_t k) const
  {
    const Piece& own = pieces()[left_[k]];
    const Local straight = own.begin + distance_ * left_of(own.tangent_begin);
    if (follows(k) && own.turn == 0.0) return straight;
    Piece last = pieces()[left_[before(k)]];
    if (k == 0) last = turned_piece(last, -profile_.pitch());
    const Local end = last.end + distance_ * left_of(last.tangent_end);
    return crossing(moved(last, distance_), moved(own, distance_), 0.5 * (straight + end));
  }

  /// The first piece of those left that has vanished; their number if none has.
  std::size_t find_vanishing() const
  {
    for (std::size_t k = 0; k < left_.size(); ++k) {
      const Piece& piece = pieces()[left_[k]];
      const MovedPiece own = moved(piece, distance_);
      if (piece.is_arc() && !(own.radius * piece.arc_radius > 0.0)) return k;
      if (profile_.is_drum()) continue;
      const std::size_t next = (k + 1) % left_.size();
      const auto begin = begin_of(k);
      auto end = begin_of(next);
      if (!begin || !end) return shorter(begin ? k : before(k), begin ? next : k);
      if (next == 0) end = turned(*end, profile_.pitch());
      const double way = piece.is_arc() ? cross(*begin - own.centre, *end - own.centre) * own.radius
                                        : dot(*end - *begin, own.tangent);
      const bool half_turn = piece.is_arc() && piece.half_angle > 0.25 * pi &&
                             dot(*begin - own.centre, *end - own.centre) < 0.0;
      if (!(way > 0.0) && !half_turn) return k;
    }
    return left_.size();
  }

  std::size_t shorter(std::size_t one, std::size_t other) const
  {
    return pieces()[left_[one]].length <= pieces()[left_[other]].length ? one : other;
  }

  void leave_out(std::size_t k)
  {
    const std::size_t piece = left_[k];
    left_.erase(left_.begin() + static_cast<long>(k));
    for (const std::size_t other : left_)
      if (groups_[other] == groups_[piece]) return;
    throw std::invalid_argument("offset: moved by " + format(distance_) + " m piece " +
                                std::to_string(piece) + " of the profile vanishes");
  }

  const Profile& profile_;
  double distance_ = 0.0;
  std::vector<int> groups_;        ///< number of each piece's face; faces of one lifter differ
  std::vector<std::size_t> left_;  ///< pieces that have not vanished
};

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

/// The profile with every piece moved by `distance` towards the cavity (negative: into the wall):
/// its true offset but for convex edges and, into the wall, concave corners, which stay sharp.
/// Smooth joints stay smooth. A piece that vanishes, as a fillet moved by more than its radius, is
/// left out, and its neighbours meet. With `distance` equal to a ball's radius the result is the
/// path of the ball's centre, except at convex edges. The centre passes a convex edge on an arc.
/// Throws std::invalid_argument if all pieces of a face vanish, or if the result crosses itself.
inline Profile offset(const Profile& profile, double distance)
{
  require_finite("offset", distance);
  detail::MovingOutline outline(profile);
  constexpr int parts = 100;  // pieces vanish in their order
  for (int part = 1; part <= parts; ++part) outline.move_to(distance * part / parts);
  try {
    return {outline.nodes(), profile.sectors(), profile.phase()};
  } catch (const std::invalid_argument& cause) {
    throw std::invalid_argument("offset: moved by " + format(distance) + " m: " + cause.what());
  }
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
