#pragma once

namespace millscale::kernels {
struct Advanced;
}

namespace LAMMPS_NS {

/// A fix that acts at the end of every step, but needs the engine's arrays of the balls at few of
/// them. The time loop then keeps the balls in rows for all other steps.
class EndsSteps {
 public:
  virtual ~EndsSteps() = default;

  /// Return whether the present step must end with the engine's `end_of_step` and its arrays. All
  /// ranks must return the same.
  virtual bool needs_arrays() const = 0;

  /// End a step without the engine's arrays, from what the pass over the balls has found.
  virtual void end_step(const millscale::kernels::Advanced&) = 0;
};

}  // namespace LAMMPS_NS
