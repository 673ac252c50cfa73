#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "core/liner/profile.h"

namespace millscale::liner {

/// Closed polygon of a liner, nodes in the direction of rotation. Edge i goes from node i to node i
/// + 1 (the last edge to node 0) and belongs to faces[i].
struct Polygon {
  std::vector<Point> nodes;
  std::vector<Face> faces;
};

/// Number of equal chords for an arc [-], so that no chord is farther than chord_error from the
/// arc: sagitta R (1 - cos(half chord angle)) <= chord_error.
inline int chords(double radius, double half_angle, double chord_error)
{
  const double sagitta = std::min(chord_error / radius, 1.0);
  const double half_chord_angle = 2.0 * std::asin(std::sqrt(0.5 * sagitta));
  return std::max(1, static_cast<int>(std::ceil(half_angle / half_chord_angle - 1e-9)));
}

/// Nodes of one sector with equal chords in place of its arcs, no chord farther than chord_error
/// [m] from its arc. The nodes lie on the liner.
/// Throws std::invalid_argument for a chord error that is not in (0, R).
inline std::vector<Node> chord_nodes(const Profile& profile, double chord_error)
{
  detail::require_between("chord error", 0.0, profile.radius(), chord_error, "the liner radius");
  std::vector<Node> result;
  for (std::size_t i = 0; i < profile.pieces().size(); ++i) {
    const Piece& piece = profile.pieces()[i];
    Node node = profile.nodes()[i];
    node.continues = node.continues || piece.turn == 0.0;
    node.arc_radius = 0.0;
    result.push_back(node);
    if (!piece.is_arc()) continue;
    const double radius = std::abs(piece.arc_radius);
    const double sweep = piece.arc_radius > 0.0 ? piece.half_angle : -piece.half_angle;
    const double middle = std::atan2(piece.middle.tangential, piece.middle.radial);
    const int count =
        std::max(chords(radius, piece.half_angle, chord_error), profile.is_drum() ? 3 : 1);
    node.continues = true;
    for (int k = 1; k < count; ++k) {
      const double angle = middle + sweep * (2 * k - count) / count;
      node.point = piece.centre + Local{radius * std::cos(angle), radius * std::sin(angle)};
      result.push_back(node);
    }
  }
  return result;
}

/// The profile with the same chords. The chords of an arc are one surface, and so are pieces with a
/// smooth joint.
inline Profile with_chords(const Profile& profile, double chord_error)
{
  return {chord_nodes(profile, chord_error), profile.sectors(), profile.phase()};
}

/// Polygon with its nodes on the liner: straight pieces exact, arcs as equal chords within
/// chord_error [m]. The nodes of every sector are the nodes of sector 0, rotated. Throws
/// std::invalid_argument for a chord error that is not in (0, R).
inline Polygon polygon(const Profile& profile, double chord_error)
{
  const std::vector<Node> nodes = chord_nodes(profile, chord_error);
  Polygon result;
  for (int k = 0; k < profile.sectors(); ++k) {
    const Frame frame(profile.sector_angle(k));
    for (const Node& node : nodes) {
      result.nodes.push_back(frame.point(node.point));
      result.faces.push_back(node.face);
    }
  }
  return result;
}

}  // namespace millscale::liner
