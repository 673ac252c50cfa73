#pragma once

#include <cmath>

#include "core/math/mill_frame.h"

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

/// Return the point of the cross-section, of the mill with axis y and gravity -z.
inline Point section(const MillPoint& p)
{
  return {-p.ahead, -p.below};
}

/// Coordinates from the axis along a radius and across it, positive in the direction of rotation.
struct Local {
  double radial, tangential;
};

inline Local operator+(Local a, Local b)
{
  return {a.radial + b.radial, a.tangential + b.tangential};
}
inline Local operator-(Local a, Local b)
{
  return {a.radial - b.radial, a.tangential - b.tangential};
}
inline Local operator*(double s, Local a)
{
  return {s * a.radial, s * a.tangential};
}
inline double dot(Local a, Local b)
{
  return a.radial * b.radial + a.tangential * b.tangential;
}
/// Cross product, > 0 where b points to the left of a. The cavity is on the left of a liner's
/// pieces.
inline double cross(Local a, Local b)
{
  return a.radial * b.tangential - a.tangential * b.radial;
}
inline double length(Local a)
{
  return std::sqrt(dot(a, a));
}
/// The vector a quarter turn to the left.
inline Local left_of(Local a)
{
  return {-a.tangential, a.radial};
}
/// The vector turned in the direction of rotation by an angle [rad].
inline Local turned(Local a, double angle)
{
  const double c = std::cos(angle), s = std::sin(angle);
  return {a.radial * c - a.tangential * s, a.radial * s + a.tangential * c};
}

/// Unit vector along the radius at polar angle psi, measured from the bottom (-z) in the direction
/// of rotation. A point at distance d on this radius is x = -d sin(psi), z = -d cos(psi).
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
