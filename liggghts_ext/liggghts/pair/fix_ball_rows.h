#pragma once

#include <vector>

#include "fix.h"

#include "core/kernels/rows.h"

namespace LAMMPS_NS {

class PairGranFast;

/// The rows of `pair_style gran ... surface fast`, which creates this fix, and how the time loop
/// sends those of ghosts.
class FixBallRows : public Fix {
 public:
  static constexpr const char* style_name = "mill/rows";

  FixBallRows(class LAMMPS*, int, char**);

  int setmask() override { return 0; }
  double memory_usage() override;

  /// Bring position, velocity, spin and damping share of the ghosts up to date from the rows of
  /// their owners, in the order of the engine's `forward_comm`.
  void send_ghosts();

  millscale::kernels::RowStore store;
  bool single = false;           ///< the kernel reads velocities in single precision
  PairGranFast* pair = nullptr;  ///< the pair style of the run to come, set at its `init`

 private:
  struct Swap;
  void copy_within_rank(const Swap&);
  void exchange_with_rank(const Swap&);

  std::vector<double> sent_, received_;
};

}  // namespace LAMMPS_NS
