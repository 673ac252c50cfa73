#pragma once

#include <cstddef>
#include <cstdint>

#include "core/contact/contact_force.h"
#include "core/liner/patch.h"
#include "core/math/vector3.h"

namespace millscale::kernels {

/// A number or a vector of each ball, in an array or in rows.
struct BallNumbers {
  const double* first;    ///< of ball 0
  std::ptrdiff_t stride;  ///< from ball to ball, in doubles

  const double* operator[](int i) const { return first + i * stride; }
};

/// A sum of each ball, in double or single precision, or zero for all balls.
class BallSums {
 public:
  BallSums() = default;
  /// stride: from ball to ball, in numbers.
  BallSums(const double* first, std::ptrdiff_t stride) : doubles_(first), stride_(stride) {}
  BallSums(const float* first, std::ptrdiff_t stride) : singles_(first), stride_(stride) {}

  [[gnu::always_inline]] double operator[](int i) const
  {
    if (doubles_) return doubles_[i * stride_];
    return singles_ ? static_cast<double>(singles_[i * stride_]) : 0.0;
  }

 private:
  const double* doubles_ = nullptr;
  const float* singles_ = nullptr;
  std::ptrdiff_t stride_ = 0;
};

/// What a wall reads of the local balls.
struct WallInput {
  BallNumbers position, radius;  ///< [m]
  BallNumbers velocity, mass;    ///< [m/s], [kg]
  BallNumbers spin;              ///< [rad/s]
  BallSums damping;  ///< sum of the tangential coefficients of contacts with balls at this step
                     ///< [kg/s]; read if the pair style limits the damping
};

/// Where a turning wall is in space. Its own directions x and z span the cross-section.
struct WallFrame {
  Vector3<double> origin;      ///< [m]
  Vector3<double> x, z, axis;  ///< unit vectors
  Vector3<double> spin;        ///< [rad/s]
};

/// Balls that may touch the wall before the next neighbour list, and when they are searched for
/// contacts again. The arrays reach beyond the last ball, to a multiple of any pack; the numbers of
/// balls there are valid.
struct NearBalls {
  const int* ball;
  const double *x, *z, *along;  ///< centre at the last search, in the wall's directions [m]
  const double* clear2;  ///< square of the distance the centre can move until the next search [m^2]
  int count;
};

/// Contacts to evaluate together. All contacts of a ball are in one batch, one after the other. The
/// last pack may read and write beyond `count`, within the arrays.
struct WallBatch {
  static constexpr int most = 64;  ///< a multiple of any pack
  int count = 0;
  int ball[most], patch[most], law[most];
  alignas(64) double displacement[3][most];  ///< tangential, before the step [m]

  // Results. Where the overlap is 0 there is no contact, and no force.
  alignas(64) double overlap[most];        ///< [m]
  alignas(64) double damping_share[most];  ///< of the ball, `contact::damping_share` [-]
  alignas(64) double stretch[3][most];     ///< tangential displacement after the step [m]
  alignas(64) double force[3][most];       ///< on the ball [N]
  alignas(64) double torque[3][most];      ///< about the ball's centre [N m]
  alignas(64) double moment[3][most];      ///< force and torque about the wall's origin [N m]
  alignas(64) double damping[most];        ///< tangential coefficient [kg/s]

  // Further results of `evaluate_recorded`.
  alignas(64) double loads[3][most];    ///< force without the elastic normal force [N]
  alignas(64) double wall_power[most];  ///< of these loads and the torque, on the ball [W]
  alignas(64) double approach[most];    ///< 1/2 m v_n^2, 0 if the ball leaves [J]
  alignas(64) double stored[most];      ///< by the tangential spring [J]
};

/// What the contacts with a wall need. Nothing is owned here.
struct WallTask {
  WallInput balls;
  WallFrame frame;
  const liner::Patch* patches;
  const contact::ContactLaw<double>* laws;
  int only_law;  ///< the law of all contacts; -1 where they differ
  contact::ContactTerms terms;
  bool damping_of_balls;  ///< the limit counts the contacts with balls
  double dt;              ///< [s]; 0 at set-up
};

/// The kernels of walls, compiled for a set of instructions. Each contact has the same bits in any
/// place of any batch, on any machine: there are no fused multiply-adds, and roots and quotients
/// are those of IEEE 754.
struct WallKernels {
  /// Return a bit for each of up to 64 balls from `first` on that has moved as far as it could.
  std::uint64_t (*moved)(const WallTask&, const NearBalls&, int first);
  void (*evaluate)(const WallTask&, WallBatch&);
  void (*evaluate_recorded)(const WallTask&, WallBatch&);  ///< with the further results
};

}  // namespace millscale::kernels
