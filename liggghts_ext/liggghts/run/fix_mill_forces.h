#pragma once

#include "liggghts/common/fix_per_ball_rows.h"

namespace LAMMPS_NS {

/// Carries each ball's force and torque through a restart, so that n steps + restart + n steps
/// equal 2n steps. Without this fix the engine evaluates the forces again with the velocities of
/// the full step, while a running simulation evaluates them at the half step. The damping forces
/// then differ by O(dt), which disturbs a packed bed. Define this fix last:
/// docs/reference/styles/fix-mill-forces.md.
class FixMillForces : public FixPerBallRows {
 public:
  FixMillForces(class LAMMPS*, int, char**);

  int setmask() override;
  void init() override;
  void setup(int) override;

  int pack_restart(int, double*) override;

 private:
  bool restored_ = false;  ///< the rows hold the forces of the restart file
};

}  // namespace LAMMPS_NS
