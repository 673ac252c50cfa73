// One contact after the other: for machines without AVX, and the plain form of kernel_packs.cpp.
#include "core/energy/contact_sums.h"
#include "core/kernels/kernel.h"

namespace millscale::pairs::v2 {
namespace {

void add(double* sum, double sign, const Vector3<double>& part)
{
  sum[0] += sign * part.x;
  sum[1] += sign * part.y;
  sum[2] += sign * part.z;
}

/// Of those who keep no account of energy.
struct NoSums {
  void contact(const Task&, int, const contact::Contact<double>&,
               const contact::ContactForce<double>&)
  {
  }
  void apart(int) {}
};

/// Writes the contacts into an account of energy.
struct Sums {
  ledger::PairSums& of;

  void contact(const Task& task, int entry, const contact::Contact<double>& contact,
               const contact::ContactForce<double>& force)
  {
    const int i = task.own[entry], j = task.other[entry];
    const bool shared = j >= task.balls.owned;  // evaluated for the ghost's own ball as well
    const double share = shared ? 0.5 : 1.0;
    const contact::EvaluatedContact evaluated(contact, force);
    of.store(evaluated, share, task.advance);
    evaluated.add_loads_on_i(of.loads[i]);
    if (!shared) evaluated.add_loads_on_j(of.loads[j]);
    if (!of.first_touch(entry) || !task.advance) return;
    of.meet(evaluated.approach_energy(), share);
  }
  void apart(int entry) { of.apart(entry); }
};

template <class SumsOrNone>
void evaluate_contact(const Task& task, int entry, double* memory, SumsOrNone sums)
{
  const int i = task.own[entry], j = task.other[entry];
  const Balls& balls = task.balls;
  const Rows& rows = *task.rows;
  contact::BallPair<double> pair;
  pair.separation = vector3(balls.position[i]) - vector3(balls.position[j]);
  pair.r2 = dot(pair.separation, pair.separation);
  pair.radius_i = balls.radius[i];
  pair.radius_j = balls.radius[j];
  pair.mass_i = balls.mass[i];
  pair.mass_j = balls.mass[j];
  pair.velocity = vector3(balls.velocity[i]) - vector3(balls.velocity[j]);
  pair.spin_i = vector3(balls.spin[i]);
  pair.spin_j = vector3(balls.spin[j]);
  pair.displacement = vector3(memory);
  pair.damping_share = rows.motion[i].damping_share + rows.motion[j].damping_share;
  const auto& law = task.law[(balls.type[i] - 1) * task.types + balls.type[j] - 1];
  const auto contact = contact::contact_of(pair);
  const auto result = contact::contact_force(contact, law, task.terms, task.dt, task.advance);
  sums.contact(task, entry, contact, result);
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

/// Set each ball's share in the damping divisors and clear its sum of coefficients.
void begin_damping(const Task& task)
{
  const bool limited = task.terms.limited_damping;
  for (int i = 0; i < task.balls.all; ++i) {
    task.rows->motion[i].damping_share =
        limited ? contact::damping_share(task.damping[i], task.balls.mass[i], task.dt) : 0.0;
    task.rows->load[i].damping = 0.0;
  }
}

template <class SumsOrNone>
void evaluate_all(const Task& task, SumsOrNone sums)
{
  begin_damping(task);
  for (int entry = 0; entry < task.entries; ++entry) {
    const int i = task.own[entry], j = task.other[entry];
    const auto apart = vector3(task.balls.position[i]) - vector3(task.balls.position[j]);
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
  for (int i = 0; task.terms.limited_damping && task.advance && i < task.balls.owned; ++i)
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
