#pragma once

#include <array>
#include <cmath>

#include "core/contact/contact_force.h"
#include "core/math/vector.h"

namespace millscale::contact {

/// Kinds of work that a contact does on its balls.
enum Work { normal_spring, normal_dashpot, tangential_spring, tangential_dashpot, rolling, works };

/// Force and torque on a ball [N], [N m]: the first three, the last three.
using Load = std::array<double, 6>;

/// A ball's load, by kind of work.
using Loads = std::array<Load, works>;

/// A contact and its force, as the energy budget sees them.
class EvaluatedContact {
 public:
  EvaluatedContact(const Contact<double>& contact, const ContactForce<double>& force)
      : contact_(contact), force_(force)
  {
  }

  /// Return the size of the tangential displacement after the step [m].
  double stretch() const { return std::sqrt(dot(force_.displacement, force_.displacement)); }

  /// Return 2/5 F delta, the integral of Hertz's force [J].
  double normal_energy() const { return 0.4 * force_.elastic_force * contact_.overlap; }

  /// Return 1/2 k_t xi^2 with k_t of the present overlap [J]. A spring whose stiffness follows the
  /// overlap also takes or gives -1/2 xi^2 dk_t: no energy of the contact, but an error of the law.
  double tangential_energy() const
  {
    return 0.5 * force_.tangential_stiffness * stretch() * stretch();
  }

  /// Return Coulomb's force times the distance slid in this step [J].
  double slip_work() const { return force_.tangential_stiffness * stretch() * force_.slip; }

  /// Return the energy of the approach, 1/2 m* v_n^2 [J]; 0 if the bodies separate.
  double approach_energy() const
  {
    const double speed = dot(contact_.velocity, contact_.normal);
    return speed < 0.0 ? 0.5 * contact_.mass * speed * speed : 0.0;
  }

  /// Add the forces of the contact on body i, or on body j.
  void add_loads_on_i(Loads& loads) const { add_loads(1.0, contact_.lever_i, loads); }
  void add_loads_on_j(Loads& loads) const { add_loads(-1.0, contact_.lever_j, loads); }

 private:
  void add_loads(double sign, double lever, Loads& loads) const
  {
    const auto add = [](double factor, const Vector3<double>& v, double* sum) {
      sum[0] += factor * v.x;
      sum[1] += factor * v.y;
      sum[2] += factor * v.z;
    };
    const auto add_tangential = [&](const Vector3<double>& tangential, Load& load) {
      add(sign, tangential, load.data());
      // Both bodies turn the same way.
      add(-lever, cross(contact_.normal, tangential), load.data() + 3);
    };
    const double damping_force = force_.normal_force - force_.elastic_force;
    add(sign * force_.elastic_force, contact_.normal, loads[normal_spring].data());
    add(sign * damping_force, contact_.normal, loads[normal_dashpot].data());
    add_tangential(force_.tangential_force - force_.tangential_damping_force,
                   loads[tangential_spring]);
    add_tangential(force_.tangential_damping_force, loads[tangential_dashpot]);
    add(sign, force_.rolling_torque, loads[rolling].data() + 3);
  }

  const Contact<double>& contact_;
  const ContactForce<double>& force_;
};

/// Return the power of a load on a ball of these velocities [W].
inline double power(const Load& load, const Vector& velocity, const Vector& spin)
{
  return load[0] * velocity[0] + load[1] * velocity[1] + load[2] * velocity[2] + load[3] * spin[0] +
         load[4] * spin[1] + load[5] * spin[2];
}

}  // namespace millscale::contact
