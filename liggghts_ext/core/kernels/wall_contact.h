#pragma once

#include "core/contact/damping_limit.h"
#include "core/kernels/wall.h"

/// The contact of a ball with a wall. `Number` is a double or a pack of doubles.
namespace millscale::kernels {

template <class Number>
[[gnu::always_inline]] inline Vector3<Number> all(const Vector3<double>& v)
{
  return {Number(v.x), Number(v.y), Number(v.z)};
}

/// A ball that overlaps with a patch of the wall.
template <class Number>
struct OnPatch {
  Vector3<Number> arm;     ///< from the wall's origin to the ball's centre [m]
  Vector3<Number> normal;  ///< from the wall to the centre, unit vector
  Number overlap;          ///< >= 0 [m]
};

template <class Number>
[[gnu::always_inline]] inline OnPatch<Number> on_patch(const WallFrame& frame,
                                                       const liner::PatchOf<Number>& patch,
                                                       const Vector3<Number>& position,
                                                       const Number& radius)
{
  using contact::choose;
  const auto x = all<Number>(frame.x), z = all<Number>(frame.z), axis = all<Number>(frame.axis);
  const Vector3<Number> arm = position - all<Number>(frame.origin);
  const auto touch = liner::before(patch, dot(arm, x), dot(arm, z), dot(arm, axis));
  const Number overlap = radius - touch.distance, zero(0.0);
  return {arm, touch.normal_x * x + touch.normal_z * z + touch.normal_along * axis,
          choose(overlap > zero, overlap, zero)};
}

/// The motion of a ball.
template <class Number>
struct BallMotion {
  Number radius, mass;
  Vector3<Number> velocity, spin;
};

/// Return the contact. turns: of the patch.
template <class Number>
[[gnu::always_inline]] inline contact::Contact<Number> contact_of(
    const WallFrame& frame, const OnPatch<Number>& touch, const Number& turns,
    const BallMotion<Number>& ball, const Vector3<Number>& displacement,
    const Number& damping_share)
{
  const Vector3<Number> lever = touch.arm - (ball.radius - touch.overlap) * touch.normal;
  const Vector3<Number> of_wall = turns * cross(all<Number>(frame.spin), lever);
  return contact::contact_of(contact::BallOnWall<Number>{touch.normal, touch.overlap, ball.radius,
                                                         ball.mass, ball.velocity - of_wall,
                                                         ball.spin, displacement, damping_share});
}

}  // namespace millscale::kernels
