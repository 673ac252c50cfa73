#pragma once

#include "core/neighbor/particles.h"

namespace millscale::pairs {

/// Entries beyond the end of a list of pairs that may be read.
constexpr int spare_entries = 32;

/// Balls that may be partners of another. Nothing is owned here; up to three more may be read.
struct Candidates {
  const double *x, *y, *z, *radius;  ///< [m]
  const int* index;                  ///< i of each
  int count;

  void leave_out_first()
  {
    ++x, ++y, ++z, ++radius, ++index;
    --count;
  }
};

/// A place and how far from it a ball may begin [m].
struct Centre {
  double x, y, z, radius;
};

/// Writes every candidate whose surface meets a ball at the centre and of the radius given; returns
/// the end. Up to four ints beyond the end may be written.
using ListPartners = int* (*)(const Candidates&, Centre, int* out);

}  // namespace millscale::pairs
