#pragma once

namespace millscale::neighbor {

/// Entries beyond the end of a pair list that may be read.
constexpr int spare_entries = 32;

/// A range of sorted particles.
struct Span {
  int first, end;
};

/// Particles that may be partners of another: those in the spans of sorted ones, not owned. Up to
/// seven more than each span may be read.
struct Candidates {
  /// Partners beyond the last that may be written.
  static constexpr int spare = 16;

  const double *x, *y, *z, *reach;  ///< [m]
  const int* index;                 ///< index of each among the rank's particles
  const Span* spans;
  int count;  ///< of spans
  int most;   ///< numbers that the search may write
};

/// A centre and its reach, radius plus skin [m].
struct Centre {
  double x, y, z, reach;
};

/// Writes the candidates whose reach overlaps that of the centre; returns the end.
using ListPartners = int* (*)(const Candidates&, Centre, int* out);

/// The same source, compiled for three sets of instructions.
namespace v2 {
int* list_partners(const Candidates&, Centre, int* out);
}
namespace v3 {
int* list_partners(const Candidates&, Centre, int* out);
}
namespace v4 {
int* list_partners(const Candidates&, Centre, int* out);
}

}  // namespace millscale::neighbor
