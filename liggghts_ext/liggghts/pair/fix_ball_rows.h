#pragma once

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
  int pack_comm(int, int*, double*, int, int*) override;
  void unpack_comm(int, int, double*) override;
  double memory_usage() override;

  /// Send position, velocity, spin and damping share of the ghosts from the rows of their owners.
  void send_ghosts();

  millscale::kernels::RowStore store;
  bool single = false;           ///< the kernel reads velocities in single precision
  PairGranFast* pair = nullptr;  ///< the pair style of the run to come, set at its `init`
};

}  // namespace LAMMPS_NS
