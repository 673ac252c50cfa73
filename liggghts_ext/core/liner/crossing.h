#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/liner/piece.h"

namespace millscale::liner {

namespace detail {

/// The points that two pieces may have in common, at most two.
struct CommonPoints {
  int count = 0;
  Local point[2] = {};

  void add(Local p) { point[count++] = p; }
};

/// Points of the line or circle of one piece on that of another. Parallel lines and circles around
/// one centre have none.
inline CommonPoints common_points(const Piece& a, const Piece& b)
{
  CommonPoints found;
  if (!a.is_arc() && !b.is_arc()) {
    const double sine = cross(a.tangent_begin, b.tangent_begin);
    if (std::abs(sine) < 1e-12) return found;
    found.add(a.begin + (cross(b.begin - a.begin, b.tangent_begin) / sine) * a.tangent_begin);
    return found;
  }
  if (!a.is_arc()) return common_points(b, a);
  // The line through both points: b itself, or that of two circles.
  Local base, along;
  if (!b.is_arc()) {
    along = b.tangent_begin;
    base = b.begin + dot(a.centre - b.begin, along) * along;
  } else {
    const Local between = b.centre - a.centre;
    const double d2 = dot(between, between);
    if (!(d2 > 1e-24 * a.arc_radius * a.arc_radius)) return found;
    const double share =
        0.5 * (1.0 + (a.arc_radius * a.arc_radius - b.arc_radius * b.arc_radius) / d2);
    base = a.centre + share * between;
    along = (1.0 / std::sqrt(d2)) * left_of(between);
  }
  const Local from_centre = base - a.centre;
  const double square = a.arc_radius * a.arc_radius - dot(from_centre, from_centre);
  if (!(square >= 0.0)) return found;
  const double half = std::sqrt(square);
  found.add(base + half * along);
  found.add(base + (-half) * along);
  return found;
}

/// Return the distance of a point from a piece [m].
inline double distance_to(const Piece& piece, Local p)
{
  return length(p - nearest_on(piece, p).point);
}

/// A common point of two pieces, if they have one. Points within `near` of the excluded point do
/// not count.
inline std::optional<Local> crossing_of(const Piece& a, const Piece& b, double rounding,
                                        const Local* excluded = nullptr, double near = 0.0)
{
  const auto counts = [&](Local p) {
    return distance_to(a, p) <= rounding && distance_to(b, p) <= rounding &&
           !(excluded && length(p - *excluded) <= near);
  };
  const CommonPoints found = common_points(a, b);
  for (int k = 0; k < found.count; ++k)
    if (counts(found.point[k])) return found.point[k];
  // Ends cover pieces of one line or circle that overlap.
  for (const Local p : {a.begin, a.end, b.begin, b.end})
    if (counts(p)) return p;
  return std::nullopt;
}

/// A piece and the polar angles it lies between, in a frame that follows the profile [rad].
struct AngularRange {
  double low, high;
  int index, sector;  ///< of the piece
};

inline std::vector<AngularRange> angular_ranges(const std::vector<Piece>& pieces)
{
  std::vector<AngularRange> ranges;
  double angle = std::atan2(pieces[0].begin.tangential, pieces[0].begin.radial);
  for (const Piece& piece : pieces) {
    const double after =
        angle + std::atan2(cross(piece.begin, piece.end), dot(piece.begin, piece.end));
    const double height =
        piece.is_arc() ? std::abs(piece.arc_radius) * (1.0 - std::cos(piece.half_angle)) : 0.0;
    const double least = distance_to(piece, {0.0, 0.0});
    const double beyond = std::min(pi, 0.5 * pi * height / least);  // >= asin(height / least)
    ranges.push_back({std::min(angle, after) - beyond, std::max(angle, after) + beyond,
                      static_cast<int>(ranges.size()), 0});
    angle = after;
  }
  return ranges;
}

}  // namespace detail

/// Throws std::invalid_argument, with the place, if pieces of a profile cross or touch other than
/// at their common node, or if the profile folds back on itself. pieces: of a sector, repeated
/// around the axis. The cost is nearly proportional to their number.
inline void require_no_crossing(const std::vector<Piece>& pieces, int sectors)
{
  using namespace detail;
  const int count = static_cast<int>(pieces.size());
  const double pitch = 2.0 * pi / sectors;
  double size = 0.0;
  for (const Piece& piece : pieces) size = std::max(size, length(piece.begin));
  const double rounding = 1e-12 * size;
  const auto text = [](Local p) {
    return "(" + format(p.radial) + ", " + format(p.tangential) + ") m";
  };
  for (int i = 0; i < count; ++i)
    if (std::abs(pieces[i].turn) > pi - smooth_turn)
      throw std::invalid_argument("profile: piece " + std::to_string(i) +
                                  " folds back on the piece before it, at " +
                                  text(pieces[i].begin));
  if (count * sectors < 3) return;

  std::vector<AngularRange> ranges = angular_ranges(pieces);
  double low = ranges[0].low, high = ranges[0].high;
  for (const AngularRange& range : ranges) {
    low = std::min(low, range.low);
    high = std::max(high, range.high);
  }
  const int others = std::min(static_cast<int>((high - low) / pitch), sectors);
  for (int sector = 1; sector <= others; ++sector)
    for (int i = 0; i < count; ++i)
      ranges.push_back(
          {ranges[i].low + sector * pitch, ranges[i].high + sector * pitch, i, sector});
  std::sort(ranges.begin(), ranges.end(),
            [](const AngularRange& a, const AngularRange& b) { return a.low < b.low; });

  const auto check = [&](const AngularRange& one, const AngularRange& other) {
    const Piece a = turned_piece(pieces[one.index], one.sector * pitch);
    const Piece b = turned_piece(pieces[other.index], other.sector * pitch);
    const int all = count * sectors;
    const auto place = [&](const AngularRange& r) { return (count * r.sector + r.index) % all; };
    const int behind = (place(other) - place(one) + all) % all;
    if (behind == 0) return;  // the same piece
    std::optional<Local> found;
    if (behind != 1 && behind != all - 1) {
      found = crossing_of(a, b, rounding);
    } else {
      // Pieces that join at less than a right angle have no other common point: arcs are at most
      // half a turn.
      const Piece& later = behind == 1 ? b : a;
      if (std::abs(later.turn) > 0.5 * pi)
        found = crossing_of(a, b, rounding, &later.begin, 1e-6 * size);
    }
    if (!found) return;
    const double back = -std::min(one.sector, other.sector) * pitch;
    throw std::invalid_argument(
        "profile: pieces " + std::to_string(one.index) + " and " + std::to_string(other.index) +
        (one.sector == other.sector ? "" : " of the next sector") + " cross or touch at " +
        text(turned(*found, back)) + "; the outline must not cross itself");
  };
  std::vector<const AngularRange*> open;
  for (const AngularRange& range : ranges) {
    open.erase(std::remove_if(open.begin(), open.end(),
                              [&](const AngularRange* r) { return r->high < range.low; }),
               open.end());
    for (const AngularRange* other : open)
      if (other->sector == 0 || range.sector == 0) check(*other, range);
    open.push_back(&range);
  }
}

}  // namespace millscale::liner
