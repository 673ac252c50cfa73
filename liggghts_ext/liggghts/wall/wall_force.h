#pragma once

#include <cstddef>

namespace LAMMPS_NS {

/// Vectors of local balls, at a fixed distance from each other in memory.
struct BallVectors {
  const double* first;    ///< of ball 0
  std::ptrdiff_t stride;  ///< from ball to ball, in doubles

  const double* operator[](int i) const { return first + i * stride; }
};

/// A number of each local ball, in double or single precision, or zero for all balls.
class BallNumbers {
 public:
  BallNumbers() = default;
  /// stride: from ball to ball, in numbers.
  BallNumbers(const double* first, std::ptrdiff_t stride) : doubles_(first), stride_(stride) {}
  BallNumbers(const float* first, std::ptrdiff_t stride) : singles_(first), stride_(stride) {}

  double operator[](int i) const
  {
    if (doubles_) return doubles_[i * stride_];
    return singles_ ? singles_[i * stride_] : 0.0;
  }

 private:
  const double* doubles_ = nullptr;
  const float* singles_ = nullptr;
  std::ptrdiff_t stride_ = 0;
};

/// What a wall reads of the local balls, in the engine's arrays or in rows.
struct WallInput {
  BallVectors position, velocity, spin;  ///< [m], [m/s], [rad/s]
  BallNumbers damping;  ///< sum of the tangential coefficients of contacts with balls at this step
                        ///< [kg/s]; read if the pair style limits the damping
};

/// Force of a wall on a local ball by one contact.
struct WallForce {
  int ball;
  double force[3];   ///< [N]
  double torque[3];  ///< about the ball's centre [N m]
  double damping;    ///< tangential coefficient, to add to the ball's sum [kg/s]
};

}  // namespace LAMMPS_NS
