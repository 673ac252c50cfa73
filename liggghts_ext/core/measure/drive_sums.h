#pragma once

#include <array>
#include <cstdint>

namespace millscale::charge {

/// Torque of the drive on the charge, summed over the steps of velocity Verlet.
///
/// The integrator applies the forces of step n in two half steps of dt/2, before and after the
/// velocities of step n. The angular impulse up to these velocities is the sum of the torques, with
/// half a step for the first and the last torque. It equals the change of the charge's angular
/// momentum about the axis exactly. The half step after step n waits for the next step. A torque
/// may alternate from step to step, so a single step's torque is not meaningful.
///
/// All numbers are plain sums over balls and ranks.
class DriveSums {
 public:
  /// Begin a run. torque [N m], power [W]: of the forces of the first half step.
  void wait_for(double torque, double power, double dt)
  {
    waiting_impulse_ = 0.5 * dt * torque;
    waiting_work_ = 0.5 * dt * power;
  }

  /// Add the step `step` of dt [s] with the torque [N m] and power [W] of its forces.
  void add(double torque, double power, double dt, std::int64_t step)
  {
    impulse_ += waiting_impulse_ + 0.5 * dt * torque;
    work_ += waiting_work_ + 0.5 * dt * power;
    wait_for(torque, power, dt);
    by_parity_[static_cast<std::size_t>(step % 2)] += torque;
  }

  double impulse() const { return impulse_; }  ///< since the start [N m s]
  double work() const { return work_; }        ///< since the start [J]

  /// Return half the difference between the mean torques of even and of odd steps, over the last
  /// `steps` steps up to `last` [N m]; 0 for a single step.
  double alternating(std::int64_t last, std::int64_t steps) const
  {
    const std::int64_t of_last = (steps + 1) / 2, of_other = steps / 2;
    if (of_other == 0) return 0.0;
    const std::size_t parity = static_cast<std::size_t>(last % 2);
    const double half = 0.5 * (by_parity_[parity] / static_cast<double>(of_last) -
                               by_parity_[1 - parity] / static_cast<double>(of_other));
    return parity == 0 ? half : -half;
  }
  void begin_interval() { by_parity_ = {}; }

  DriveSums& operator+=(const DriveSums& other)
  {
    impulse_ += other.impulse_;
    work_ += other.work_;
    waiting_impulse_ += other.waiting_impulse_;
    waiting_work_ += other.waiting_work_;
    for (std::size_t k = 0; k < by_parity_.size(); ++k) by_parity_[k] += other.by_parity_[k];
    return *this;
  }

 private:
  double impulse_ = 0.0, work_ = 0.0;
  double waiting_impulse_ = 0.0, waiting_work_ = 0.0;
  std::array<double, 2> by_parity_{};  ///< torque sums of even and of odd steps
};

}  // namespace millscale::charge
