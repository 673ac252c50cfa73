#pragma once

#include <string>

#include "fix.h"

#include "core/measure/drive_sums.h"
#include "liggghts/common/ends_steps.h"

namespace LAMMPS_NS {

class FixMillSimilarity;
class FixWallMill;

/// Work and torque of the drive, summed over all steps, and their means between the steps of the
/// printed rows. Arguments and f_ID[k]: docs/reference/styles/fix-mill-drive.md.
class FixMillDrive : public Fix, public EndsSteps {
 public:
  FixMillDrive(class LAMMPS*, int, char**);

  int setmask() override;
  void init() override;
  void setup(int) override;
  void end_of_step() override;
  bool needs_arrays() const override { return false; }
  void end_step(const millscale::kernels::Advanced&) override { end_of_step(); }
  double compute_vector(int) override;
  void write_restart(FILE*) override;
  void restart(char*) override;

 private:
  /// Means of the last whole interval, and the begin of the present one; the same on all ranks.
  struct Interval {
    double began = 0.0, impulse = 0.0, work = 0.0, steps = 0.0;  ///< time [s] and sums at the begin
    double torque = 0.0, power = 0.0, alternating = 0.0;
  };
  struct State;

  void parse(int narg, char** arg);
  void find_wall_and_mill();
  double torque_of_drive();
  double torque_of_ends() const;
  double speed_of_ends() const;
  millscale::charge::DriveSums over_all_ranks(millscale::charge::DriveSums) const;
  void end_interval();

  std::string mill_id_, wall_id_;
  int every_ = 0;
  FixMillSimilarity* mill_fix_ = nullptr;
  Fix* wall_ = nullptr;
  FixWallMill* analytic_ = nullptr;  ///< the wall, if it is a fix wall/mill
  millscale::charge::DriveSums sums_, of_ends_;
  Interval interval_;
  double begun_ = 0.0;
  bool forces_carried_ = false;
};

}  // namespace LAMMPS_NS
