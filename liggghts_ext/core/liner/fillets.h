#pragma once

#include <cstddef>
#include <vector>

#include "core/liner/profile.h"

namespace millscale::liner {

namespace detail {

/// A joint, or the piece behind it, of an outline.
struct Bend {
  double turn, length;  ///< turn to the left [rad]; length [m]
  std::size_t node;
  bool ends;  ///< an edge, a corner or an arc with its centre in the wall

  /// Turn of a joint; 0 for a piece [rad].
  double fold() const { return length == 0.0 ? turn : 0.0; }
};

inline std::vector<Bend> bends(const Profile& profile)
{
  std::vector<Bend> result;
  for (const Piece& piece : profile.pieces()) {
    const std::size_t node = result.size() / 2;
    result.push_back({piece.turn, 0.0, node, piece.turn < 0.0 || piece.corner});
    const double turn = piece.arc_radius > 0.0 ? 2.0 * piece.half_angle : 0.0;
    result.push_back({turn, piece.length, node, piece.arc_radius < 0.0});
  }
  return result;
}

}  // namespace detail

/// The profile as a ball of a radius touches it [m]. A concave turn that is too narrow for the
/// ball, as a fillet or its chords, becomes a corner: the ball touches both sides of it at once,
/// which must be two surfaces. Its radius is its length over its turn; a fold at its end counts
/// half.
inline Profile with_corners_for(const Profile& profile, double ball_radius)
{
  const std::vector<detail::Bend> bends = detail::bends(profile);
  const std::size_t count = bends.size();
  std::vector<Node> nodes = profile.nodes();
  bool changed = false;
  for (std::size_t start = 0; start < count; ++start) {
    if (!(bends[start].turn > 0.0)) continue;
    double turn = 0.0, length = 0.0, too_narrow = 0.0;
    std::size_t last = start;
    for (std::size_t k = start; k < start + count && length < pi * ball_radius; ++k) {
      const detail::Bend& bend = bends[k % count];
      if (bend.ends) break;
      turn += bend.turn;
      length += bend.length;
      if (!(bend.turn > 0.0) || turn < detail::smallest_corner) continue;
      const double turn_of_length = turn - 0.5 * (bends[start].fold() + bend.fold());
      if (length >= turn_of_length * ball_radius) continue;
      too_narrow = turn;
      last = k;
    }
    if (too_narrow == 0.0) continue;
    std::size_t middle = start;
    for (double before = bends[start].turn; before < 0.5 * too_narrow;)
      before += bends[++middle % count].turn;
    nodes[bends[middle % count].node].corner = changed = true;
    start = last;
  }
  if (!changed) return profile;
  return {nodes, profile.sectors(), profile.phase()};
}

}  // namespace millscale::liner
