#pragma once

namespace millscale::contact {

/// A ball's share in what the tangential damping of its contacts is divided by [-]: dt D / m, D
/// [kg/s] being the sum of the tangential coefficients of all its contacts, with balls and walls.
/// A contact of balls i and j is divided by 1 + dt (D_i / m_i + D_j / m_j), one with a wall by
/// 1 + dt D / m.
///
/// An explicit dashpot takes 7/2 dt c / m of the speed of a ball's surface in one step, since a
/// push at the surface also spins the ball: it acts on 2/7 of the mass. All contacts of a ball take
/// up to 7/2 y with y = dt D / m, so beyond y = 4/7 a bed of many damped contacts gains energy from
/// them, and beyond 2/7 a speed changes its sign from step to step. Divided, they take at most
/// 7/2 y / (1 + y): the second limit is met at y = 2/5, and at y = 4/3 the first. The divisor goes
/// to 1 with dt, so the converged motion stays the same; `damping_time_step_limit` has what it
/// gains, docs/results/time-step.md what is measured. Derived here.
[[gnu::always_inline]] inline double damping_held(double damping, double mass, double dt)
{
  return dt * damping / mass;
}

}  // namespace millscale::contact
