#pragma once

namespace millscale::neighbor {

/// Entries beyond the end of a pair list that may be read.
constexpr int spare_entries = 32;

/// Particles that may be partners of another, not owned. Up to three more may be read.
struct Candidates {
  const double *x, *y, *z, *radius;  ///< [m]
  const int* index;                  ///< index of each among the rank's particles
  int count;

  void drop_first()
  {
    ++x, ++y, ++z, ++radius, ++index;
    --count;
  }
};

/// A centre and its reach, radius plus skin [m].
struct Centre {
  double x, y, z, radius;
};

/// Writes the candidates whose reach overlaps that of the centre; returns the end. Up to four ints
/// beyond the end may be written.
using ListPartners = int* (*)(const Candidates&, Centre, int* out);

}  // namespace millscale::neighbor
