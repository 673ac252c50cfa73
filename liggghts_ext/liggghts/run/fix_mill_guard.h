#pragma once

#include <memory>
#include <optional>
#include <string>

#include "fix.h"

#include "core/measure/guard.h"
#include "liggghts/common/ends_steps.h"
#include "liggghts/common/reads_overlap.h"
#include "liggghts/mill/liner_arguments.h"

namespace LAMMPS_NS {

class FixMillSimilarity;

/// Stops a faulty run and names the ball and the reason: velocities that are not finite or too
/// high, overlaps, balls beyond the liner. It also checks before a neighbour list, where the engine
/// would lose a ball without naming it. Changes nothing and needs no collective. Arguments:
/// docs/reference/styles/fix-mill-guard.md.
class FixMillGuard : public Fix, public EndsSteps, public ReadsOverlap {
 public:
  FixMillGuard(class LAMMPS*, int, char**);

  int setmask() override;
  void init() override;
  void setup_pre_exchange() override;
  void setup(int) override;
  void pre_exchange() override;
  void end_of_step() override;
  bool needs_arrays() const override;
  void end_step(const millscale::kernels::Advanced&) override;
  bool reads_overlap_now() override;

  double speed_limit() const { return speed_limit_; }  ///< [m/s]
  /// Return whether the speeds are checked at the end of the present step.
  bool checks_speeds_now() const;

 private:
  void parse(int narg, char** arg);
  void check_speeds() const;
  void check_forces() const;
  void check_box() const;
  void check_wall() const;
  void check_overlaps() const;
  double smallest_radius() const;
  void check_pairs_of(int i, const int* others, int count) const;
  millscale::liner::Point at_rest(const millscale::Vector& x) const;
  millscale::charge::Suspect suspect(int i) const;
  millscale::charge::Circumstances circumstances_of(const millscale::charge::Suspect& ball,
                                                    int i) const;
  bool past_end_of_box(const millscale::Vector& x) const;
  void check_speed(const millscale::charge::Suspect& ball, int i) const;
  [[noreturn]] void stop(int i, const std::string& fault) const;
  [[noreturn]] void stop(const millscale::charge::Suspect& ball, int i,
                         const std::string& fault) const;

  std::string mill_id_;
  FixMillSimilarity* mill_fix_ = nullptr;
  millscale::LinerArguments liner_arguments_;
  int every_, speeds_every_ = 1;  ///< steps between two checks
  double overlap_limit_;
  double speed_ = 0.0;        ///< asked for [m/s]; 0: derived from the mill
  double speed_limit_ = 0.0;  ///< [m/s]
  std::unique_ptr<millscale::charge::WallGuard> wall_;
  millscale::MillFrame frame_;
  millscale::Turn turn_{0.0};  ///< by the mill's angle at the last check
};

}  // namespace LAMMPS_NS
