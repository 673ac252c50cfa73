// One contact after the other: for machines without AVX, and the plain form of kernel_packs.cpp.
#include "core/energy/contact_sums.h"
#include "core/kernels/kernel.h"

namespace millscale::pairs::v2 {
namespace {

using contact::Triple;

Triple<double> triple(const double* v)
{
  return {v[0], v[1], v[2]};
}

void add(double* sum, double sign, const Triple<double>& part)
{
  sum[0] += sign * part.x;
  sum[1] += sign * part.y;
  sum[2] += sign * part.z;
}

/// Of those who keep no account of energy.
struct NoSums {
  void contact(const Task&, int, const contact::BallTouch<double>&,
               const contact::BallForces<double>&)
  {
  }
  void apart(int) {}
};

/// Writes the contacts into an account of energy.
struct Sums {
  ledger::PairSums& of;

  void contact(const Task& task, int entry, const contact::BallTouch<double>& touch,
               const contact::BallForces<double>& forces)
  {
    const int i = task.own[entry], j = task.other[entry];
    const bool shared = j >= task.balls.owned;  // evaluated for the ghost's own ball as well
    const double share = shared ? 0.5 : 1.0;
    const auto energy = contact::energy_of(forces);
    of.store(energy, share, task.advance);
    contact::add_loads(energy, 1.0, forces.parts.lever_i, of.loads[i]);
    if (!shared) contact::add_loads(energy, -1.0, forces.parts.lever_j, of.loads[j]);
    if (!of.first_touch(entry) || !task.advance) return;
    const double mass = touch.mass_i * touch.mass_j / (touch.mass_i + touch.mass_j);
    of.meet(contact::approach_energy(mass, dot(touch.velocity, forces.parts.normal)), share);
  }
  void apart(int entry) { of.apart(entry); }
};

template <class SumsOrNone>
void evaluate_contact(const Task& task, int entry, double* memory, SumsOrNone sums)
{
  const int i = task.own[entry], j = task.other[entry];
  const Balls& balls = task.balls;
  const Rows& rows = *task.rows;
  contact::BallTouch<double> touch;
  touch.apart = triple(balls.position[i]) - triple(balls.position[j]);
  touch.square = dot(touch.apart, touch.apart);
  touch.radius_i = balls.radius[i];
  touch.radius_j = balls.radius[j];
  touch.mass_i = balls.mass[i];
  touch.mass_j = balls.mass[j];
  touch.velocity = triple(balls.velocity[i]) - triple(balls.velocity[j]);
  touch.spin_i = triple(balls.spin[i]);
  touch.spin_j = triple(balls.spin[j]);
  touch.displacement = triple(memory);
  touch.held = rows.motion[i].held + rows.motion[j].held;
  const auto& law = task.law[(balls.type[i] - 1) * task.types + balls.type[j] - 1];
  const auto result = contact::ball_force(touch, law, task.terms, task.dt, task.advance);
  sums.contact(task, entry, touch, result);
  memory[0] = result.displacement.x;
  memory[1] = result.displacement.y;
  memory[2] = result.displacement.z;
  rows.load[i].damping += result.damping;
  add(task.force[i], 1.0, result.force);
  add(task.torque[i], 1.0, result.torque_i);
  if (j >= balls.owned) return;
  rows.load[j].damping += result.damping;
  add(task.force[j], -1.0, result.force);
  add(task.torque[j], 1.0, result.torque_j);
}

/// Before the contacts: what each ball's damping is divided by; no sum yet.
void hold(const Task& task)
{
  const bool bounded = task.terms.bounded;
  for (int i = 0; i < task.balls.all; ++i) {
    task.rows->motion[i].held =
        bounded ? contact::damping_held(task.damping[i], task.balls.mass[i], task.dt) : 0.0;
    task.rows->load[i].damping = 0.0;
  }
}

template <class SumsOrNone>
void evaluate_all(const Task& task, SumsOrNone sums)
{
  hold(task);
  for (int entry = 0; entry < task.entries; ++entry) {
    const int i = task.own[entry], j = task.other[entry];
    const auto apart = triple(task.balls.position[i]) - triple(task.balls.position[j]);
    const double radii = task.balls.radius[i] + task.balls.radius[j];
    double* memory = task.displacement + 3 * static_cast<std::size_t>(entry);
    if (dot(apart, apart) < radii * radii) {
      task.touching[entry] = 1;
      evaluate_contact(task, entry, memory, sums);
      continue;
    }
    sums.apart(entry);
    if (task.touching[entry] && task.forget_apart) {
      task.touching[entry] = 0;
      memory[0] = memory[1] = memory[2] = 0.0;
    }
  }
  for (int i = 0; task.terms.bounded && task.advance && i < task.balls.owned; ++i)
    task.damping[i] = task.rows->load[i].damping;
}

}  // namespace

void evaluate(const Task& task)
{
  evaluate_all(task, NoSums{});
}

void evaluate(const Task& task, ledger::PairSums& sums)
{
  evaluate_all(task, Sums{sums});
}

int* list_partners(const Candidates& candidates, Centre ball, int* out)
{
  for (int k = 0; k < candidates.count; ++k) {
    const double x = ball.x - candidates.x[k], y = ball.y - candidates.y[k],
                 z = ball.z - candidates.z[k], radii = ball.radius + candidates.radius[k];
    *out = candidates.index[k];  // kept only if it counts: no branch to mispredict
    out += x * x + y * y + z * z < radii * radii;
  }
  return out;
}

}  // namespace millscale::pairs::v2
