#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/liner/liner.h"

namespace millscale::liner {

/// Closed polygon of a liner, nodes in the direction of rotation; edge i goes from node i to node
/// i + 1 (the last one to node 0) and belongs to faces[i].
struct Polygon {
  std::vector<Point> nodes;
  std::vector<Face> faces;
};

/// Number of equal chords for an arc [-], so that none is farther than chord_error from the arc:
/// sagitta R (1 - cos(half chord angle)) <= chord_error.
inline int chords(double radius, double half_angle, double chord_error)
{
  const double sagitta = std::min(chord_error / radius, 1.0);
  const double half_chord_angle = 2.0 * std::asin(std::sqrt(0.5 * sagitta));
  return std::max(1, static_cast<int>(std::ceil(half_angle / half_chord_angle - 1e-9)));
}

/// Equal chords in place of each groove's arc; none: the exact arc. The mesh's polygon and a wall
/// with the same chord error have the same ones.
struct GrooveChords {
  int count = 0;              ///< per groove; 0: the arc
  double half_angle = 0.0;    ///< half the angle one chord spans [rad]
  double inner_radius = 0.0;  ///< from the axis to the middle of a chord [m]
};

/// Throws std::invalid_argument for a chord error [m] that is not in (0, R).
inline GrooveChords groove_chords(const Liner& liner, double chord_error)
{
  const double R = liner.radius(), half_angle = liner.groove_half_angle();
  detail::require_between("chord error", 0.0, R, chord_error, "the liner radius");
  const int count = std::max(chords(R, half_angle, chord_error), liner.lifters() == 0 ? 3 : 1);
  return {count, half_angle / count, R * std::cos(half_angle / count)};
}

/// Polygon with its nodes on the liner: lifters exact, groove arcs as equal chords within
/// chord_error [m]. Every sector's nodes are those of sector 0, rotated. A sector runs from the
/// trailing corner of lifter k over its top, leading face and groove to the next lifter's foot.
/// Throws std::invalid_argument for a chord error that is not in (0, R).
inline Polygon polygon(const Liner& liner, double chord_error)
{
  const double R = liner.radius(), half_angle = liner.groove_half_angle();
  const bool plain = liner.lifters() == 0;
  const int count = groove_chords(liner, chord_error).count;
  const Local corner = liner.corner();

  Polygon result;
  const auto add = [&result](Point node, Face face) {
    result.nodes.push_back(node);
    result.faces.push_back(face);
  };
  for (int k = 0; k < std::max(liner.lifters(), 1); ++k) {
    const Frame lifter(liner.lifter_angle(k)), groove(liner.groove_angle(k));
    if (!plain) {
      add(lifter.point({corner.radial, -corner.tangential}), Face::top);
      add(lifter.point(corner), Face::leading);
    }
    for (int i = 0; i < count; ++i) {
      const double angle = half_angle * (2 * i - count) / count;
      add(groove.point({R * std::cos(angle), R * std::sin(angle)}), Face::groove);
    }
    if (!plain)
      add(groove.point({R * std::cos(half_angle), R * std::sin(half_angle)}), Face::trailing);
  }
  return result;
}

}  // namespace millscale::liner
