#pragma once

namespace LAMMPS_NS {

/// A style that reads the largest overlap of two balls at some steps. The kernels of `surface fast`
/// then note it as they evaluate the contacts.
class ReadsOverlap {
 public:
  virtual ~ReadsOverlap() = default;

  /// Return whether this style will read the overlap at the end of the present step.
  virtual bool reads_overlap_now() = 0;
};

}  // namespace LAMMPS_NS
