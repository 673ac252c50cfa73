#pragma once

#include <cmath>

namespace millscale::similarity {

/// Exponents of a quantity in length, mass and time. Force is {1, 1, -2}.
struct Dimension {
  int length, mass, time;
};

namespace dimension {
inline constexpr Dimension length{1, 0, 0};
inline constexpr Dimension time{0, 0, 1};
inline constexpr Dimension mass{0, 1, 0};
inline constexpr Dimension velocity{1, 0, -1};
inline constexpr Dimension angular_velocity{0, 0, -1};
inline constexpr Dimension acceleration{1, 0, -2};
inline constexpr Dimension force{1, 1, -2};
inline constexpr Dimension energy{2, 1, -2};
inline constexpr Dimension power{2, 1, -3};
}  // namespace dimension

/// Factors physical -> scaled of the base quantities. The factor of any other quantity follows from
/// its dimension. `mass` is the factor of one ball's mass: balls are not scaled, so it is 1.
struct BaseFactors {
  double length, mass, time;
};

namespace detail {
inline double integer_power(double base, int exponent)
{
  double result = 1.0;
  for (int i = 0; i < std::abs(exponent); ++i) result *= base;
  return exponent < 0 ? 1.0 / result : result;
}
}  // namespace detail

/// Return the factor physical -> scaled of a quantity of dimension `d`: length^a mass^b time^c.
inline double factor(const BaseFactors& base, const Dimension& d)
{
  return detail::integer_power(base.length, d.length) * detail::integer_power(base.mass, d.mass) *
         detail::integer_power(base.time, d.time);
}

}  // namespace millscale::similarity
