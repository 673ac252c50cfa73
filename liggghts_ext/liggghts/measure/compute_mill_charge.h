#pragma once

#include <mpi.h>

#include <memory>
#include <optional>
#include <string>

#include "compute.h"

#include "core/math/vector.h"
#include "core/measure/charge_sums.h"
#include "core/measure/overlap_search.h"
#include "liggghts/common/reads_overlap.h"
#include "liggghts/mill/liner_arguments.h"

namespace LAMMPS_NS {

class FixMillSimilarity;

/// Measures of the whole charge, in one pass over the balls and one collective: energies, centre of
/// mass, monitoring boxes, toe and shoulder, slip on the liner, largest overlap and speed. Stops
/// the run when balls are lost or outside the liner. Arguments and c_ID[k]:
/// docs/reference/styles/compute-mill-charge.md.
class ComputeMillCharge : public Compute, public ReadsOverlap {
 public:
  ComputeMillCharge(class LAMMPS*, int& iarg, int narg, char**);
  ~ComputeMillCharge() override;
  void init() override;
  void compute_vector() override;
  bool reads_overlap_now() override;

 private:
  void parse(int narg, char** arg, int first);
  void read_balls();
  double largest_overlap();
  void sum_over_ranks();
  void check_all_are_there(double found);
  void report_outside(double count);
  std::string missing_ids(double before) const;
  millscale::liner::Point centre(int i) const;
  double path_momentum(int i) const;
  double spin_momentum(int i) const;

  std::string mill_id_;
  FixMillSimilarity* mill_fix_ = nullptr;
  millscale::MillFrame frame_;
  millscale::LinerArguments liner_arguments_;
  std::shared_ptr<const millscale::liner::Profile> liner_;
  std::optional<double> box_angle_;
  std::unique_ptr<millscale::charge::ChargeSums> sums_;
  millscale::charge::OverlapSearch search_;
  double last_balls_ = 0.0;  ///< at the last sample of this run
  MPI_Datatype numbers_type_ = MPI_DATATYPE_NULL;
  MPI_Op merge_ = MPI_OP_NULL;
};

}  // namespace LAMMPS_NS
