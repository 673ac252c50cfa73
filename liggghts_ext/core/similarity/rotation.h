#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/similarity/speed_schedule.h"

namespace millscale::similarity {

/// The mill's angle as a function of the time step, without accumulated increments: angle =
/// angle_before + schedule(omega max(0, t - start)), and t = time_base + (step - step_base) dt. The
/// angle after 1e7 steps is as exact as after one. The base changes only with the step size or the
/// step counter, `angle_before` only with the speed.
struct Rotation {
  double omega = 0.0;         ///< [rad/s]
  double start = 0.0;         ///< the mill turns from this time on [s]
  double angle_before = 0.0;  ///< angle up to `start` [rad]
  double time_base = 0.0;     ///< time at step_base [s]
  std::int64_t step_base = 0;
  double dt = 0.0;         ///< step size since step_base [s]
  SpeedSchedule schedule;  ///< from `angle_before` on; by default always at omega

  double time(std::int64_t step) const
  {
    return time_base + static_cast<double>(step - step_base) * dt;
  }
  bool turning(std::int64_t step) const { return time(step) > start; }
  double angle(std::int64_t step) const { return angle_before + schedule.angle(phase(step)); }
  double speed(std::int64_t step) const
  {
    return turning(step) ? omega * schedule.speed(phase(step)) : 0.0;
  }

  /// Return the step nearest to the time at which the mill reaches an angle [rad], >= angle_before.
  /// Half steps are rounded down, also if rounding of the time has made them a little more.
  double step_at(double angle) const
  {
    const double time = start + schedule.phase(angle - angle_before) / omega;
    return static_cast<double>(step_base) + nearest_step((time - time_base) / dt);
  }

  /// Return the number of steps nearest to a number that is not whole.
  static double nearest_step(double steps) { return std::ceil(steps - 0.5 - 1e-6); }

  /// Continue with another step size from `step` on.
  void set_step_size(std::int64_t step, double new_dt)
  {
    if (new_dt == dt) return;
    time_base = time(step);
    step_base = step;
    dt = new_dt;
  }

  /// Renumber the steps: the counter changed from `old_step` to `new_step` at the same time.
  void renumber(std::int64_t old_step, std::int64_t new_step)
  {
    if (old_step == new_step) return;
    time_base = time(old_step);
    step_base = new_step;
  }

  /// Continue with another speed from `step` on; `whole`: the schedule from angle 0 on.
  void set_speed(std::int64_t step, double new_omega, const SpeedSchedule& whole = {})
  {
    angle_before = angle(step);
    start = std::max(start, time(step));
    omega = new_omega;
    schedule = whole.after(angle_before);
  }

 private:
  double phase(std::int64_t step) const { return omega * std::max(0.0, time(step) - start); }
};

}  // namespace millscale::similarity
