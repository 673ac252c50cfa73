#pragma once

#include <cmath>

#include "core/contact/contact_force.h"
#include "core/contact/hertz_mindlin.h"
#include "core/math/vector.h"

/// The force of two balls written out from the text of the law. It shares no formula with
/// `contact::contact_force`: stiffness and damping from `coefficients`, surface velocities and
/// torques from the lever arms to the point of contact.
namespace written_out {

using millscale::cross;
using millscale::dot;
using millscale::Vector;

inline Vector vector(const millscale::Vector3<double>& a)
{
  return millscale::to_array(a);
}
inline Vector sum(const Vector& a, double factor, const Vector& b)
{
  return {a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]};
}
inline Vector across(const Vector& a, const Vector& normal)
{
  return sum(a, -dot(a, normal), normal);
}
inline double size(const Vector& a)
{
  return std::sqrt(dot(a, a));
}

struct Forces {
  Vector force, torque_i, torque_j, displacement;
  double damping = 0.0;
};

inline Forces pair_force(const millscale::contact::BallPair<double>& touch,
                         const millscale::contact::EffectiveMaterial& law,
                         const millscale::contact::ContactTerms& terms, double dt, bool advance)
{
  const double ri = touch.radius_i, rj = touch.radius_j, mi = touch.mass_i, mj = touch.mass_j;
  const millscale::contact::Pair pair{1.0 / (1.0 / ri + 1.0 / rj), 1.0 / (1.0 / mi + 1.0 / mj),
                                      law.youngs_modulus, law.shear_modulus, law.damping};
  const Vector separation = vector(touch.separation), wi = vector(touch.spin_i),
               wj = vector(touch.spin_j);
  const double distance = size(separation), overlap = ri + rj - distance;
  const Vector normal = sum({}, 1.0 / distance, separation);
  const auto k = coefficients(pair, overlap);

  // From each centre to the middle of the overlap.
  const Vector to_i = sum({}, -(ri - 0.5 * overlap), normal);
  const Vector to_j = sum({}, rj - 0.5 * overlap, normal);
  const Vector surfaces =
      sum(sum(vector(touch.velocity), 1.0, cross(wi, to_i)), -1.0, cross(wj, to_j));
  const double approach = -dot(vector(touch.velocity), normal);
  const double pushing = k.normal_stiffness * overlap + k.normal_damping * approach;

  Vector tangential{}, displacement = vector(touch.displacement);
  double sticking = 0.0;
  if (terms.history) {
    const Vector sliding = across(surfaces, normal);
    if (advance) displacement = across(sum(displacement, dt, sliding), normal);
    const double spring = k.tangential_stiffness * size(displacement);
    const double coulomb = law.sliding * std::abs(pushing);
    if (spring <= coulomb) {
      tangential = sum({}, -k.tangential_stiffness, displacement);
      if (terms.tangential_damping) sticking = k.tangential_damping;
      const double divisor = terms.limited_damping ? 1.0 + touch.damping_share : 1.0;
      tangential = sum(tangential, -sticking / divisor, sliding);
    } else {
      tangential = sum({}, -coulomb / size(displacement), displacement);
      if (advance) displacement = sum({}, -1.0 / k.tangential_stiffness, tangential);
    }
  }
  Forces result{
      sum(tangential, pushing, normal), cross(to_i, tangential), {}, displacement, sticking};
  result.torque_j = cross(to_j, sum({}, -1.0, tangential));
  const Vector turning = sum(wi, -1.0, wj);
  if (terms.rolling && size(turning) > 0.0) {
    const double moment = law.rolling * pair.radius * k.normal_stiffness * overlap;
    const Vector rolling = across(sum({}, moment / size(turning), turning), normal);
    result.torque_i = sum(result.torque_i, -1.0, rolling);
    result.torque_j = sum(result.torque_j, 1.0, rolling);
  }
  return result;
}

}  // namespace written_out
