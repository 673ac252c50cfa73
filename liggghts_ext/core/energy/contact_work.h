#pragma once

#include <array>
#include <vector>

#include "core/math/vector3.h"

namespace millscale::energy {

/// Loads of a contact of two balls without the elastic normal force, and the energy that they have
/// dissipated since the contact began. The tangential spring is one of the loads: what it stores
/// comes back, or is dissipated at the latest when the contact ends. Three rows of four numbers for
/// packs.
struct alignas(32) ContactWork {
  double force[3];     ///< on i; on j the opposite [N]
  double available;    ///< energy of the approach, 1/2 m* v_n^2 [J]; negative: not yet evaluated
  double torque_i[3];  ///< [N m]
  double stored;       ///< by the tangential spring [J]
  double torque_j[3];  ///< [N m]
  double dissipated;   ///< work against the loads [J]; contains what is stored

  static constexpr int numbers = 12;
  static constexpr double not_evaluated = -1.0;
};

/// Return the same contact with i and j exchanged.
inline ContactWork seen_from_j(const ContactWork& of_i)
{
  ContactWork seen = of_i;
  for (int d = 0; d < 3; ++d) {
    seen.force[d] = -of_i.force[d];
    seen.torque_i[d] = of_i.torque_j[d];
    seen.torque_j[d] = of_i.torque_i[d];
  }
  return seen;
}

/// A contact of two balls that ended at this step.
struct EndedContact {
  int i, j;
  double dissipated, available;  ///< [J]
};

/// Where the kernels record the work of contacts. Nothing is owned here.
struct WorkRecord {
  ContactWork* of_entry;  ///< of each entry of the pair list; anything of pairs not in contact
  EndedContact* ended;    ///< room for as many as entries
  int count;              ///< of contacts that ended
  double half_step;       ///< dt / 2 [s]; 0 at set-up, where only the loads are stored
  double total;           ///< work against the loads of all contacts at this step [J]
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
