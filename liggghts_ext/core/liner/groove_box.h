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

/// A line beside a groove: from the beginning of the first face to the end of the last face [m].
struct SideLine {
  Local begin, end, along;

  SideLine seen_from(double angle) const
  {
    if (angle == 0.0) return *this;
    return {turned(begin, -angle), turned(end, -angle), turned(along, -angle)};
  }

  /// Tangential position at a distance along the sector's centre line [m].
  double at(Local corner, double radial) const
  {
    return corner.tangential + (radial - corner.radial) * along.tangential / along.radial;
  }
};

/// The straight leading faces behind the groove of the first lifter, and the straight trailing
/// faces before it.
struct FacingFaces {
  SideLine leading, trailing;
};

inline std::optional<FacingFaces> facing_faces(const Profile& profile)
{
  const std::vector<Piece>& pieces = profile.pieces();
  const std::size_t count = pieces.size();
  const auto seen = [&](std::size_t i) {
    return i < count ? pieces[i] : turned_piece(pieces[i - count], profile.pitch());
  };
  const auto faces_from = [&](std::size_t i, std::size_t end, Face face) {
    while (i < end && (seen(i).face != face || seen(i).is_arc())) ++i;
    std::size_t last = i;
    while (last + 1 < end && seen(last + 1).face == face && !seen(last + 1).is_arc()) ++last;
    return std::pair{i, last};
  };
  const auto line = [&](std::pair<std::size_t, std::size_t> faces) {
    const Piece first = seen(faces.first), last = seen(faces.second);
    const Local along = faces.first == faces.second ? first.tangent_begin : last.end - first.begin;
    return SideLine{first.begin, last.end, along};
  };
  const auto leading = faces_from(0, count, Face::leading);
  if (leading.first == count) return std::nullopt;
  const auto trailing = faces_from(leading.second + 1, count + leading.first, Face::trailing);
  if (trailing.first == count + leading.first) return std::nullopt;
  return FacingFaces{line(leading), line(trailing)};
}

/// Return whether a piece is an edge with a radius: an arc around the wall that turns as far as a
/// corner.
inline bool is_rounded_edge(const Piece& piece)
{
  return piece.arc_radius < 0.0 && 2.0 * piece.half_angle >= smallest_corner;
}

}  // namespace detail

/// Narrowest width of the liner [m]. Measured between the corners of a groove's foot, the edges of
/// its mouth, from sector to sector, or across an arc of a third of a turn or more with its centre
/// in the cavity. A smaller such arc is a fillet, shallower folds are no corners. A ball with a
/// smaller diameter touches no sectors but its own and the two beside it.
inline double narrowest_width(const Profile& profile)
{
  const std::vector<Piece>& pieces = profile.pieces();
  double width = 2.0 * profile.clear_radius();
  if (profile.sectors() > 1) width *= std::sin(0.5 * profile.pitch());
  Local edge{}, corner{};  // the last convex edge and the last concave corner
  bool after_edge = false, after_corner = false, in_groove = false;
  for (std::size_t i = 0; i < 2 * pieces.size(); ++i) {  // twice, to see each pair of corners
    const std::size_t of_sector = i % pieces.size();
    const Piece& piece = pieces[of_sector];
    const Local begin = i < pieces.size() ? piece.begin : turned(piece.begin, profile.pitch());
    if (piece.arc_radius > 0.0 && piece.half_angle >= pi / 3.0)
      width = std::min(width, 2.0 * piece.arc_radius);
    if (piece.corner) {
      if (after_corner) width = std::min(width, length(begin - corner));
      corner = begin;
      after_corner = in_groove = true;
    } else if (piece.turn <= -detail::smallest_corner || detail::is_rounded_edge(piece)) {
      if (after_edge && in_groove) width = std::min(width, length(begin - edge));
      const Local end = i < pieces.size() ? piece.end : turned(piece.end, profile.pitch());
      edge = detail::is_rounded_edge(piece) ? end : begin;
      after_edge = true;
      after_corner = in_groove = false;
    }
  }
  return width;
}

/// Return whether the liner has a groove: a plain drum, and a shape of one sector without two
/// facing lifter faces, have none.
inline bool has_groove(const Profile& profile)
{
  return profile.sectors() > 1 || detail::facing_faces(profile);
}

/// Polar angle of the middle of groove 0 at rest [rad]: of its mouth between straight faces, or
/// else of the sector. Of equal lifters on the sectors' borders it is the sector's centre line,
/// exactly.
inline double groove_middle(const Profile& profile)
{
  if (profile.grooves().lifters.empty()) return profile.sector_angle(0);
  const auto faces = detail::facing_faces(profile);
  if (!faces) return profile.sector_angle(0);
  const Local low = faces->leading.begin, high = faces->trailing.end;
  return profile.sector_angle(0) + std::atan2(low.tangential, low.radial) +
         0.5 * std::atan2(cross(low, high), dot(low, high));
}

/// Corners of the box that holds groove 0 at rest [m], in order of increasing polar angle along the
/// liner, then back along its inner side. The sides are the planes of the facing lifter faces. The
/// outer line is the tangent to the liner's radius at the groove's middle, so that no ball in
/// the groove is missed. The inner line goes through the face's edge that is nearer to the axis.
/// Without straight faces the sides are the sector's borders, and the inner line is at the clear
/// radius. Throws std::invalid_argument for a liner without a groove.
inline std::array<Point, 4> groove_box(const Profile& profile)
{
  if (!has_groove(profile))
    throw std::invalid_argument(
        "groove box: a plain drum (lifters = 0), or a shape of one sector without faces, has no "
        "groove");
  const double outer = profile.radius();
  const auto faces = detail::facing_faces(profile);
  const double middle = groove_middle(profile);
  const Frame frame(middle);
  const auto box = [&](double inner, double outer_low, double outer_high, double inner_low,
                       double inner_high) -> std::array<Point, 4> {
    return {frame.point({outer, outer_low}), frame.point({outer, outer_high}),
            frame.point({inner, inner_high}), frame.point({inner, inner_low})};
  };
  if (faces) {
    const double from_sector = middle - profile.sector_angle(0);
    const detail::SideLine low = faces->leading.seen_from(from_sector),
                           high = faces->trailing.seen_from(from_sector);
    const double inner = std::min(low.begin.radial, high.end.radial);
    return box(inner, low.at(low.begin, outer), high.at(high.end, outer), low.at(low.begin, inner),
               high.at(high.end, inner));
  }
  const double inner = profile.clear_radius(), slope = std::tan(0.5 * profile.pitch());
  return box(inner, -slope * outer, slope * outer, -slope * inner, slope * inner);
}

}  // namespace millscale::liner
