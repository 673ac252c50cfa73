#pragma once

#include "liggghts/common/fix_per_ball_rows.h"

namespace LAMMPS_NS {

/// Carries each ball's force and torque through a restart, so that n steps + restart + n steps
/// equal 2n steps. Without it the engine evaluates the forces anew with the velocities of the full
/// step, while a running simulation evaluates them at the half step: the dashpots then differ by
/// O(dt), and the packed bed gets a bump. Define it last: docs/reference/styles.md.
class FixMillForces : public FixPerBallRows {
 public:
  FixMillForces(class LAMMPS*, int, char**);

  int setmask() override;
  void init() override;
  void setup(int) override;

  int pack_restart(int, double*) override;

 private:
  bool restored_ = false;  ///< the rows hold what the restart file held
};

}  // namespace LAMMPS_NS
