#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <stdexcept>
#include <vector>

#include "core/liner/profile.h"

namespace millscale::liner {

namespace detail {

/// Last leading face before the groove and first trailing face behind it, of a sector.
struct FacingFaces {
  Piece leading, trailing;
};

inline std::optional<FacingFaces> facing_faces(const Profile& profile)
{
  std::optional<Piece> leading, trailing;
  for (const Piece& piece : profile.pieces()) {
    if (piece.is_arc()) continue;
    if (piece.face == Face::leading) leading = piece;
    if (piece.face == Face::trailing && !trailing) trailing = piece;
  }
  if (!leading || !trailing) return std::nullopt;
  return FacingFaces{*leading, *trailing};
}

/// Tangential position of the line through a face at a distance along the sector's centre line [m].
inline double beside(const Piece& face, Local corner, double radial)
{
  return corner.tangential +
         (radial - corner.radial) * face.tangent_begin.tangential / face.tangent_begin.radial;
}

}  // namespace detail

/// Narrowest width of the liner [m]. Measured between the corners of a groove's foot, the edges of
/// its mouth, or across an arc with its centre in the cavity. A ball with a smaller diameter cannot
/// touch both sectors beside its own.
inline double narrowest_width(const Profile& profile)
{
  const std::vector<Piece>& pieces = profile.pieces();
  double width = 2.0 * profile.clear_radius();
  Local edge{}, corner{};  // the last convex edge and the last concave corner
  bool after_edge = false, after_corner = false, in_groove = false;
  for (std::size_t i = 0; i < 2 * pieces.size(); ++i) {  // twice, to see each pair of corners
    const std::size_t of_sector = i % pieces.size();
    const Piece& piece = pieces[of_sector];
    const Local begin = i < pieces.size() ? piece.begin : turned(piece.begin, profile.pitch());
    if (piece.arc_radius > 0.0) width = std::min(width, 2.0 * piece.arc_radius);
    if (piece.turn > 0.0 && !profile.nodes()[of_sector].continues) {
      if (after_corner) width = std::min(width, length(begin - corner));
      corner = begin;
      after_corner = in_groove = true;
    } else if (piece.turn < 0.0) {
      if (after_edge && in_groove) width = std::min(width, length(begin - edge));
      edge = begin;
      after_edge = true;
      after_corner = in_groove = false;
    }
  }
  return width;
}

/// Corners of the box that holds groove 0 at rest [m], in order of increasing polar angle along the
/// liner, then back along its inner side. The sides are the planes of the facing lifter faces. The
/// outer line is the tangent to the liner's radius at the sector's centre line, so that no ball in
/// the groove is missed. The inner line goes through the face's edge that is nearer to the axis.
/// Without lifters the sides are the sector's borders, and the inner line is at the clear radius.
/// Throws std::invalid_argument for a plain drum.
inline std::array<Point, 4> groove_box(const Profile& profile)
{
  if (profile.sectors() == 1)
    throw std::invalid_argument(
        "groove box: a plain drum (lifters = 0), or a shape of one sector, has no groove");
  const double outer = profile.radius();
  const Frame frame(profile.sector_angle(0));
  const auto box = [&](double inner, double outer_low, double outer_high, double inner_low,
                       double inner_high) -> std::array<Point, 4> {
    return {frame.point({outer, outer_low}), frame.point({outer, outer_high}),
            frame.point({inner, inner_high}), frame.point({inner, inner_low})};
  };
  if (const auto faces = detail::facing_faces(profile)) {
    const Local low = faces->leading.begin, high = faces->trailing.end;
    const double inner = std::min(low.radial, high.radial);
    return box(inner, detail::beside(faces->leading, low, outer),
               detail::beside(faces->trailing, high, outer),
               detail::beside(faces->leading, low, inner),
               detail::beside(faces->trailing, high, inner));
  }
  const double inner = profile.clear_radius(), slope = std::tan(0.5 * profile.pitch());
  return box(inner, -slope * outer, slope * outer, -slope * inner, slope * inner);
}

}  // namespace millscale::liner
