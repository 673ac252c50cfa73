#pragma once

#include <array>
#include <cmath>

#include "core/math/vector.h"

namespace millscale::mesh {

/// Three nodes in space [m].
using Triangle = std::array<Vector, 3>;

/// A line in space: a unit vector and a point [m].
struct Axis {
  Vector direction, origin;

  double along(const Vector& p) const { return dot(from_origin(p), direction); }

  /// Return the vector from the line to a point, perpendicular to the line.
  Vector radial(const Vector& p) const
  {
    Vector r = from_origin(p);
    const double height = dot(r, direction);
    for (int d = 0; d < 3; ++d) r[d] -= height * direction[d];
    return r;
  }

 private:
  Vector from_origin(const Vector& p) const
  {
    return {p[0] - origin[0], p[1] - origin[1], p[2] - origin[2]};
  }
};

/// Return the normal of a triangle, twice its area long [m^2].
inline Vector normal(const Triangle& t)
{
  Vector a, b;
  for (int d = 0; d < 3; ++d) {
    a[d] = t[1][d] - t[0][d];
    b[d] = t[2][d] - t[0][d];
  }
  return cross(a, b);
}

/// Return whether the ray from the axis through a point, perpendicular to the axis, intersects a
/// triangle. Return true for a point on the axis.
inline bool in_direction(const Triangle& t, const Axis& axis, const Vector& point)
{
  const Vector ray = axis.radial(point);
  if (dot(ray, ray) == 0.0) return true;
  const Vector n = normal(t);
  Vector foot, way;
  for (int d = 0; d < 3; ++d) {
    foot[d] = point[d] - ray[d];
    way[d] = t[0][d] - foot[d];
  }
  const double along = dot(n, way) / dot(n, ray);
  if (!(along > 0.0 && std::isfinite(along))) return false;
  Vector met;
  for (int d = 0; d < 3; ++d) met[d] = foot[d] + along * ray[d];
  for (int i = 0; i < 3; ++i) {
    Vector edge, to;
    for (int d = 0; d < 3; ++d) {
      edge[d] = t[(i + 1) % 3][d] - t[i][d];
      to[d] = met[d] - t[i][d];
    }
    if (dot(cross(edge, to), n) < -1e-9 * dot(n, n)) return false;
  }
  return true;
}

/// Sums of areas and of first moments, which add up over ranks.
struct AreaSums {
  double area = 0.0;  ///< [m^2]
  Vector moment{};    ///< [m^3]

  void add(const Triangle& t)
  {
    const Vector n = normal(t);
    const double twice = std::sqrt(dot(n, n));
    area += 0.5 * twice;
    for (int d = 0; d < 3; ++d) moment[d] += twice * (t[0][d] + t[1][d] + t[2][d]) / 6.0;
  }

  /// Return the centroid of the area [m]; NaN for zero area.
  Vector centre() const { return {moment[0] / area, moment[1] / area, moment[2] / area}; }
};

}  // namespace millscale::mesh
