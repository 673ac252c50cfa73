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

/// Body i, a ball, in contact with body j. A wall is a body j of infinite radius and mass: `radius`
/// and `mass` are those of the ball, `lever_j` and `spin_j` are zero.
template <class Number>
struct Contact {
  Vector3<Number> normal;          ///< unit vector from j to i
  Number overlap;                  ///< >= 0 [m]
  Number radius, mass;             ///< effective [m], [kg]
  Number lever_i, lever_j;         ///< from the centres to half the overlap [m]
  Vector3<Number> velocity;        ///< of i relative to j at the contact, without the spins [m/s]
  Vector3<Number> spin_i, spin_j;  ///< [rad/s]
  Vector3<Number> displacement;    ///< tangential displacement before the step [m]
  Number damping_share{0.0};       ///< sum of `contact::damping_share` of both bodies [-]
};

template <class Number>
struct ContactForce {
  Vector3<Number> force;               ///< on i; on j the opposite [N]
  Vector3<Number> torque_i, torque_j;  ///< about the centres [N m]
  Vector3<Number> displacement;        ///< tangential displacement after the step [m]
  Number damping;  ///< tangential coefficient before division, 0 if the contact slips [kg/s]

  // Parts, for the energy budget (contact_energy.h).
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
  const Vector3<Number> none{zero, zero, zero};
  const Number a = contact_radius(c.radius, c.overlap), scale = damping_scale(a, c.mass);
  const Number normal_speed = dot(c.velocity, c.normal);
  const Number elastic_force = law.normal_stiffness * a * c.overlap;
  const Number normal_force = elastic_force - law.normal_damping * scale * normal_speed;

  // Velocity of the surfaces along each other.
  const Vector3<Number> spin = c.lever_i * c.spin_i + c.lever_j * c.spin_j;
  const Vector3<Number> sliding = c.velocity - normal_speed * c.normal - cross(spin, c.normal);

  ContactForce<Number> result;
  result.elastic_force = elastic_force;
  result.normal_force = normal_force;
  result.damping = result.tangential_stiffness = result.slip = zero;
  result.tangential_damping_force = result.rolling_torque = none;
  Vector3<Number> displacement = c.displacement, tangential = none;
  if (terms.history) {
    if (advance) {
      displacement = displacement + Number(dt) * sliding;
      displacement = displacement - dot(displacement, c.normal) * c.normal;
    }
    const Number stiffness = law.tangential_stiffness * a;
    const Number spring = stiffness * sqrt(dot(displacement, displacement));
    const Number limit = law.sliding * abs(normal_force);
    const auto slips = spring > limit;
    const Number share = choose(slips, limit / choose(slips, spring, one), one);
    Number dashpot =
        terms.tangential_damping ? choose(slips, zero, law.tangential_damping * scale) : zero;
    result.damping = dashpot;
    if (terms.limited_damping) dashpot = dashpot / (one + c.damping_share);
    result.tangential_stiffness = stiffness;
    result.slip = choose(slips, (spring - limit) / choose(slips, stiffness, one), zero);
    result.tangential_damping_force = (zero - dashpot) * sliding;
    tangential = (zero - stiffness * share) * displacement - dashpot * sliding;
    if (advance) displacement = share * displacement;
  }
  result.displacement = displacement;
  result.tangential_force = tangential;
  result.force = normal_force * c.normal + tangential;
  const Vector3<Number> moment = cross(c.normal, tangential);
  result.torque_i = (zero - c.lever_i) * moment;
  result.torque_j = (zero - c.lever_j) * moment;
  if (terms.rolling) {
    const Vector3<Number> turning = c.spin_i - c.spin_j;
    const Number speed = sqrt(dot(turning, turning));
    const auto turns = speed > zero;
    const Number size =
        choose(turns, law.rolling * elastic_force * c.radius / choose(turns, speed, one), zero);
    Vector3<Number> torque = size * turning;
    torque = torque - dot(torque, c.normal) * c.normal;  // no twisting
    result.rolling_torque = none - torque;
    result.torque_i = result.torque_i - torque;
    result.torque_j = result.torque_j + torque;
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
  const Number distance = sqrt(pair.r2), inverse = one / distance;
  const Number radii = pair.radius_i + pair.radius_j;
  const Number gap = from_excess ? pair.excess / (radii + distance) : radii - distance;
  const Number masses = pair.mass_i + pair.mass_j;
  const Number inverses = one / (radii * masses);
  Contact<Number> c;
  c.normal = inverse * pair.separation;
  c.overlap = choose(gap > zero, gap, zero);
  c.radius = pair.radius_i * pair.radius_j * (inverses * masses);
  c.mass = pair.mass_i * pair.mass_j * (inverses * radii);
  c.lever_i = pair.radius_i - half * c.overlap;
  c.lever_j = pair.radius_j - half * c.overlap;
  c.velocity = pair.velocity;
  c.spin_i = pair.spin_i;
  c.spin_j = pair.spin_j;
  c.displacement = pair.displacement;
  c.damping_share = pair.damping_share;
  return c;
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
  c.radius = touch.radius;
  c.mass = touch.mass;
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
