#pragma once

#include <cmath>

namespace millscale::liner {

/// A point or vector in the cross-section, seen along the mill axis y: x to the right, z up [m].
struct Point {
  double x, z;
};

inline Point operator-(Point a, Point b)
{
  return {a.x - b.x, a.z - b.z};
}
inline double length(Point p)
{
  return std::hypot(p.x, p.z);
}

/// Coordinates from the axis along a radius and across it, positive in the direction of rotation.
struct Local {
  double radial, tangential;
};

/// The radius at polar angle psi, measured from the bottom (-z) in the direction of rotation:
/// a point at distance d on it is x = -d sin(psi), z = -d cos(psi).
class Frame {
 public:
  explicit Frame(double psi) : sin_(std::sin(psi)), cos_(std::cos(psi)) {}

  Point point(Local p) const
  {
    return {-p.radial * sin_ - p.tangential * cos_, -p.radial * cos_ + p.tangential * sin_};
  }

  Local local(Point p) const { return {-p.x * sin_ - p.z * cos_, -p.x * cos_ + p.z * sin_}; }

 private:
  double sin_, cos_;
};

/// Polar angle of a point from the bottom in the direction of rotation, in [-pi, pi] [rad]; 0 on
/// the axis.
inline double polar_angle(Point p)
{
  return p.x == 0.0 && p.z == 0.0 ? 0.0 : std::atan2(-p.x, -p.z);
}

}  // namespace millscale::liner
