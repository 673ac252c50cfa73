#pragma once

#include <cstddef>

namespace millscale::pairs {

/// The balls of one rank as the engine stores them: owned ones first, then copies of others'
/// (ghosts). Nothing is owned here.
struct Balls {
  const double (*position)[3], (*velocity)[3], (*spin)[3];  ///< [m], [m/s], [rad/s]
  const double *radius, *mass;                              ///< [m], [kg]
  const int* type;                                          ///< 1 .. types
  int owned, all;
};

/// Square of the distance of two centres [m^2].
inline double apart_square(const Balls& balls, int i, int j)
{
  double square = 0.0;
  for (int d = 0; d < 3; ++d) {
    const double apart = balls.position[i][d] - balls.position[j][d];
    square += apart * apart;
  }
  return square;
}

}  // namespace millscale::pairs
