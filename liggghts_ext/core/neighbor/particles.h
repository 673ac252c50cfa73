#pragma once

#include <cstddef>

namespace millscale::neighbor {

/// The particles of one rank in the engine's arrays, not owned: local ones first, then ghosts.
struct Particles {
  const double (*position)[3], (*velocity)[3], (*spin)[3];  ///< [m], [m/s], [rad/s]
  const double *radius, *mass;                              ///< [m], [kg]
  const int* type;                                          ///< 1 .. types
  int nlocal, nghost;

  // Always inlined: the kernels may not share functions between object files.
  [[gnu::always_inline]] int total() const { return nlocal + nghost; }
};

/// Return the squared distance of two centres [m^2].
inline double separation_squared(const Particles& particles, int i, int j)
{
  double r2 = 0.0;
  for (int d = 0; d < 3; ++d) {
    const double separation = particles.position[i][d] - particles.position[j][d];
    r2 += separation * separation;
  }
  return r2;
}

/// Return whether two particles overlap.
inline bool overlap(const Particles& particles, int i, int j)
{
  const double radii = particles.radius[i] + particles.radius[j];
  return separation_squared(particles, i, j) < radii * radii;
}

}  // namespace millscale::neighbor
