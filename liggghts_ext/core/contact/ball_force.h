#pragma once

#include <cmath>

namespace millscale::contact {

/// A vector whose components are numbers or packs of numbers.
template <class Number>
struct Triple {
  Number x, y, z;
};

template <class Number>
inline Triple<Number> operator+(const Triple<Number>& a, const Triple<Number>& b)
{
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class Number>
inline Triple<Number> operator-(const Triple<Number>& a, const Triple<Number>& b)
{
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class Number>
inline Triple<Number> operator*(const Number& s, const Triple<Number>& a)
{
  return {s * a.x, s * a.y, s * a.z};
}
template <class Number>
inline Number dot(const Triple<Number>& a, const Triple<Number>& b)
{
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class Number>
inline Triple<Number> cross(const Triple<Number>& a, const Triple<Number>& b)
{
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// `yes` where the condition holds, else `no`. Packs of numbers bring their own overload.
inline double choose(bool condition, double yes, double no)
{
  return condition ? yes : no;
}

/// Constants of two materials in contact, as the force needs them (see `ball_law`).
template <class Number>
struct BallLaw {
  Number normal_stiffness;      ///< 4/3 E* [Pa]: k_n = normal_stiffness a
  Number tangential_stiffness;  ///< 8 G* [Pa]: k_t = tangential_stiffness a
  Number normal_damping;        ///< 2 sqrt(5/6) beta sqrt(2 E*) [Pa^1/2]: times sqrt(a m*)
  Number tangential_damping;    ///< 2 sqrt(5/6) beta sqrt(8 G*) [Pa^1/2]
  Number sliding, rolling;      ///< coefficients of friction [-]
};

/// From effective moduli [Pa] and the damping factor of `damping_factor` [-].
inline BallLaw<double> ball_law(double youngs_modulus, double shear_modulus, double damping,
                                double sliding, double rolling)
{
  const double factor = 2.0 * std::sqrt(5.0 / 6.0) * damping;
  return {4.0 / 3.0 * youngs_modulus,
          8.0 * shear_modulus,
          factor * std::sqrt(2.0 * youngs_modulus),
          factor * std::sqrt(8.0 * shear_modulus),
          sliding,
          rolling};
}

/// Two balls that touch, i and j.
template <class Number>
struct BallTouch {
  Triple<Number> apart;           ///< from the centre of j to that of i [m]
  Number square;                  ///< its square [m^2]
  Number radius_i, radius_j;      ///< [m]
  Number mass_i, mass_j;          ///< [kg]
  Triple<Number> velocity;        ///< of i relative to j [m/s]
  Triple<Number> spin_i, spin_j;  ///< [rad/s]
  Triple<Number> displacement;    ///< the contact's memory [m]
  Number held{0.0};               ///< sum of both balls' `damping_held` [-]; read if bounded
  Number excess{0.0};  ///< square of the radii's sum over `square` [m^2]; read if `from_excess`
};

/// What the force on i is made of, for the account of its energy (contact_energy.h); not computed
/// where nobody reads it.
template <class Number>
struct BallParts {
  Triple<Number> normal;    ///< unit vector from j to i
  Number overlap;           ///< [m]
  Number lever_i, lever_j;  ///< from the centres to half the overlap [m]
  Number spring, push;      ///< elastic and whole normal force [N]
  Number stiffness{0.0};    ///< k_t at this overlap [N/m]
  Number slipped{0.0};      ///< by how much the memory was cut by Coulomb's limit [m]
  Triple<Number> damped{Number(0.0), Number(0.0), Number(0.0)};  ///< by the tangential dashpot [N]
  Triple<Number> rolling{Number(0.0), Number(0.0),
                         Number(0.0)};  ///< torque; on j the opposite [N m]
};

template <class Number>
struct BallForces {
  Triple<Number> force;               ///< on i; on j the opposite [N]
  Triple<Number> torque_i, torque_j;  ///< [N m]
  Triple<Number> displacement;        ///< the contact's memory after the step [m]
  Number damping{0.0};                ///< tangential coefficient, 0 if it slips [kg/s]; if bounded
  BallParts<Number> parts;
};

/// Which terms a deck asks for.
struct BallTerms {
  bool history = true;  ///< tangential spring with memory and Coulomb's limit
  bool tangential_damping = true;
  bool bounded = false;  ///< the tangential coefficient is divided by 1 + `BallTouch::held`
  bool rolling = true;   ///< constant directional torque (cdt)
};

/// Force and torques of two balls on each other: Hertz-Mindlin with damping, tangential memory and
/// constant rolling friction, the arithmetic of LIGGGHTS's `hertz`, `history` and `cdt`, in a form
/// without branches so that it also works on packs of numbers. Powder Technology 335 (2018)
/// 91-102, Eqs. 16-22. dt [s] advances the memory; with `advance` false it is used as it is.
/// An overlap is a small difference of lengths. In single precision it is better had from that of
/// their squares, `from_excess`, which the caller works out in double precision.
template <bool from_excess = false, class Number>
inline BallForces<Number> ball_force(const BallTouch<Number>& touch, const BallLaw<Number>& law,
                                     const BallTerms& terms, double dt, bool advance)
{
  using std::abs;
  using std::sqrt;
  const Number zero(0.0), one(1.0), half(0.5);
  const Number distance = sqrt(touch.square), inverse = one / distance;
  const Triple<Number> normal = inverse * touch.apart;
  const Number radii = touch.radius_i + touch.radius_j;
  const Number gap = from_excess ? touch.excess / (radii + distance) : radii - distance;
  const Number overlap = choose(gap > zero, gap, zero);
  const Number masses = touch.mass_i + touch.mass_j;
  const Number inverses = one / (radii * masses);
  const Number radius = touch.radius_i * touch.radius_j * (inverses * masses);
  const Number mass = touch.mass_i * touch.mass_j * (inverses * radii);

  const Number contact_radius = sqrt(radius * overlap);
  const Number damping = sqrt(contact_radius * mass);
  const Number normal_speed = dot(touch.velocity, normal);
  const Number elastic = law.normal_stiffness * contact_radius * overlap;
  const Number normal_force = elastic - law.normal_damping * damping * normal_speed;

  // Velocity of the surfaces along each other; the levers end at half the overlap.
  const Number lever_i = touch.radius_i - half * overlap, lever_j = touch.radius_j - half * overlap;
  const Triple<Number> spin = lever_i * touch.spin_i + lever_j * touch.spin_j;
  const Triple<Number> sliding = touch.velocity - normal_speed * normal - cross(spin, normal);

  BallForces<Number> result;
  BallParts<Number>& parts = result.parts;
  parts.normal = normal;
  parts.overlap = overlap;
  parts.lever_i = lever_i;
  parts.lever_j = lever_j;
  parts.spring = elastic;
  parts.push = normal_force;
  result.force = normal_force * normal;
  Triple<Number> memory = touch.displacement, tangential{zero, zero, zero};
  if (terms.history) {
    if (advance) {
      memory = memory + Number(dt) * sliding;
      memory = memory - dot(memory, normal) * normal;
    }
    const Number stiffness = law.tangential_stiffness * contact_radius;
    const Number spring = stiffness * sqrt(dot(memory, memory));
    const Number limit = law.sliding * abs(normal_force);
    const auto slips = spring > limit;
    const Number share = choose(slips, limit / choose(slips, spring, one), one);
    Number dashpot =
        terms.tangential_damping ? choose(slips, zero, law.tangential_damping * damping) : zero;
    if (terms.bounded) {
      result.damping = dashpot;
      dashpot = dashpot / (one + touch.held);
    }
    parts.stiffness = stiffness;
    parts.slipped = choose(slips, (spring - limit) / choose(slips, stiffness, one), zero);
    parts.damped = (zero - dashpot) * sliding;
    tangential = (zero - stiffness * share) * memory - dashpot * sliding;
    if (advance) memory = share * memory;
  }
  result.displacement = memory;
  result.force = result.force + tangential;
  const Triple<Number> moment = cross(normal, tangential);
  result.torque_i = (zero - lever_i) * moment;
  result.torque_j = (zero - lever_j) * moment;
  if (terms.rolling) {
    const Triple<Number> turning = touch.spin_i - touch.spin_j;
    const Number speed = sqrt(dot(turning, turning));
    const auto turns = speed > zero;
    const Number size =
        choose(turns, law.rolling * elastic * radius / choose(turns, speed, one), zero);
    Triple<Number> torque = size * turning;
    torque = torque - dot(torque, normal) * normal;
    parts.rolling = (zero - one) * torque;
    result.torque_i = result.torque_i - torque;
    result.torque_j = result.torque_j + torque;
  }
  return result;
}

}  // namespace millscale::contact
