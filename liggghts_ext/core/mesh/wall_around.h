#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <limits>
#include <string>
#include <vector>

#include "core/math/constants.h"
#include "core/mesh/triangle.h"

namespace millscale::mesh {

/// Distance from the mill's axis to the nearest triangle, in many directions perpendicular to the
/// axis and in slices all along the meshes. An outer shell, flanges and end plates have no effect:
/// the inner wall is nearer, or they are parallel to the direction.
class WallAround {
 public:
  static constexpr int slices = 16, directions = 720;

  /// low, high: ends of the meshes along the axis [m].
  WallAround(const Axis& axis, double low, double high)
      : axis_(axis), low_(low), high_(high), nearest_(slices * directions, nothing)
  {
    // Any two directions perpendicular to the axis and to each other.
    const Vector& a = axis.direction;
    const Vector some = std::abs(a[0]) < 0.6 ? Vector{1, 0, 0} : Vector{0, 1, 0};
    one_ = cross(a, some);
    const double length = std::sqrt(dot(one_, one_));
    for (double& x : one_) x /= length;
    other_ = cross(a, one_);
  }

  void add(const Triangle& t)
  {
    const double heights[] = {axis_.along(t[0]), axis_.along(t[1]), axis_.along(t[2])};
    for (int slice = 0; slice < slices; ++slice) {
      const double height = low_ + (high_ - low_) * (slice + 0.5) / slices;
      Flat ends[2];
      int found = 0;
      for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3;
        if ((heights[i] < height) != (heights[j] < height))
          // In ascending order, so that both triangles of an edge find the same point.
          ends[found++] = heights[i] < height
                              ? crossing(t[i], heights[i], t[j], heights[j], height)
                              : crossing(t[j], heights[j], t[i], heights[i], height);
      }
      if (found == 2) add_segment(slice, ends[0], ends[1]);
    }
  }

  /// Distances of all slices and directions [m], infinite without a triangle. The distance over
  /// ranks is the smallest.
  std::vector<double>& nearest() { return nearest_; }

  /// Return the share of the directions without a wall.
  double open() const
  {
    const auto count = std::count(nearest_.begin(), nearest_.end(), nothing);
    return static_cast<double>(count) / static_cast<double>(nearest_.size());
  }

  /// Return the radius of the wall [m]; 0 without a wall. It is the distance that one direction in
  /// twenty exceeds, in the slice where that distance is largest, so neither lifters nor a hole
  /// decide it.
  double radius() const
  {
    double largest = 0.0;
    for (int slice = 0; slice < slices; ++slice) {
      std::vector<double> seen;
      for (int k = 0; k < directions; ++k)
        if (nearest_[at(slice, k)] < nothing) seen.push_back(nearest_[at(slice, k)]);
      if (seen.empty()) continue;
      std::sort(seen.begin(), seen.end());
      largest = std::max(largest, seen[seen.size() - 1 - seen.size() / 20]);
    }
    return largest;
  }

 private:
  static constexpr double nothing = std::numeric_limits<double>::infinity();
  static constexpr double turn = 2.0 * pi;

  /// A point in a slice, from the axis.
  struct Flat {
    double x, y;
  };

  static std::size_t at(int slice, int direction)
  {
    return static_cast<std::size_t>(slice * directions + direction);
  }

  Flat crossing(const Vector& a, double at_a, const Vector& b, double at_b, double height) const
  {
    const double share = (height - at_a) / (at_b - at_a);
    Vector p;
    for (int d = 0; d < 3; ++d) p[d] = a[d] + share * (b[d] - a[d]);
    const Vector r = axis_.radial(p);
    return {dot(r, one_), dot(r, other_)};
  }

  /// Return the first direction at or after a point. Directions lie between round angles.
  static int first_direction(const Flat& p)
  {
    const double share = std::atan2(p.y, p.x) / turn * directions - offset;
    return (static_cast<int>(std::ceil(share)) + 2 * directions) % directions;
  }

  void add_segment(int slice, const Flat& a, const Flat& b)
  {
    const int first = first_direction(a), last = first_direction(b);
    const int ahead = (last - first + directions) % directions;
    const bool forwards = ahead <= directions / 2;  // the shorter way around
    const int begin = forwards ? first : last, count = forwards ? ahead : directions - ahead;
    for (int k = 0; k < count; ++k) {
      const int direction = (begin + k) % directions;
      const double angle = (direction + offset) / directions * turn;
      const Flat u{std::cos(angle), std::sin(angle)}, along{b.x - a.x, b.y - a.y};
      const double distance = (a.x * along.y - a.y * along.x) / (u.x * along.y - u.y * along.x);
      double& nearest = nearest_[at(slice, direction)];
      if (distance >= 0.0) nearest = std::min(nearest, distance);
    }
  }

  static constexpr double offset = 0.3183;

  Axis axis_;
  double low_, high_;
  Vector one_{}, other_{};
  std::vector<double> nearest_;
};

/// Return what to do about a mesh whose wall is `factor` times as far from the axis as that of the
/// scaled mill, from likely mistakes with that factor. S: of the scaled mill; radius: of the
/// physical mill that would fit this mesh, as text.
inline std::string advice_on_factor(double factor, double S, const std::string& radius)
{
  const auto is = [factor](double f) { return std::abs(factor / f - 1.0) < 0.05; };
  char inverse[32];
  std::snprintf(inverse, sizeof inverse, "%.3g", 1.0 / factor);
  const std::string scale = std::string("multiply `scale` of fix mesh/surface by ") + inverse;
  if (is(0.5)) return "was a diameter given as radius? Then give `radius " + radius + "`";
  if (is(0.001)) return "was the radius given in mm? Then give `radius " + radius + "`";
  if (is(2.0)) return "does the mesh have the diameter as its radius? Then " + scale;
  if (is(1000.0)) return "is the mesh in mm? Then " + scale;
  if (is(100.0)) return "is the mesh in cm? Then " + scale;
  if (is(1.0 / 0.0254)) return "is the mesh in inches? Then " + scale;
  if (S > 1.05 && is(S)) return "is the mesh that of the physical mill? Then " + scale;
  if (S > 1.05 && is(1.0 / S)) return "was the mesh scaled by 1 / S twice? Then " + scale;
  return "give `radius " + radius + "`, or " + scale;
}

}  // namespace millscale::mesh
