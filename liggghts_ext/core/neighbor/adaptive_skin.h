#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/math/vector.h"
#include "core/neighbor/pair_list.h"

namespace millscale::pairs {

/// Turns about an axis. Two places are as far apart seen from it as they are, so what matters for a
/// list of pairs is how balls move in it: those the mill carries along rest.
struct TurningFrame {
  Vector origin{}, axis{0.0, 1.0, 0.0};  ///< [m], unit vector
  double rate = 0.0;                     ///< [rad/s]
};

/// How far each ball may go, seen from a turning frame, until its list of pairs must be made anew:
/// the list holds the pairs whose surfaces are within the sum of both margins. Balls that will not
/// go far have small ones, so the list is short; fast balls have large ones, so it lasts.
class Margins {
 public:
  /// Share of its radius that a margin is at least.
  static constexpr double least_share = 0.05;

  /// The same for all: the list then depends on places alone.
  void set_same(const Balls& balls, double margin)
  {
    margin_.assign(balls.all, margin);
    by_speed_ = false;
  }

  /// Sets each local particle's skin to the distance that the fastest particle in the 27 nearby
  /// cells covers in `time` [s], at most `most` [m]. A particle at rest covers it when it is hit.
  /// The grid is sorted with these balls. Owners send ghost skins.
  void set_by_speed(const Balls& balls, CellGrid& grid, const TurningFrame& frame, double most,
                    double time)
  {
    frame_ = frame;
    by_speed_ = true;
    speed_.resize(balls.all);
    for (int i = 0; i < balls.all; ++i) {
      const Vector carried = cross(frame.axis, from_origin(balls.position[i]));
      double square = 0.0;
      for (int d = 0; d < 3; ++d) {
        const double relative = balls.velocity[i][d] - frame.rate * carried[d];
        square += relative * relative;
      }
      speed_[i] = std::sqrt(square);
    }
    grid.largest_around(speed_);
    margin_.resize(balls.all);
    start_.resize(balls.owned);
    for (int i = 0; i < balls.owned; ++i) {
      margin_[i] = std::min(most, least_share * balls.radius[i] + time * speed_[i]);
      start_[i] = from_origin(balls.position[i]);
    }
  }

  /// Whether, `time` [s] later, one of the owned balls has left its margin, or there are more or
  /// fewer of them. Never with the same margins for all: the engine looks after those.
  bool outrun(const double (*position)[3], int owned, double time) const
  {
    if (!by_speed_) return false;
    if (owned != static_cast<int>(start_.size())) return true;
    const Turn turn(frame_.rate * time);
    Vector row[3];  // of the matrix that turns
    for (int d = 0; d < 3; ++d) {
      Vector unit{};
      unit[d] = 1.0;
      const Vector column = rotated(unit, frame_.axis, turn);
      for (int e = 0; e < 3; ++e) row[e][d] = column[e];
    }
    bool left = false;
    for (int i = 0; i < owned; ++i) {
      double square = 0.0;
      for (int d = 0; d < 3; ++d) {
        const double gone = position[i][d] - frame_.origin[d] - dot(row[d], start_[i]);
        square += gone * gone;
      }
      left |= !(square <= margin_[i] * margin_[i]);  // also true for NaN positions
    }
    return left;
  }

  /// Whether `outrun` must be asked at every step.
  bool by_speed() const { return by_speed_; }
  double& operator[](int i) { return margin_[i]; }
  const double* of_balls() const { return margin_.data(); }

 private:
  Vector from_origin(const double* x) const
  {
    return {x[0] - frame_.origin[0], x[1] - frame_.origin[1], x[2] - frame_.origin[2]};
  }

  TurningFrame frame_;
  bool by_speed_ = false;
  std::vector<double> margin_;  ///< (all) [m]
  std::vector<double> speed_;   ///< (all) seen from the frame, then the largest around [m/s]
  std::vector<Vector> start_;   ///< (owned) places from the origin [m]
};

}  // namespace millscale::pairs
