#pragma once

#include <array>
#include <cmath>

namespace millscale {

/// A vector in space: x, y, z.
using Vector = std::array<double, 3>;

inline double dot(const Vector& a, const Vector& b)
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

inline Vector cross(const Vector& a, const Vector& b)
{
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// A rotation by an angle [rad], with its cosine and sine.
struct Turn {
  explicit Turn(double angle) : cosine(std::cos(angle)), sine(std::sin(angle)) {}
  double cosine, sine;
};

/// Return `p` rotated about the unit vector `axis` (Rodrigues' formula).
inline Vector rotated(const Vector& p, const Vector& axis, const Turn& turn)
{
  const double c = turn.cosine, s = turn.sine;
  const Vector q = cross(axis, p);
  const double along = dot(axis, p) * (1.0 - c);
  return {p[0] * c + q[0] * s + axis[0] * along, p[1] * c + q[1] * s + axis[1] * along,
          p[2] * c + q[2] * s + axis[2] * along};
}
inline Vector rotated(const Vector& p, const Vector& axis, double angle)
{
  return rotated(p, axis, Turn(angle));
}

}  // namespace millscale
