#pragma once

#include <array>

#include "core/contact/contact_energy.h"

namespace millscale::ledger {

enum Pairing { ball_ball, ball_wall, pairings };

/// Powers or works of one instant: of the contacts on the balls, by pairing and kind, and of the
/// mill on the wall's turning surfaces. Each is a plain sum, so those of several ranks add up.
struct Works {
  std::array<std::array<double, contact::works>, pairings> on_balls{};
  double of_mill = 0.0;

  void add(double factor, const Works& other)
  {
    for (int p = 0; p < pairings; ++p)
      for (int k = 0; k < contact::works; ++k) on_balls[p][k] += factor * other.on_balls[p][k];
    of_mill += factor * other.of_mill;
  }
};

/// Work of forces in velocity Verlet, exact to rounding. The integrator applies the force F_n of
/// step n in two kicks, from v_{n-1/2} to v_n and from v_n to v_{n+1/2}; a kick of dt/2 does the
/// work dt/2 F times the mean of the two speeds. The kick after n is known at n but belongs to the
/// next step: it waits, and is replaced where the engine evaluates the forces of n anew.
struct WorkSums {
  /// At step n: powers of F_n at the mean speed of the kick before n, and of that after it [W].
  void step(const Works& before, const Works& after, double dt)
  {
    done.add(1.0, waiting);
    done.add(0.5 * dt, before);
    wait_for(after, dt);
  }

  /// At set-up: no kick has been, the next is of these forces.
  void wait_for(const Works& after, double dt)
  {
    waiting = {};
    waiting.add(0.5 * dt, after);
  }

  Works done;     ///< up to step n [J]
  Works waiting;  ///< of the kick after n [J]
};

/// What an energy account says of one pairing of bodies [J].
struct PairingTerms {
  double elastic_normal, elastic_tangential;  ///< change of the energy stored
  /// By the normal dashpot; by the tangential contact, which is the work done on it less what it
  /// stores; by rolling friction.
  double dissipated_normal, dissipated_tangential, dissipated_rolling;
  double tangential_dashpot, tangential_slip;  ///< parts of the tangential dissipation
  double spring_error;  ///< work done on the normal springs less what they store: of the steps
};

struct Stored {
  double normal = 0.0, tangential = 0.0;  ///< [J]
};

/// work: of the contacts on the balls; before, now: energy stored at the begin and now; slip [J].
inline PairingTerms terms_of(const std::array<double, contact::works>& work, const Stored& before,
                             const Stored& now, double slip)
{
  PairingTerms t{};
  t.elastic_normal = now.normal - before.normal;
  t.elastic_tangential = now.tangential - before.tangential;
  t.dissipated_normal = -work[contact::normal_dashpot];
  t.tangential_dashpot = -work[contact::tangential_dashpot];
  t.dissipated_tangential =
      -work[contact::tangential_spring] + t.tangential_dashpot - t.elastic_tangential;
  t.dissipated_rolling = -work[contact::rolling];
  t.tangential_slip = slip;
  t.spring_error = -work[contact::normal_spring] - t.elastic_normal;
  return t;
}

}  // namespace millscale::ledger
