#pragma once

#include <algorithm>
#include <cstdint>

namespace millscale::similarity {

/// The mill's angle as a function of the time step, without accumulated increments: angle =
/// angle_before + omega max(0, t - start), and t = time_base + (step - step_base) dt. The angle
/// after 1e7 steps is as exact as after one. The base changes only with the step size or the step
/// counter, `angle_before` only with the speed.
struct Rotation {
  double omega = 0.0;         ///< [rad/s]
  double start = 0.0;         ///< the mill turns from this time on [s]
  double angle_before = 0.0;  ///< angle up to `start` [rad]
  double time_base = 0.0;     ///< time at step_base [s]
  std::int64_t step_base = 0;
  double dt = 0.0;  ///< step size since step_base [s]

  double time(std::int64_t step) const
  {
    return time_base + static_cast<double>(step - step_base) * dt;
  }
  bool turning(std::int64_t step) const { return time(step) > start; }
  double angle(std::int64_t step) const
  {
    return angle_before + omega * std::max(0.0, time(step) - start);
  }
  double speed(std::int64_t step) const { return turning(step) ? omega : 0.0; }

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

  /// Continue with another speed from `step` on.
  void set_speed(std::int64_t step, double new_omega)
  {
    if (new_omega == omega) return;
    angle_before = angle(step);
    start = std::max(start, time(step));
    omega = new_omega;
  }
};

}  // namespace millscale::similarity
