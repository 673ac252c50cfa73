#pragma once

#include "core/math/vector.h"

namespace millscale {

/// A point from the mill's origin, or a direction, by the mill's directions [m].
struct MillPoint {
  double ahead;  ///< along axis x down: the direction in which the bottom of the mill moves
  double below;  ///< along down, the direction of gravity
  double along;  ///< along the axis

  /// Return the point in the frame that turns with the mill. turn: by the mill's angle.
  MillPoint in_turning_frame(const Turn& turn) const
  {
    return {ahead * turn.cosine - below * turn.sine, below * turn.cosine + ahead * turn.sine,
            along};
  }
  /// Return the point at rest in space from one in the frame that turns with the mill.
  MillPoint in_space(const Turn& turn) const
  {
    return {ahead * turn.cosine + below * turn.sine, below * turn.cosine - ahead * turn.sine,
            along};
  }
};

/// Where the mill is in space: its axis, the direction of gravity and a point on the axis.
class MillFrame {
 public:
  MillFrame() : MillFrame({0.0, 1.0, 0.0}, {0.0, 0.0, -1.0}, {}) {}
  /// axis, down: unit vectors, perpendicular to each other; origin [m].
  MillFrame(const Vector& axis, const Vector& down, const Vector& origin)
      : axis_(axis), down_(down), ahead_(cross(axis, down)), origin_(origin)
  {
  }

  const Vector& axis() const { return axis_; }
  const Vector& down() const { return down_; }
  const Vector& ahead() const { return ahead_; }
  const Vector& origin() const { return origin_; }

  /// Return the vector from the origin to a position [m].
  Vector arm(const double* position) const
  {
    return {position[0] - origin_[0], position[1] - origin_[1], position[2] - origin_[2]};
  }
  Vector arm(const Vector& position) const { return arm(position.data()); }

  /// Return the components of a vector from the origin.
  MillPoint components(const Vector& arm) const
  {
    return {dot(arm, ahead_), dot(arm, down_), dot(arm, axis_)};
  }
  /// Return the components of a position.
  MillPoint point(const double* position) const { return components(arm(position)); }

  /// Return the vector with these components.
  Vector vector(const MillPoint& p) const
  {
    Vector v;
    for (int d = 0; d < 3; ++d)
      v[d] = p.ahead * ahead_[d] + p.below * down_[d] + p.along * axis_[d];
    return v;
  }

 private:
  Vector axis_, down_, ahead_, origin_;
};

}  // namespace millscale
