#pragma once

#include <algorithm>
#include <cmath>

#include "core/contact/hertz_mindlin.h"
#include "core/math/checks.h"
#include "core/math/constants.h"

namespace millscale::contact {

/// Return the time of a Rayleigh wave around a ball [s]: pi a sqrt(rho / G) / (0.1631 nu + 0.8766).
/// Thornton, Randall, in: Micromechanics of Granular Materials (1988) 133. Time steps of DEM are
/// usually 5 to 20 % of it, but see damping_time_step_limit.
inline double rayleigh_time(const Material& material, double radius)
{
  check(material);
  require_positive("ball radius", "m", radius);
  return pi * radius * std::sqrt(material.density / shear_modulus(material)) /
         (0.1631 * material.poisson_ratio + 0.8766);
}

/// Return the mean overlap over ball radius of a bed of this depth [m] under its own weight: 1.06
/// (rho g d / E)^(2/3).
///
/// Hertz contacts carry the weight above them. The factor follows from the 0.16 mm measured in the
/// S = 2.6 mill of the paper; derived here.
inline double bed_overlap(const Material& material, double gravity, double depth)
{
  check(material);
  return 1.06 * std::pow(material.density * gravity * depth / material.youngs_modulus, 2.0 / 3.0);
}

/// Return the largest stable time step of a damped linear mode, 2 (sqrt(1 + zeta^2) - zeta) / omega
/// [s], under velocity Verlet with forces at the half-step velocity.
///
/// Derived here. With x' the position after the drift and v the half-step velocity, a step is x' =
/// x + dt v, v' = v - dt (omega^2 x' + 2 zeta omega v). An amplification by -1 occurs first, where
/// 4 - 4 zeta h - h^2 = 0 with h = omega dt. Undamped: h < 2. Valid for any zeta >= 0.
inline double damped_mode_limit(double omega, double zeta)
{
  // Equal to 2 (sqrt(1 + zeta^2) - zeta), without its cancellation at large zeta.
  return 2.0 / (omega * (std::sqrt(1.0 + zeta * zeta) + zeta));
}

/// Return the time step at the stability limit of the tangential mode with limited damping [s], to
/// a millionth (see damping_time_step_limit). plain: the limit without limited damping.
inline double limited_damping_limit(const Pair& pair, const Coefficients& c, double coordination,
                                    double plain)
{
  const double mass = 2.0 / 7.0 * pair.mass;
  const auto stable = [&](double dt) {
    const double taken = dt * coordination * c.tangential_damping;
    return 4.0 - 2.0 * taken / (mass * (1.0 + taken / pair.mass)) -
               dt * dt * coordination * c.tangential_stiffness / mass >
           0.0;
  };
  double low = plain, high = 2.0 / std::sqrt(coordination * c.tangential_stiffness / mass);
  while (high - low > 1e-6 * high) {
    const double middle = 0.5 * (low + high);
    (stable(middle) ? low : high) = middle;
  }
  return low;
}

/// Return the largest linearly stable time step [s] of contacts at an overlap [m], with
/// `coordination` contacts on every ball.
///
/// Derived here. Normal mode of one contact: stiffness S_n = 2 E* a, mass m*. Tangential mode: a
/// force at the contact also spins the ball (inertia 2/5 m r^2), so it acts on m_t = 2/7 m*:
/// omega_t^2 = 7/2 S_t / m*, zeta_t = sqrt(7/2) zeta_n. The tangential mode limits the step. With Z
/// contacts on every ball the stiffest mode has at most Z times the stiffness and damping of one
/// contact, since the contacts' quadratic forms add up. So omega and zeta grow by at most sqrt(Z):
/// a sufficient condition. Valid for sticking contacts of equal balls at equal overlap, with
/// stiffness constant over a step. Sliding contacts are not damped and Coulomb's limit bounds the
/// growth. A larger step therefore causes errors of spin and dissipation rather than divergence.
///
/// With limited damping, each tangential coefficient c is divided by 1 + dt (D_i / m_i + D_j /
/// m_j), with D the sums of c over the contacts of either ball (`damping_share`); on equal balls 1
/// + dt Z c / m*. The condition is then 4 - 2 dt Z c / (m_t (1 + dt Z c / m*)) - dt^2 Z S_t / m_t =
/// 0.
inline double damping_time_step_limit(const Pair& pair, double overlap, double coordination = 1.0,
                                      bool limited_damping = false)
{
  require_positive("overlap", "m", overlap);
  if (!(coordination >= 1.0 && std::isfinite(coordination)))
    reject("coordination", "must be >= 1 contact per ball", coordination);
  const Coefficients c = coefficients(pair, overlap);
  const auto limit = [&](double stiffness, double damping, double mass) {
    const double omega = std::sqrt(coordination * stiffness / mass);
    return damped_mode_limit(omega, 0.5 * coordination * damping / (mass * omega));
  };
  const double tangential_mass = 2.0 / 7.0 * pair.mass;
  double tangential = limit(c.tangential_stiffness, c.tangential_damping, tangential_mass);
  if (limited_damping) tangential = limited_damping_limit(pair, c, coordination, tangential);
  return std::min(limit(1.5 * c.normal_stiffness, c.normal_damping, pair.mass), tangential);
}

}  // namespace millscale::contact
