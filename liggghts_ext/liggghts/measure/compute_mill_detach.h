#pragma once

#include <string>
#include <vector>

#include "compute.h"

namespace LAMMPS_NS {

class FixMillDetachTrack;

/// State of each ball, where and when it last left liner and charge, and statistics of the angles.
/// Columns, definitions and thresholds: docs/reference/styles/compute-mill-detach.md.
class ComputeMillDetach : public Compute {
 public:
  ComputeMillDetach(class LAMMPS*, int& iarg, int, char**);
  ~ComputeMillDetach() override;
  void post_create() override;
  void init() override;
  void compute_vector() override;
  void compute_peratom() override;
  double memory_usage() override;

 private:
  FixMillDetachTrack* tracker();

  std::vector<std::string> track_arguments_;
  int rows_ = 0;
  double** columns_ = nullptr;
};

}  // namespace LAMMPS_NS
