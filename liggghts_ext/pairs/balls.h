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

}  // namespace millscale::pairs
