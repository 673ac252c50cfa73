#pragma once

#include <array>
#include <cmath>

#include "core/contact/ball_force.h"
#include "core/contact/wall_force.h"
#include "core/math/vector.h"

namespace millscale::contact {

/// Kinds of work that a contact does on its balls.
enum Work { normal_spring, normal_dashpot, tangential_spring, tangential_dashpot, rolling, works };

/// Force and torque on a ball [N], [N m]: the first three, the last three.
using Load = std::array<double, 6>;

/// A ball's load, by kind of work.
using Loads = std::array<Load, works>;

/// One contact as its account of energy sees it, of two balls or of a ball and the wall.
struct EnergyOfContact {
  Vector normal;                        ///< towards the ball that the forces act on
  double overlap;                       ///< [m]
  double spring, push;                  ///< elastic and whole normal force [N]
  double stiffness, stretch;            ///< k_t [N/m] and size of the tangential memory [m]
  double slipped;                       ///< by how much Coulomb's limit cut that memory [m]
  Vector tangential, damped, rolling_;  ///< tangential force, the dashpot's in it [N]; torque [N m]

  /// 2/5 F delta: the integral of Hertz' force [J].
  double stored_in_normal_spring() const { return 0.4 * spring * overlap; }

  /// 1/2 k_t xi^2 with k_t of the present overlap [J]. A spring whose stiffness follows the overlap
  /// takes or gives -1/2 xi^2 dk_t besides: that is no energy of the contact, it is the law's.
  double stored_in_tangential_spring() const { return 0.5 * stiffness * stretch * stretch; }

  /// Coulomb's force times the way slid in this step [J].
  double slip() const { return stiffness * stretch * slipped; }
};

inline Vector vector_of(const Triple<double>& a)
{
  return {a.x, a.y, a.z};
}

inline double size_of(const Vector& a)
{
  return std::sqrt(dot(a, a));
}

/// The forces act on ball i.
inline EnergyOfContact energy_of(const BallForces<double>& forces)
{
  const BallParts<double>& p = forces.parts;
  const auto tangential = forces.force - p.push * p.normal;
  return {vector_of(p.normal),
          p.overlap,
          p.spring,
          p.push,
          p.stiffness,
          size_of(vector_of(forces.displacement)),
          p.slipped,
          vector_of(tangential),
          vector_of(p.damped),
          vector_of(p.rolling)};
}

/// displacement: the contact's memory after the force [m].
inline EnergyOfContact energy_of(const WallTouch& touch, const ForceAndTorque& on_ball,
                                 const Vector& displacement)
{
  const WallParts& p = on_ball.parts;
  return {touch.normal,          touch.overlap, p.spring,     p.push,   p.stiffness,
          size_of(displacement), p.slipped,     p.tangential, p.damped, p.rolling};
}

/// Adds what the contact puts on one of its balls. sign: 1 for the ball that the forces act on, -1
/// for its partner; lever: from that ball's centre to the contact [m].
inline void add_loads(const EnergyOfContact& contact, double sign, double lever, Loads& loads)
{
  const Vector& n = contact.normal;
  const auto add_tangential = [&](const Vector& force, Load& load) {
    const Vector moment = cross(n, force);
    for (int d = 0; d < 3; ++d) {
      load[d] += sign * force[d];
      load[3 + d] -= lever * moment[d];  // both balls turn the same way
    }
  };
  Vector by_spring;
  for (int d = 0; d < 3; ++d) {
    loads[normal_spring][d] += sign * contact.spring * n[d];
    loads[normal_dashpot][d] += sign * (contact.push - contact.spring) * n[d];
    loads[rolling][3 + d] += sign * contact.rolling_[d];
    by_spring[d] = contact.tangential[d] - contact.damped[d];
  }
  add_tangential(by_spring, loads[tangential_spring]);
  add_tangential(contact.damped, loads[tangential_dashpot]);
}

/// Power of a load on a ball of these velocities [W].
inline double power(const Load& load, const Vector& velocity, const Vector& spin)
{
  return load[0] * velocity[0] + load[1] * velocity[1] + load[2] * velocity[2] + load[3] * spin[0] +
         load[4] * spin[1] + load[5] * spin[2];
}

/// Energy of the approach at first touch, 1/2 m* v_n^2 [J]; 0 if they part.
inline double approach_energy(double effective_mass, double normal_speed)
{
  return normal_speed < 0.0 ? 0.5 * effective_mass * normal_speed * normal_speed : 0.0;
}

}  // namespace millscale::contact
