#pragma once

#include <array>

#include "core/contact/contact_energy.h"

namespace millscale::energy {

enum Pairing { ball_ball, ball_wall, pairings };

/// Power or work at one instant, on the balls by pairing and kind, and of the mill on the turning
/// surfaces of the wall. All are plain sums over ranks.
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
/// step n in two half steps, from v_{n-1/2} to v_n and from v_n to v_{n+1/2}. Each does the work
/// dt/2 F times the mean of the two velocities. The second half step of n belongs to step n + 1: it
/// waits, and is replaced where the engine evaluates the forces of n again.
struct WorkSums {
  /// Add step n. before, after: powers of F_n at the mean velocities of both half steps [W].
  void step(const Works& before, const Works& after, double dt)
  {
    done.add(1.0, waiting);
    done.add(0.5 * dt, before);
    wait_for(after, dt);
  }

  /// Begin a run: only the half step after the set-up is of these forces.
  void wait_for(const Works& after, double dt)
  {
    waiting = {};
    waiting.add(0.5 * dt, after);
  }

  Works done;     ///< up to step n [J]
  Works waiting;  ///< of the half step after n [J]
};

/// Terms of the energy budget of one pairing of bodies [J].
struct PairingTerms {
  double elastic_normal, elastic_tangential;  ///< change of the energy stored
  /// By the normal dashpot, the tangential contact (work done on it less energy stored) and rolling
  /// friction.
  double dissipated_normal, dissipated_tangential, dissipated_rolling;
  double tangential_dashpot, tangential_slip;  ///< parts of the tangential dissipation
  double spring_error;  ///< work done on the normal springs less energy stored: time-step error
};

struct Stored {
  double normal = 0.0, tangential = 0.0;  ///< [J]
};

/// Return the terms of one pairing. work: of the contacts on the balls [J]; before, now: energy
/// stored; slip: work against Coulomb's force [J].
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

}  // namespace millscale::energy
