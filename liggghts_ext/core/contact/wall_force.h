#pragma once

#include <cmath>

#include "core/contact/damping_bound.h"
#include "core/contact/hertz_mindlin.h"
#include "core/math/vector.h"

namespace millscale::contact {

using millscale::cross;  // beside those of `Triple`
using millscale::dot;

/// Friction of a contact: Coulomb's coefficient and rolling friction [-].
struct Friction {
  double sliding, rolling;
};

/// A ball pressed on a wall.
struct WallTouch {
  double ball_radius;  ///< [m]
  double overlap;      ///< > 0 [m]
  Vector normal;       ///< unit vector from the wall to the ball's centre
  Vector velocity;     ///< of the ball's centre relative to the wall at the contact [m/s]
  Vector spin;         ///< of the ball [rad/s]
};

/// What the force on the ball is made of, for the account of its energy (contact_energy.h).
struct WallParts {
  double lever = 0.0;               ///< from the ball's centre to half the overlap [m]
  double spring = 0.0, push = 0.0;  ///< elastic and whole normal force [N]
  double stiffness = 0.0;           ///< k_t at this overlap [N/m]
  double slipped = 0.0;             ///< by how much the memory was cut by Coulomb's limit [m]
  Vector tangential{}, damped{};    ///< whole tangential force, and the dashpot's in it [N]
  Vector rolling{};                 ///< torque of rolling friction [N m]
};

struct ForceAndTorque {
  Vector force{};        ///< on the ball [N]
  Vector torque{};       ///< on the ball about its centre [N m]
  double damping = 0.0;  ///< tangential coefficient, 0 if the contact slips [kg/s]
  WallParts parts;
};

namespace detail {

/// Velocity of the ball's surface along the wall [m/s]; the lever is from the centre to half the
/// overlap.
inline Vector sliding_velocity(const WallTouch& touch, double lever)
{
  const double normal_speed = dot(touch.velocity, touch.normal);
  const Vector rolling = cross(touch.spin, touch.normal);
  Vector v;
  for (int d = 0; d < 3; ++d)
    v[d] = touch.velocity[d] - normal_speed * touch.normal[d] - lever * rolling[d];
  return v;
}

/// Mindlin spring with memory, capped by Coulomb's limit; damped only while it sticks. Advances
/// `displacement` by `dt`; with dt = 0 the memory is used as it is. Returns whether it sticks.
inline bool tangential_force(const Coefficients& k, double limit, const Vector& sliding,
                             const Vector& normal, double dt, Vector& displacement,
                             WallParts& parts)
{
  if (dt > 0.0) {
    for (int d = 0; d < 3; ++d) displacement[d] += sliding[d] * dt;
    const double along = dot(displacement, normal);
    for (int d = 0; d < 3; ++d) displacement[d] -= along * normal[d];
  }
  const double elastic = k.tangential_stiffness * std::sqrt(dot(displacement, displacement));
  parts.stiffness = k.tangential_stiffness;
  if (elastic > limit) {
    const double share = limit / elastic;
    parts.slipped = (elastic - limit) / k.tangential_stiffness;
    for (int d = 0; d < 3; ++d) {
      parts.tangential[d] = -k.tangential_stiffness * displacement[d] * share;
      if (dt > 0.0) displacement[d] *= share;
    }
    return false;
  }
  for (int d = 0; d < 3; ++d) {
    parts.damped[d] = -k.tangential_damping * sliding[d];
    parts.tangential[d] =
        -k.tangential_stiffness * displacement[d] - k.tangential_damping * sliding[d];
  }
  return true;
}

/// Rolling friction as a torque of constant size against the spin, without its part about the
/// normal (twisting).
inline Vector rolling_torque(double size, const WallTouch& touch)
{
  const double speed = std::sqrt(dot(touch.spin, touch.spin));
  Vector torque{};
  if (!(speed > 0.0)) return torque;
  for (int d = 0; d < 3; ++d) torque[d] = -size * touch.spin[d] / speed;
  const double twist = dot(torque, touch.normal);
  for (int d = 0; d < 3; ++d) torque[d] -= twist * touch.normal[d];
  return torque;
}

}  // namespace detail

/// Force and torque of a wall on a ball: Hertz-Mindlin with damping, tangential memory and constant
/// rolling friction, as LIGGGHTS evaluates `hertz`, `history` and `cdt` at a wall. Powder
/// Technology 335 (2018) 91-102, Eqs. 16-22. Damping may make the normal force attractive at the
/// end of an impact, as there. `displacement` [m] is the contact's memory; dt [s] is 0 at set-up.
/// The tangential coefficient is divided by 1 + `held`, of `damping_held`; 0 leaves it as it is.
inline ForceAndTorque wall_force(const Pair& pair, const Friction& friction, const WallTouch& touch,
                                 double dt, Vector& displacement, double held = 0.0)
{
  Coefficients k = coefficients(pair, touch.overlap);
  const double undivided = k.tangential_damping;
  k.tangential_damping /= 1.0 + held;
  const double normal_speed = dot(touch.velocity, touch.normal);
  const double elastic = k.normal_stiffness * touch.overlap;
  const double normal_force = elastic - k.normal_damping * normal_speed;
  const double lever = touch.ball_radius - 0.5 * touch.overlap;
  const Vector sliding = detail::sliding_velocity(touch, lever);
  ForceAndTorque result;
  WallParts& parts = result.parts;
  parts.lever = lever;
  parts.spring = elastic;
  parts.push = normal_force;
  if (detail::tangential_force(k, friction.sliding * std::abs(normal_force), sliding, touch.normal,
                               dt, displacement, parts))
    result.damping = undivided;
  for (int d = 0; d < 3; ++d)
    result.force[d] = normal_force * touch.normal[d] + parts.tangential[d];
  const Vector moment = cross(touch.normal, parts.tangential);
  for (int d = 0; d < 3; ++d) result.torque[d] = -lever * moment[d];
  if (friction.rolling > 0.0) {
    parts.rolling = detail::rolling_torque(friction.rolling * elastic * pair.radius, touch);
    for (int d = 0; d < 3; ++d) result.torque[d] += parts.rolling[d];
  }
  return result;
}

}  // namespace millscale::contact
