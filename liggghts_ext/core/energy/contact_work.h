#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "core/contact/contact_force.h"
#include "core/math/vector3.h"

namespace millscale::energy {

/// What a contact of two balls keeps until the next step: its loads, and the energy that they have
/// dissipated since the contact began. The loads are the force without the elastic normal force and
/// the rolling torque; the torques of the force follow from the positions. The tangential spring is
/// one of the loads: what it stores comes back, or is dissipated at the latest when the contact
/// ends.
struct ContactWork {
  float force[3];     ///< on i; on j the opposite [N]
  float torque[3];    ///< of rolling friction on i; on j the opposite [N m]
  double dissipated;  ///< work against the loads [J]; contains what is stored
};
static_assert(sizeof(ContactWork) == 32);

/// Return the same contact with i and j exchanged.
inline ContactWork seen_from_j(const ContactWork& of_i)
{
  ContactWork seen = of_i;
  for (int d = 0; d < 3; ++d) {
    seen.force[d] = -of_i.force[d];
    seen.torque[d] = -of_i.torque[d];
  }
  return seen;
}

/// The work of a contact that leaves its list.
struct CarriedWork {
  ContactWork work;
  double available;  ///< energy of the approach, 1/2 m* v_n^2 [J]

  static constexpr int numbers = 5;
};
static_assert(sizeof(CarriedWork) == CarriedWork::numbers * sizeof(double));

[[gnu::always_inline]] inline Vector3<double> vector_of(const float* numbers)
{
  return {numbers[0], numbers[1], numbers[2]};
}

/// Force and torque on a ball [N], [N m].
struct LoadOnBall {
  Vector3<double> force, torque;
};

/// Return the loads of a contact on i. separation: from the centre of j to that of i [m].
inline LoadOnBall load_on_i(const ContactWork& work, const Vector3<double>& separation,
                            double radius_i, double radius_j)
{
  const double distance = std::sqrt(dot(separation, separation));
  const Vector3<double> force = vector_of(work.force);
  const Vector3<double> moment = (1.0 / distance) * cross(separation, force);
  const double lever = 0.5 * (radius_i - radius_j + distance);
  return {force, vector_of(work.torque) - lever * moment};
}

/// Powers of the loads of contacts [W].
template <class Number>
struct Powers {
  Number of_force, of_torque;
};

/// Return 1 / sqrt(r2) from a guess whose square differs by a small part.
template <class Number>
[[gnu::always_inline]] inline Number inverse_root(const Number& r2, const Number& guess)
{
  const Number off = Number(1.0) - r2 * Number(guess * guess);
  const Number series =
      Number(0.5) +
      off * Number(Number(0.375) + off * Number(Number(0.3125) + off * Number(0.2734375)));
  return guess + guess * Number(off * series);
}

/// Return the powers of the loads of the step before, at the velocities since. Those velocities
/// have brought the balls from the places of that step to the present ones, so that the normal and
/// the levers of that step follow from both. inverse_distance: of the present places [1/m].
template <class Number>
[[gnu::always_inline]] inline Powers<Number> powers_of_kept(const Vector3<Number>& force,
                                                            const Vector3<Number>& torque,
                                                            const contact::BallPair<Number>& pair,
                                                            const Number& inverse_distance,
                                                            double dt)
{
  const Number half(0.5);
  const Vector3<Number> separation = subtract_scaled(pair.separation, Number(dt), pair.velocity);
  const Number inverse = inverse_root(Number(dot(separation, separation)), inverse_distance);
  // The levers over the distance are half of 1, more or less this.
  const Number share = Number(half * (pair.radius_i - pair.radius_j)) * inverse;
  const Vector3<Number> turning = pair.spin_i - pair.spin_j;
  const Vector3<Number> spin = add_scaled(half * (pair.spin_i + pair.spin_j), share, turning);
  const Vector3<Number> velocity = pair.velocity - cross(spin, separation);
  return {dot(force, velocity), dot(torque, turning)};
}

/// Return the powers of loads at this step.
template <class Number>
[[gnu::always_inline]] inline Powers<Number> powers_of_loads(const Vector3<Number>& force,
                                                             const Vector3<Number>& torque,
                                                             const contact::Contact<Number>& c)
{
  const Vector3<Number> spin = add_scaled(c.lever_i * c.spin_i, c.lever_j, c.spin_j);
  const Vector3<Number> velocity = c.velocity - cross(spin, c.normal);
  return {dot(force, velocity), dot(torque, c.spin_i - c.spin_j)};
}

/// What the contacts of a list keep, in columns in the order of the list, without pairs that are
/// not in contact. Nothing is owned here.
struct WorkColumns {
  float *force[3], *torque[3];
  double* dissipated;

  // Always inlined: the kernels may not share functions between object files.
  [[gnu::always_inline]] ContactWork get(int k) const
  {
    ContactWork work;
    for (int d = 0; d < 3; ++d) work.force[d] = force[d][k];
    for (int d = 0; d < 3; ++d) work.torque[d] = torque[d][k];
    work.dissipated = dissipated[k];
    return work;
  }
  [[gnu::always_inline]] void set(int k, const ContactWork& work) const
  {
    for (int d = 0; d < 3; ++d) force[d][k] = work.force[d];
    for (int d = 0; d < 3; ++d) torque[d][k] = work.torque[d];
    dissipated[k] = work.dissipated;
  }
};

/// Owns the columns. Beyond the last contact, as many as a pack has may be read and written.
class WorkStore {
 public:
  /// Make room for `count` contacts, and keep what is there.
  void reserve(std::size_t count)
  {
    constexpr std::size_t spare = 64;  // more than the contacts of any pack
    if (dissipated_.size() >= count + spare) return;
    const std::size_t room = count + count / 4 + spare;
    for (auto& column : loads_) column.resize(room);
    dissipated_.resize(room);
  }
  WorkColumns columns()
  {
    const auto of = [this](int k) { return loads_[k].data(); };
    return {{of(0), of(1), of(2)}, {of(3), of(4), of(5)}, dissipated_.data()};
  }
  ContactWork get(int k) const
  {
    const auto of = [&](int column) { return loads_[column][k]; };
    return {{of(0), of(1), of(2)}, {of(3), of(4), of(5)}, dissipated_[k]};
  }
  std::size_t bytes() const
  {
    return dissipated_.capacity() * (sizeof(double) + 6 * sizeof(float));
  }

 private:
  std::array<std::vector<float>, 6> loads_;
  std::vector<double> dissipated_;
};

/// A contact of two balls that ended at this step.
struct EndedContact {
  int i, j;
  double dissipated, available;  ///< [J]
};

/// Where the kernels record the work of contacts. Nothing is owned here.
struct WorkRecord {
  static constexpr int lanes = 8;  ///< of sums; the order of additions is that of any pack

  WorkColumns before, now;  ///< of the contacts of the step before, and of this one
  double* available;        ///< of each entry of the list: energy of the approach, 1/2 m* v_n^2 [J]
  EndedContact* ended;      ///< room for as many as entries
  double half_step;         ///< dt / 2 [s]; 0 at set-up, where only the loads are stored
  int count = 0;            ///< of contacts that ended
  int begun = 0;            ///< contacts that began
  double work[lanes] = {};  ///< against the loads at this step [J]
  double last_work = 0.0;   ///< of these, of contacts that ended [J]

  // Always inlined: the kernels may not share functions between object files.

  /// Begin the contact of an entry.
  [[gnu::always_inline]] void begin(int entry, const contact::BallPair<double>& pair)
  {
    ++begun;
    const double along = dot(pair.velocity, pair.separation);
    const double mass = pair.mass_i * pair.mass_j / (pair.mass_i + pair.mass_j);
    available[entry] = half_step > 0.0 && along < 0.0 ? 0.5 * mass * along * along / pair.r2 : 0.0;
  }

  /// End the contact of an entry, number k of the step before, with the second half step of its
  /// last loads. share: what this rank counts of the contact.
  [[gnu::always_inline]] void end(int entry, int k, int i, int j, double share,
                                  const contact::BallPair<double>& pair)
  {
    const ContactWork work = before.get(k);
    const Powers<double> power = powers_of_kept(vector_of(work.force), vector_of(work.torque), pair,
                                                1.0 / __builtin_sqrt(pair.r2), 2.0 * half_step);
    const double last = half_step * (power.of_force + power.of_torque);
    last_work -= share * last;
    ended[count++] = {i, j, work.dissipated - last, available[entry]};
  }

  /// Return the work against the loads of all contacts at this step [J].
  double total() const
  {
    double sum = last_work;
    for (const double part : work) sum += part;
    return sum;
  }
};

/// The same of a contact of a ball with a wall, whose motion is known.
struct WallContactWork {
  double force[3];    ///< on the ball [N]
  double torque[3];   ///< [N m]
  double wall_power;  ///< of the wall on the ball [W]
  double available, stored, dissipated;
  double open;  ///< 1: in contact

  static constexpr int numbers = 11;
};

}  // namespace millscale::energy
