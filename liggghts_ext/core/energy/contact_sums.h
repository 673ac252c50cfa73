#pragma once

#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "core/contact/contact_energy.h"
#include "core/energy/impact_spectrum.h"

namespace millscale::energy {

/// Sums over the contacts of one class, ball-ball or ball-wall, of a rank. Forces by ball and kind
/// of work, and the stored energy, are of one evaluation of the forces. Impacts and slip work add
/// up over evaluations.
///
/// The class keeps forces of balls, not powers of contacts. The velocities that the work needs are
/// known only after all forces, and a rank then knows its own balls' velocities, not those of
/// ghosts.
class ContactSums {
 public:
  /// Begin an evaluation. balls: the rank's local ones.
  void clear(std::size_t balls)
  {
    loads.assign(balls, contact::Loads{});
    normal_energy = tangential_energy = 0.0;
    wall_power.fill(0.0);
  }

  /// Add the energy that a contact stores. share: 1/2 if another rank evaluates it as well. moves:
  /// false at set-up, where displacements do not advance and nothing slides.
  void store(const contact::EvaluatedContact& contact, double share, bool moves)
  {
    normal_energy += share * contact.normal_energy();
    tangential_energy += share * contact.tangential_energy();
    if (moves) slip += share * contact.slip_work();
  }

  /// Add a contact of ball i with a wall. The wall is a rigid body with this spin [rad/s] whose
  /// point at the ball's centre has this velocity [m/s]; the ball's forces and torques act back on
  /// it.
  void add_wall(int i, const contact::EvaluatedContact& contact, const Vector& spin,
                const Vector& velocity)
  {
    contact::Loads of_contact{};
    contact.add_loads_on_i(of_contact);
    for (int k = 0; k < contact::works; ++k) {
      for (int d = 0; d < 6; ++d) loads[i][k][d] += of_contact[k][d];
      wall_power[k] += contact::power(of_contact[k], velocity, spin);
    }
  }

  /// Count a contact that begins. energy: of the approach [J].
  void begin_contact(double energy, double share)
  {
    if (!(energy > 0.0)) return;
    impacts += share;
    impact_energy += share * energy;
    if (in_window) spectrum.add(energy, share);
  }

  std::vector<contact::Loads> loads;                    ///< of local balls
  double normal_energy = 0.0, tangential_energy = 0.0;  ///< stored [J]
  std::array<double, contact::works> wall_power{};      ///< of the walls on the balls, by kind [W]

  double slip = 0.0;                          ///< dissipated by slip since the start [J]
  double impacts = 0.0, impact_energy = 0.0;  ///< since the start [-], [J]
  bool in_window = false;                     ///< impacts go to the spectrum
  ImpactSpectrum spectrum;
};

/// Contacts of balls, with a mark of each entry of the pair list that was in contact at the last
/// evaluation. The list's own marks outlast a separation with the engine's history (`memory
/// stock`).
class PairSums : public ContactSums {
 public:
  /// Begin a new list, with the marks of contacts transferred.
  void begin_list(const int* touching, int entries)
  {
    in_contact_.assign(touching, touching + entries);
  }

  /// Mark the pair as in contact. Return whether it was not.
  bool begins(int entry) { return !std::exchange(in_contact_[entry], 1); }
  void separated(int entry) { in_contact_[entry] = 0; }

 private:
  std::vector<int> in_contact_;
};

}  // namespace millscale::energy
