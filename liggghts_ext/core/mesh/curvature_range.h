#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "core/math/constants.h"
#include "core/mesh/triangle.h"

namespace millscale::mesh {

/// Open interval of values for the engine's keyword `curvature` [rad]. It ends at the smallest
/// ridge of a mesh and begins at the largest valley below that ridge.
///
/// The engine gives no contact on the common edge of neighbours that fold by less than `curvature`.
/// In a valley the faces themselves reach over the edge. Beside a ridge, which bulges towards the
/// balls, a ball within a wedge as wide as the fold projects onto neither face. No contact acts
/// there, and a ball that rests on the ridge falls through.
struct CurvatureRange {
  double low = 0.0;
  double high = std::numeric_limits<double>::infinity();  ///< infinite without ridges
};

/// Smaller folds, below 0.1 degrees, are rounding of a flat face: six digits of a file in m, or
/// 0.01 mm.
inline constexpr double flat = 0.1 * degree;

namespace detail {

/// Numbers the nodes. Nodes within 1e-7 of the mesh's size are equal.
class Nodes {
 public:
  explicit Nodes(const std::vector<Triangle>& mesh)
  {
    double largest = 0.0;
    for (const Triangle& t : mesh)
      for (const Vector& p : t)
        for (const double x : p) largest = std::max(largest, std::abs(x));
    cell_ = 1e-7 * largest;
  }

  int operator()(const Vector& p)
  {
    std::array<std::int64_t, 3> key;
    for (std::size_t d = 0; d < 3; ++d) key[d] = std::llround(p[d] / cell_);
    return number_.emplace(key, static_cast<int>(number_.size())).first->second;
  }

 private:
  double cell_ = 1.0;
  std::map<std::array<std::int64_t, 3>, int> number_;
};

/// One side of a triangle: its nodes, lower first, and the triangle.
struct Side {
  int low, high, triangle, corner;  ///< corner: of the triangle, opposite

  bool operator<(const Side& other) const
  {
    return std::pair{low, high} < std::pair{other.low, other.high};
  }
  bool shares_edge(const Side& other) const { return low == other.low && high == other.high; }
};

inline std::vector<Side> sorted_sides(const std::vector<Triangle>& mesh)
{
  Nodes number(mesh);
  std::vector<Side> sides;
  for (int t = 0; t < static_cast<int>(mesh.size()); ++t) {
    const std::array<int, 3> node{number(mesh[t][0]), number(mesh[t][1]), number(mesh[t][2])};
    for (int corner = 0; corner < 3; ++corner) {
      const int a = node[(corner + 1) % 3], b = node[(corner + 2) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), t, corner});
    }
  }
  std::sort(sides.begin(), sides.end());
  return sides;
}

/// Return the unit vector in the triangle, perpendicular to its side.
inline Vector inward(const Triangle& t, int corner)
{
  const Vector &a = t[(corner + 1) % 3], &b = t[(corner + 2) % 3];
  const Vector edge{b[0] - a[0], b[1] - a[1], b[2] - a[2]};
  Vector in{t[corner][0] - a[0], t[corner][1] - a[1], t[corner][2] - a[2]};
  const double part = dot(in, edge) / dot(edge, edge);
  for (int d = 0; d < 3; ++d) in[d] -= part * edge[d];
  const double length = std::sqrt(dot(in, in));
  for (double& x : in) x /= length;
  return in;
}

/// Return the angle between the planes of two triangles, whichever way they face [rad].
inline double fold(const Triangle& one, const Triangle& other)
{
  const Vector a = normal(one), b = normal(other), c = cross(a, b);
  return std::atan2(std::sqrt(dot(c, c)), std::abs(dot(a, b)));
}

}  // namespace detail

/// Return the range of a mesh whose balls are on the side of the mill's axis.
inline CurvatureRange curvature_range(const std::vector<Triangle>& mesh, const Axis& axis)
{
  const std::vector<detail::Side> sides = detail::sorted_sides(mesh);
  CurvatureRange range;
  std::vector<double> valleys;
  for (std::size_t first = 0; first < sides.size(); ++first)
    for (std::size_t k = first + 1; k < sides.size() && sides[first].shares_edge(sides[k]); ++k) {
      const Triangle &one = mesh[sides[first].triangle], &other = mesh[sides[k].triangle];
      const double angle = detail::fold(one, other);
      if (!(angle > flat)) continue;
      const Vector in = detail::inward(one, sides[first].corner),
                   also_in = detail::inward(other, sides[k].corner);
      const Vector out = axis.radial(one[(sides[first].corner + 1) % 3]);
      // At a ridge the faces recede from the axis, more than a flat face would.
      if (dot(in, out) + dot(also_in, out) > 0.0)
        range.high = std::min(range.high, angle);
      else
        valleys.push_back(angle);
    }
  for (const double angle : valleys)
    if (angle < range.high) range.low = std::max(range.low, angle);
  return range;
}

}  // namespace millscale::mesh
