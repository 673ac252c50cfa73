#pragma once

#include <cmath>

#include "core/math/vector3.h"

/// The contact law of balls and walls: Hertz-Mindlin with damping, tangential history and constant
/// rolling friction, the arithmetic of LIGGGHTS's `hertz`, `history` and `cdt`. Powder Technology
/// 335 (2018) 91-102, Eqs. 16-22. `Number` is a double, or a pack of doubles or floats that brings
/// +, -, *, /, >, sqrt, abs and choose: the law has no branch on a number.
namespace millscale::contact {

/// `yes` where the condition holds, else `no`.
inline double choose(bool condition, double yes, double no)
{
  return condition ? yes : no;
}

template <class Number>
[[gnu::always_inline]] inline Number larger(const Number& a, const Number& b)
{
  return choose(a > b, a, b);
}

template <class Number>
[[gnu::always_inline]] inline Number smaller(const Number& a, const Number& b)
{
  return choose(b > a, a, b);
}

/// Constants of two materials in contact, as the force needs them. a: contact radius [m].
template <class Number>
struct ContactLaw {
  Number normal_stiffness;      ///< 4/3 E* [Pa]: k_n = normal_stiffness a
  Number tangential_stiffness;  ///< 8 G* [Pa]: k_t = tangential_stiffness a
  Number normal_damping;        ///< 2 sqrt(5/6) beta sqrt(2 E*) [Pa^1/2]: times sqrt(a m*)
  Number tangential_damping;    ///< 2 sqrt(5/6) beta sqrt(8 G*) [Pa^1/2]: times sqrt(a m*)
  Number sliding, rolling;      ///< coefficients of friction [-]
};

/// Two materials in contact.
struct EffectiveMaterial {
  double youngs_modulus, shear_modulus;  ///< effective [Pa]
  double damping;                        ///< of `damping_factor` [-]
  double sliding, rolling;               ///< coefficients of friction [-]
};

inline ContactLaw<double> contact_law(const EffectiveMaterial& m)
{
  const double factor = 2.0 * std::sqrt(5.0 / 6.0) * m.damping;
  return {4.0 / 3.0 * m.youngs_modulus,
          8.0 * m.shear_modulus,
          factor * std::sqrt(2.0 * m.youngs_modulus),
          factor * std::sqrt(8.0 * m.shear_modulus),
          m.sliding,
          m.rolling};
}

/// Terms of the law that a deck asks for.
struct ContactTerms {
  bool history = true;  ///< tangential spring with Coulomb's limit
  bool tangential_damping = true;
  bool limited_damping = false;  ///< divide the tangential damping by 1 + `Contact::damping_share`
  bool rolling = true;           ///< constant directional torque (cdt)
};

/// Body i, a ball, in contact with body j. A wall is a body j of infinite radius and mass, whose
/// `lever_j` and `spin_j` are zero.
template <class Number>
struct Contact {
  Vector3<Number> normal;          ///< unit vector from j to i
  Number overlap;                  ///< >= 0 [m]
  Number radius;                   ///< a, of the contact area [m]
  Number damping_scale;            ///< sqrt(a m*) [(m kg)^1/2]
  Number lever_i, lever_j;         ///< from the centres to half the overlap [m]
  Vector3<Number> velocity;        ///< of i relative to j at the contact, without the spins [m/s]
  Vector3<Number> spin_i, spin_j;  ///< [rad/s]
  Vector3<Number> displacement;    ///< tangential displacement before the step [m]
  Number damping_share{0.0};       ///< sum of `contact::damping_share` of both bodies [-]
  Number mass{0.0};                ///< effective mass m*, for the energy budget [kg]
  Number inverse_distance{0.0};    ///< of the centres of balls, for the work of contacts [1/m]
};

template <class Number>
struct ContactForce {
  Vector3<Number> force;               ///< on i; on j the opposite [N]
  Vector3<Number> torque_i, torque_j;  ///< about the centres [N m]
  Vector3<Number> displacement;        ///< tangential displacement after the step [m]
  Number damping;  ///< tangential coefficient before division, 0 if the contact slips [kg/s]

  // Parts, for the energy budget (contact_energy.h). Packs do not evaluate them.
  Number elastic_force, normal_force;  ///< elastic part and whole of the normal force [N]
  Number tangential_stiffness;         ///< k_t at this overlap [N/m]
  Number slip;                         ///< reduction of the displacement by Coulomb's limit [m]
  Vector3<Number> tangential_force;    ///< spring and dashpot [N]
  Vector3<Number> tangential_damping_force;  ///< dashpot [N]
  Vector3<Number> rolling_torque;            ///< on i; on j the opposite [N m]
};

/// Return a, the radius of the contact area [m].
template <class Number>
inline Number contact_radius(const Number& radius, const Number& overlap)
{
  using std::sqrt;
  return sqrt(radius * overlap);
}

/// Return sqrt(a m*), the factor of both damping coefficients of `ContactLaw`.
template <class Number>
inline Number damping_scale(const Number& contact_radius, const Number& mass)
{
  using std::sqrt;
  return sqrt(contact_radius * mass);
}

/// Return the forces of two bodies in contact on each other. dt [s] advances the tangential
/// displacement; with `advance` false, at set-up, it is used as it is. Damping may make the normal
/// force attractive at the end of an impact, as in the engine.
template <class Number>
[[gnu::always_inline]] inline ContactForce<Number> contact_force(const Contact<Number>& c,
                                                                 const ContactLaw<Number>& law,
                                                                 const ContactTerms& terms,
                                                                 double dt, bool advance)
{
  using std::abs;
  using std::sqrt;
  const Number zero(0.0), one(1.0);
  const Number tiny(1e-30);  // [N^2], [rad^2/s^2]: below it, a force or torque goes to 0 linearly
  const Vector3<Number> none{zero, zero, zero};
  const Number normal_speed = dot(c.velocity, c.normal);
  const Number elastic_force = law.normal_stiffness * c.radius * c.overlap;
  const Number normal_force = elastic_force - law.normal_damping * c.damping_scale * normal_speed;

  ContactForce<Number> result;
  result.elastic_force = elastic_force;
  result.normal_force = normal_force;
  result.displacement = c.displacement;
  result.damping = result.tangential_stiffness = result.slip = zero;
  result.tangential_force = result.tangential_damping_force = result.rolling_torque = none;
  if (terms.rolling) {
    // The elastic force times the effective radius R* = a^2 / overlap.
    const Number moment = law.rolling * law.normal_stiffness * (c.radius * c.radius * c.radius);
    const Vector3<Number> turning = c.spin_i - c.spin_j;
    const Number size = moment / sqrt(larger(dot(turning, turning), tiny));
    const Vector3<Number> torque = size * turning;
    result.rolling_torque =
        subtract_scaled(dot(torque, c.normal) * c.normal, size, turning);  // no twisting
  }
  if (terms.history) {
    // Velocity of the surfaces relative to each other. Its normal part does not slide; it drops out
    // of the displacement, and of the moment.
    const Vector3<Number> spin = add_scaled(c.lever_i * c.spin_i, c.lever_j, c.spin_j);
    const Vector3<Number> velocity = c.velocity - cross(spin, c.normal);
    Vector3<Number> displacement = c.displacement;
    if (advance) {
      displacement = add_scaled(displacement, Number(dt), velocity);
      displacement = subtract_scaled(displacement, dot(displacement, c.normal), c.normal);
    }
    const Number stiffness = law.tangential_stiffness * c.radius;
    const Number stretch2 = dot(displacement, displacement);
    const Number spring2 = stiffness * stiffness * stretch2;
    const Number limit = law.sliding * abs(normal_force);
    const auto slips = spring2 > limit * limit;
    const Number share = smaller(one, limit / sqrt(larger(spring2, tiny)));
    Number dashpot = terms.tangential_damping
                         ? choose(slips, zero, law.tangential_damping * c.damping_scale)
                         : zero;
    result.damping = dashpot;
    if (terms.limited_damping) dashpot = dashpot / (one + c.damping_share);

    const Number spring = zero - stiffness * share;
    const Vector3<Number> tangential = subtract_scaled(spring * displacement, dashpot, velocity);
    const Number along_normal = normal_force + dashpot * normal_speed;
    result.force = add_scaled(tangential, along_normal, c.normal);
    const Vector3<Number> moment = cross(c.normal, tangential);
    result.torque_i = subtract_scaled(result.rolling_torque, c.lever_i, moment);
    result.torque_j = subtract_scaled(none - result.rolling_torque, c.lever_j, moment);
    if (advance) result.displacement = share * displacement;

    result.tangential_stiffness = stiffness;
    result.slip = choose(slips, (one - share) * sqrt(stretch2), zero);
    const Vector3<Number> sliding = subtract_scaled(velocity, normal_speed, c.normal);
    result.tangential_damping_force = none - dashpot * sliding;
    result.tangential_force = subtract_scaled(spring * displacement, dashpot, sliding);
  } else {
    result.force = normal_force * c.normal;
    result.torque_i = result.rolling_torque;
    result.torque_j = none - result.rolling_torque;
  }
  return result;
}

/// Two balls that overlap, i and j.
template <class Number>
struct BallPair {
  Vector3<Number> separation;      ///< from the centre of j to that of i [m]
  Number r2;                       ///< square of the separation [m^2]
  Number radius_i, radius_j;       ///< [m]
  Number mass_i, mass_j;           ///< [kg]
  Vector3<Number> velocity;        ///< of i relative to j [m/s]
  Vector3<Number> spin_i, spin_j;  ///< [rad/s]
  Vector3<Number> displacement;    ///< tangential displacement before the step [m]
  Number damping_share{0.0};       ///< sum of `contact::damping_share` of both balls [-]
  Number excess{0.0};  ///< square of the radii's sum less r2 [m^2]; read if `from_excess`
};

/// Return the contact of two balls. An overlap is a small difference of lengths: in single
/// precision, take it `from_excess`, a difference of squares that the caller evaluates in double
/// precision.
template <bool from_excess = false, class Number>
[[gnu::always_inline]] inline Contact<Number> contact_of(const BallPair<Number>& pair)
{
  using std::sqrt;
  const Number zero(0.0), one(1.0), half(0.5);
  const Number distance = sqrt(pair.r2);
  const Number radii = pair.radius_i + pair.radius_j, masses = pair.mass_i + pair.mass_j;
  const Number gap = from_excess ? pair.excess / (radii + distance) : radii - distance;
  const Number sums = radii * masses, inverses = one / (sums * distance);  // one division for three
  const Number radius = pair.radius_i * pair.radius_j * (inverses * (masses * distance));
  Contact<Number> c;
  const Number inverse = inverses * sums;
  c.normal = inverse * pair.separation;
  c.inverse_distance = inverse;
  c.overlap = larger(gap, zero);
  c.mass = pair.mass_i * pair.mass_j * (inverses * (radii * distance));
  c.radius = contact_radius(radius, c.overlap);
  c.damping_scale = damping_scale(c.radius, c.mass);
  c.lever_i = pair.radius_i - half * c.overlap;
  c.lever_j = pair.radius_j - half * c.overlap;
  c.velocity = pair.velocity;
  c.spin_i = pair.spin_i;
  c.spin_j = pair.spin_j;
  c.displacement = pair.displacement;
  c.damping_share = pair.damping_share;
  return c;
}

/// Return what the tangential spring of two balls stores, 1/2 k_t xi^2 with k_t of the present
/// overlap [J]. separation: of the centres, after the step as the displacement.
inline double tangential_energy(const ContactLaw<double>& law, double radius_i, double radius_j,
                                const Vector3<double>& separation,
                                const Vector3<double>& displacement)
{
  const double radii = radius_i + radius_j;
  const double overlap = larger(radii - std::sqrt(dot(separation, separation)), 0.0);
  const double radius = contact_radius(radius_i * radius_j / radii, overlap);
  return 0.5 * law.tangential_stiffness * radius * dot(displacement, displacement);
}

/// A ball that overlaps with a wall.
template <class Number>
struct BallOnWall {
  Vector3<Number> normal;        ///< unit vector from the wall to the ball's centre
  Number overlap;                ///< >= 0 [m]
  Number radius, mass;           ///< of the ball [m], [kg]
  Vector3<Number> velocity;      ///< of the ball's centre relative to the wall at the contact [m/s]
  Vector3<Number> spin;          ///< of the ball [rad/s]
  Vector3<Number> displacement;  ///< tangential displacement before the step [m]
  Number damping_share;          ///< of `contact::damping_share` [-]
};

/// Return the contact of a ball with a wall.
template <class Number>
[[gnu::always_inline]] inline Contact<Number> contact_of(const BallOnWall<Number>& touch)
{
  const Number zero(0.0), half(0.5);
  Contact<Number> c;
  c.normal = touch.normal;
  c.overlap = touch.overlap;
  c.mass = touch.mass;
  c.radius = contact_radius(touch.radius, touch.overlap);
  c.damping_scale = damping_scale(c.radius, c.mass);
  c.lever_i = touch.radius - half * touch.overlap;
  c.lever_j = zero;
  c.velocity = touch.velocity;
  c.spin_i = touch.spin;
  c.spin_j = {zero, zero, zero};
  c.displacement = touch.displacement;
  c.damping_share = touch.damping_share;
  return c;
}

}  // namespace millscale::contact
