#pragma once

#include <cmath>

#include "core/liner/profile.h"

namespace millscale::liner {

/// The point of the liner that is nearest to a given point.
struct Nearest {
  double distance;  ///< to the liner, > 0 inside the cavity, < 0 inside the wall [m]
  Face face;        ///< nearest face; at an edge between two faces the groove, then the lifter's
                    ///< side, then its top
  int sector;       ///< of the groove, or of the lifter for its faces and top
  Point point;      ///< on the liner [m]
  Point normal;     ///< unit vector into the cavity, along which the distance is measured [-]
};

namespace detail {

struct NearestPiece {
  const PlacedPiece* placed;
  OnPiece on;
  double distance;  ///< as in Nearest [m]
};

/// Return whether a point is on the wall's side, seen from the nearest point of the liner. If the
/// nearest point is a corner, the point is in the cavity at a convex edge and in the wall at a
/// concave corner.
inline bool in_wall(const PlacedPiece& placed, const OnPiece& on, Local p)
{
  const double turn = on.is_begin ? placed.piece.turn : on.is_end ? placed.turn_end : 0.0;
  if (turn != 0.0) return turn > 0.0;
  const Piece& piece = placed.piece;
  if (!piece.is_arc()) return cross(piece.tangent_begin, p - piece.begin) < 0.0;
  return (length(p - piece.centre) - std::abs(piece.arc_radius)) * piece.arc_radius > 0.0;
}

/// Search for the piece nearest to a point, in the frame of the sector that holds the point.
class NearestSearch {
 public:
  NearestSearch(const Profile& profile, Local p) : p_(p), tie_(1e-14 * profile.radius()) {}

  void look_at(const PlacedPiece& placed)
  {
    const OnPiece on = nearest_on(placed.piece, p_);
    const double distance = length(p_ - on.point);
    if (distance < best_.distance - tie_) best_ = {&placed, on, distance};
  }

  /// The nearest piece, with its signed distance.
  NearestPiece found() const
  {
    NearestPiece best = best_;
    if (best.placed && in_wall(*best.placed, best.on, p_)) best.distance = -best.distance;
    return best;
  }

 private:
  Local p_;
  double tie_;
  NearestPiece best_{nullptr, {}, INFINITY};
};

/// The piece nearest to a point, in the frame of the sector that holds the point.
inline NearestPiece nearest_piece(const Profile& profile, Local p)
{
  NearestSearch search(profile, p);
  for (const PlacedPiece& placed : profile.around()) search.look_at(placed);
  return search.found();
}

/// Unit vector into the cavity at a point of a piece.
inline Local normal_at(const Piece& piece, Local point)
{
  return piece.is_arc() ? (-1.0 / piece.arc_radius) * (point - piece.centre)
                        : left_of(piece.tangent_begin);
}

}  // namespace detail

/// Nearest point of the liner. Ties always have the same result. On the centre line of a groove the
/// far side (in the direction of rotation) counts as nearer. Between faces the order is groove,
/// lifter's side, top.
inline Nearest nearest(const Profile& profile, Point p)
{
  const int sector = profile.sector_at(polar_angle(p));
  const Frame frame(profile.sector_angle(sector));
  const Local local = frame.local(p);
  const detail::NearestPiece found = detail::nearest_piece(profile, local);
  const Piece& piece = found.placed->piece;
  // Close to the liner the direction to the nearest point is lost to rounding; the liner's normal
  // is exact.
  const bool resolved = std::abs(found.distance) > 1e-9 * profile.radius();
  const Local normal = resolved ? (1.0 / found.distance) * (local - found.on.point)
                                : detail::normal_at(piece, found.on.point);
  return {found.distance, piece.face, profile.groove(piece, sector + found.placed->offset),
          frame.point(found.on.point), frame.point(normal)};
}

/// Return whether a point lies in the cavity or on the liner.
inline bool inside(const Profile& profile, Point p)
{
  const Frame frame(profile.sector_angle(profile.sector_at(polar_angle(p))));
  return detail::nearest_piece(profile, frame.local(p)).distance >= 0.0;
}

}  // namespace millscale::liner
