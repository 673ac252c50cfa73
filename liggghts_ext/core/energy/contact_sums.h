#pragma once

#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "core/contact/contact_energy.h"
#include "core/energy/impact_spectrum.h"

namespace millscale::ledger {

/// What the contacts of one class, ball-ball or ball-wall, leave at one evaluation of the forces
/// of a rank: loads by ball and kind of work, and the energy they store. Impacts and slip add up
/// from evaluation to evaluation.
///
/// Loads are kept of balls, not powers of contacts: the speeds that the work needs are known only
/// when all forces are, and a rank knows the speeds of its own balls then, not those of ghosts.
class ContactSums {
 public:
  /// Before the contacts are evaluated. balls: the rank's own.
  void clear(std::size_t balls)
  {
    loads.assign(balls, contact::Loads{});
    normal_energy = tangential_energy = 0.0;
    wall_power.fill(0.0);
  }

  /// share: of the contact that this rank accounts for, 1/2 if it is evaluated twice. moves: not at
  /// set-up, where memories stay as they are and nothing slides.
  void store(const contact::EvaluatedContact& contact, double share, bool moves)
  {
    normal_energy += share * contact.normal_energy();
    tangential_energy += share * contact.tangential_energy();
    if (moves) slip += share * contact.slip_work();
  }

  /// A contact of ball i with a wall, a rigid body of this spin [rad/s] whose point at the ball's
  /// centre has this velocity [m/s]: forces and torques on the ball act back on that body.
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

  /// An impact: two bodies met. energy: of the approach [J].
  void meet(double energy, double share)
  {
    if (!(energy > 0.0)) return;
    impacts += share;
    impact_energy += share * energy;
    if (in_window) spectrum.add(energy, share);
  }

  std::vector<contact::Loads> loads;                    ///< of own balls
  double normal_energy = 0.0, tangential_energy = 0.0;  ///< stored [J]
  std::array<double, contact::works> wall_power{};      ///< of the walls on the balls, by kind [W]

  double slip = 0.0;                          ///< dissipated by slip since the start [J]
  double impacts = 0.0, impact_energy = 0.0;  ///< since the start [-], [J]
  bool in_window = false;                     ///< impacts go to the spectrum
  ImpactSpectrum spectrum;
};

/// Contacts of balls: who touched at the last evaluation, by entry of the list of pairs. The list's
/// own marks stay after the balls part where memories are the engine's (`memory stock`).
class PairSums : public ContactSums {
 public:
  /// A new list, with the marks of contacts carried over.
  void begin_list(const int* touching, int entries) { met_.assign(touching, touching + entries); }

  /// Whether the pair did not touch before.
  bool first_touch(int entry) { return !std::exchange(met_[entry], 1); }
  void apart(int entry) { met_[entry] = 0; }

 private:
  std::vector<int> met_;
};

}  // namespace millscale::ledger
