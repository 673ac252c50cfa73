#pragma once

namespace millscale {

inline constexpr double pi = 3.14159265358979323846;
inline constexpr double degree = pi / 180.0;  ///< [rad]

/// Moment of inertia of a solid sphere over m r^2 [-].
inline constexpr double sphere_inertia = 0.4;

/// Volume of a ball of this radius [m^3].
inline double ball_volume(double radius)
{
  return 4.0 / 3.0 * pi * radius * radius * radius;
}

}  // namespace millscale
