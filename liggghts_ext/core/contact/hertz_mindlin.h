#pragma once

#include <cmath>

#include "core/contact/material.h"
#include "core/math/checks.h"
#include "core/math/constants.h"

namespace millscale::contact {

/// Two bodies in contact: effective radius [m], effective mass [kg], effective moduli [Pa] and the
/// damping factor |ln e| / sqrt(ln^2 e + pi^2) [-].
struct Pair {
  double radius, mass, youngs_modulus, shear_modulus, damping;
};

/// Stiffness [N/m] and damping coefficients [kg/s] of a contact at one overlap.
struct Coefficients {
  double normal_stiffness;      ///< secant: F = k_n delta
  double tangential_stiffness;  ///< F = k_t times the tangential displacement
  double normal_damping, tangential_damping;
};

/// Return the mass of a ball [kg].
inline double ball_mass(const Material& material, double radius)
{
  return 4.0 / 3.0 * pi * material.density * radius * radius * radius;
}

/// Return the damping factor of a restitution 0 < e <= 1 [-]: |ln e| / sqrt(ln^2 e + pi^2). In
/// `coefficients` it gives exactly that restitution. Antypov, Elliott, EPL 94 (2011) 50004,
/// doi 10.1209/0295-5075/94/50004.
inline double damping_factor(double restitution)
{
  if (!(restitution > 0.0 && restitution <= 1.0))
    reject("restitution", "must be > 0 and <= 1", restitution);
  const double log_e = -std::log(restitution);
  return log_e / std::hypot(log_e, pi);
}

/// Return the damping over critical damping of the normal mode, linearised at any overlap [-]:
/// sqrt(5/6) times the damping factor.
inline double damping_ratio(double restitution)
{
  return std::sqrt(5.0 / 6.0) * damping_factor(restitution);
}

/// Return the pair of two equal balls of a radius [m].
inline Pair ball_on_ball(const Material& ball, double radius, double restitution)
{
  check(ball);
  require_positive("ball radius", "m", radius);
  return {0.5 * radius, 0.5 * ball_mass(ball, radius), effective_youngs_modulus(ball, ball),
          effective_shear_modulus(ball, ball), damping_factor(restitution)};
}

/// Return the pair of a ball of a radius [m] and a flat wall.
inline Pair ball_on_wall(const Material& ball, const Material& wall, double radius,
                         double restitution)
{
  check(ball);
  check(wall);
  require_positive("ball radius", "m", radius);
  return {radius, ball_mass(ball, radius), effective_youngs_modulus(ball, wall),
          effective_shear_modulus(ball, wall), damping_factor(restitution)};
}

/// Return the coefficients of the Hertz-Mindlin contact as LIGGGHTS evaluates it (normal model
/// hertz, tangential model history) at an overlap >= 0 [m]. Powder Technology 335 (2018) 91-102,
/// Eqs. 16-21: k_n = 4/3 E* a, k_t = 8 G* a with a = sqrt(R* delta), and damping 2 sqrt(5/6) beta
/// sqrt(S m*) with S_n = 2 E* a (tangent stiffness) and S_t = 8 G* a.
inline Coefficients coefficients(const Pair& pair, double overlap)
{
  const double contact_radius = std::sqrt(pair.radius * overlap);
  const double tangent = 2.0 * pair.youngs_modulus * contact_radius;
  const double tangential = 8.0 * pair.shear_modulus * contact_radius;
  const double damping = 2.0 * std::sqrt(5.0 / 6.0) * pair.damping;
  return {2.0 / 3.0 * tangent, tangential, damping * std::sqrt(tangent * pair.mass),
          damping * std::sqrt(tangential * pair.mass)};
}

/// Return the largest overlap [m] of an undamped impact at a relative normal speed [m/s]:
/// (15 m v^2 / (16 E* sqrt(R*)))^(2/5). Hertz: kinetic energy m* v^2 / 2 goes into
/// 8/15 E* sqrt(R*) delta^(5/2). Damping makes the overlap smaller, so this is an upper bound.
inline double hertz_overlap(const Pair& pair, double speed)
{
  require_positive("impact speed", "m/s", speed);
  return std::pow(
      15.0 * pair.mass * speed * speed / (16.0 * pair.youngs_modulus * std::sqrt(pair.radius)),
      0.4);
}

/// Return the duration of an undamped impact [s]: 2.94 overlap / speed, the constant being
/// 4/5 sqrt(pi) Gamma(2/5) / Gamma(9/10), twice the integral of (1 - x^(5/2))^(-1/2) over 0..1.
/// Timoshenko, Goodier, Theory of Elasticity, 3rd ed., section 142.
inline double hertz_collision_time(const Pair& pair, double speed)
{
  static const double constant = 0.8 * std::sqrt(pi) * std::tgamma(0.4) / std::tgamma(0.9);
  return constant * hertz_overlap(pair, speed) / speed;
}

}  // namespace millscale::contact
