#pragma once

namespace millscale::contact {

/// Return a ball's share in the divisor of its contacts' tangential damping [-]: dt D / m.
/// D [kg/s] is the sum of the tangential coefficients of all contacts of the ball, with balls and
/// walls. The coefficient of a contact of balls i and j is divided by
/// 1 + dt (D_i / m_i + D_j / m_j), that of a contact with a wall by 1 + dt D / m.
///
/// An explicit dashpot takes 7/2 dt c / m of the speed of a ball's surface in one step, since a
/// force at the surface also spins the ball: the dashpot acts on 2/7 of the mass. All contacts of a
/// ball take up to 7/2 y with y = dt D / m. Beyond y = 4/7 a bed of many damped contacts therefore
/// gains energy from its dashpots, and beyond y = 2/7 a speed changes its sign from step to step.
/// Divided, the dashpots take at most 7/2 y / (1 + y): the second limit is reached at y = 2/5, the
/// first at y = 4/3. The divisor goes to 1 with dt, so the converged motion stays the same.
/// `damping_time_step_limit` gives the larger step, docs/results/time-step.md what was measured.
/// Derived here.
[[gnu::always_inline]] inline double damping_share(double damping, double mass, double dt)
{
  return dt * damping / mass;
}

}  // namespace millscale::contact
