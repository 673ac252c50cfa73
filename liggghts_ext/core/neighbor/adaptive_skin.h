#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/math/vector.h"
#include "core/neighbor/speed_map.h"

namespace millscale::neighbor {

/// A frame that turns about an axis. Distances are the same in every frame, so the pair list may
/// measure displacements in the frame where the particles move least: that of the mill.
struct TurningFrame {
  Vector origin{}, axis{0.0, 1.0, 0.0};  ///< [m], unit vector
  double rate = 0.0;                     ///< [rad/s]
};

/// Per-particle Verlet skin. The pair list holds the pairs whose surfaces are within the sum of
/// both skins; it is valid until a particle has moved by its own skin, in the turning frame. Slow
/// particles have small skins, so the list is short; fast particles have large ones, so it lasts.
class AdaptiveSkin {
 public:
  /// Smallest skin over the particle's radius [-].
  static constexpr double min_share = 0.05;

  /// Set one skin [m] for all particles: the list then depends on positions only.
  void set_uniform(const Particles& particles, double skin)
  {
    skin_.assign(particles.total(), skin);
    by_speed_ = false;
  }

  /// Set each local particle's skin to the distance that the fastest particle in the 27 nearby
  /// cells of the map covers in `time` [s], at most `most` [m]. A particle at rest covers it when
  /// it is hit. Owners send ghost skins.
  void set_by_speed(const Particles& particles, const TurningFrame& frame, double most, double time)
  {
    frame_ = frame;
    by_speed_ = true;
    speed_.resize(particles.total());
    Bounds bounds;
    double largest = 0.0;
    for (int i = 0; i < particles.total(); ++i) {
      const Vector direction = cross(frame.axis, from_origin(particles.position[i]));
      double square = 0.0;
      for (int d = 0; d < 3; ++d) {
        const double relative = particles.velocity[i][d] - frame.rate * direction[d];
        square += relative * relative;
      }
      speed_[i] = static_cast<float>(std::sqrt(square));
      largest = std::max(largest, particles.radius[i]);
      bounds.add(particles.position[i]);
    }
    map_.make(particles, bounds, (1.0 + 1e-6) * 2.0 * (largest + most), speed_);
    skin_.resize(particles.total());
    start_.resize(particles.nlocal);
    for (int i = 0; i < particles.nlocal; ++i) {
      skin_[i] = std::min(most, min_share * particles.radius[i] + time * map_.around(i));
      start_[i] = from_origin(particles.position[i]);
    }
  }

  /// Return whether a local particle has moved by more than its skin `time` [s] after the build, or
  /// the number of local particles has changed. Return false for a uniform skin: the engine checks
  /// its own.
  bool exceeded(const double (*position)[3], int nlocal, double time) const
  {
    if (!by_speed_) return false;
    if (nlocal != static_cast<int>(start_.size())) return true;
    Vector column[3], row[3];  // of the rotation matrix
    turn_columns(time, column);
    for (int d = 0; d < 3; ++d)
      for (int e = 0; e < 3; ++e) row[e][d] = column[d][e];
    bool beyond = false;
    for (int i = 0; i < nlocal; ++i) {
      double square = 0.0;
      for (int d = 0; d < 3; ++d) {
        const double moved = position[i][d] - frame_.origin[d] - dot(row[d], start_[i]);
        square += moved * moved;
      }
      beyond |= !(square <= skin_[i] * skin_[i]);  // also true for NaN positions
    }
    return beyond;
  }

  /// Write the columns of the matrix that turns the frame by its motion in `time` [s].
  void turn_columns(double time, Vector* column) const
  {
    const Turn turn(frame_.rate * time);
    for (int d = 0; d < 3; ++d) {
      Vector unit{};
      unit[d] = 1.0;
      column[d] = rotated(unit, frame_.axis, turn);
    }
  }

  const Vector& origin() const { return frame_.origin; }

  /// Return whether `exceeded` must be evaluated at every step.
  bool by_speed() const { return by_speed_; }
  double& operator[](int i) { return skin_[i]; }
  const double* data() const { return skin_.data(); }

 private:
  Vector from_origin(const double* x) const
  {
    return {x[0] - frame_.origin[0], x[1] - frame_.origin[1], x[2] - frame_.origin[2]};
  }

  TurningFrame frame_;
  bool by_speed_ = false;
  SpeedMap map_;
  std::vector<double> skin_;   ///< (total) [m]
  std::vector<float> speed_;   ///< (total) in the frame [m/s]
  std::vector<Vector> start_;  ///< (nlocal) positions from the origin at the build [m]
};

}  // namespace millscale::neighbor
