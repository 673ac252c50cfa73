// Evaluates one contact at a time, for machines without AVX2. kernel_packs.cpp is the same
// algorithm.
#include <cmath>

#include "core/contact/damping_limit.h"
#include "core/energy/contact_sums.h"
#include "core/kernels/levels.h"

namespace millscale::kernels::v2 {
namespace {

void add(double* sum, double sign, const Vector3<double>& part)
{
  sum[0] += sign * part.x;
  sum[1] += sign * part.y;
  sum[2] += sign * part.z;
}

/// Without the energy budget.
struct NoBudget {
  void contact(const Task&, int, const contact::Contact<double>&,
               const contact::ContactForce<double>&)
  {
  }
  void separated(int) {}
};

/// Adds the contacts to the energy budget.
struct Budget {
  energy::PairSums& of;

  void contact(const Task& task, int entry, const contact::Contact<double>& contact,
               const contact::ContactForce<double>& force)
  {
    const int i = task.pairs.own[entry], j = task.pairs.other[entry];
    const bool shared =
        j >= task.particles.nlocal;  // also evaluated by the rank that owns the ghost
    const double share = shared ? 0.5 : 1.0;
    const contact::EvaluatedContact evaluated(contact, force);
    of.store(evaluated, share, task.step.advance);
    evaluated.add_loads_on_i(of.loads[i]);
    if (!shared) evaluated.add_loads_on_j(of.loads[j]);
    if (!of.begins(entry) || !task.step.advance) return;
    of.begin_contact(evaluated.approach_energy(), share);
  }
  void separated(int entry) { of.separated(entry); }
};

/// Return a pair of the list.
contact::BallPair<double> pair_of(const Task& task, int entry)
{
  const int i = task.pairs.own[entry], j = task.pairs.other[entry];
  const neighbor::Particles& particles = task.particles;
  contact::BallPair<double> pair;
  pair.separation = vector3(particles.position[i]) - vector3(particles.position[j]);
  pair.r2 = dot(pair.separation, pair.separation);
  pair.radius_i = particles.radius[i];
  pair.radius_j = particles.radius[j];
  pair.mass_i = particles.mass[i];
  pair.mass_j = particles.mass[j];
  pair.velocity = vector3(particles.velocity[i]) - vector3(particles.velocity[j]);
  pair.spin_i = vector3(particles.spin[i]);
  pair.spin_j = vector3(particles.spin[j]);
  pair.displacement = vector3(task.pairs.displacement + 3 * static_cast<std::size_t>(entry));
  pair.damping_share = task.rows->velocity[i].damping_share + task.rows->velocity[j].damping_share;
  return pair;
}

/// Without a record of the work.
struct NoRecord {
  void contact(const Task&, int, const contact::BallPair<double>&, const contact::Contact<double>&,
               const contact::ContactForce<double>&)
  {
  }
  void begins(const Task&, int) {}
  void ends(const Task&, int) {}
};

/// Records the work of each contact, as `record_work` in kernel_packs.cpp does.
struct Record {
  energy::WorkRecord& to;
  int before = 0, now = 0;  ///< contacts of the step before, and of this one, among those seen
  bool begun = false;       ///< the contact to come begins

  static double share(const Task& task, int entry)
  {
    return task.pairs.other[entry] < task.particles.nlocal ? 1.0 : 0.5;
  }

  /// Return the numbers as single precision keeps them, in an array too.
  static Vector3<double> keep(const Vector3<double>& from, float (&numbers)[3])
  {
    numbers[0] = static_cast<float>(from.x);
    numbers[1] = static_cast<float>(from.y);
    numbers[2] = static_cast<float>(from.z);
    return energy::vector_of(numbers);
  }

  void contact(const Task& task, int entry, const contact::BallPair<double>& pair,
               const contact::Contact<double>& contact, const contact::ContactForce<double>& result)
  {
    energy::ContactWork work{};
    if (!begun) work = to.before.get(before++);
    begun = false;
    const auto of_kept =
        energy::powers_of_kept(energy::vector_of(work.force), energy::vector_of(work.torque), pair,
                               contact.inverse_distance, task.step.dt);
    const Vector3<double> force = result.force - result.elastic_force * contact.normal;
    const Vector3<double>& torque = result.rolling_torque;
    const Vector3<double> kept_force = keep(force, work.force);
    const Vector3<double> kept_torque = keep(torque, work.torque);
    const auto of_now = energy::powers_of_loads(force + (force - kept_force),
                                                torque + (torque - kept_torque), contact);
    const double done =
        -to.half_step * (of_kept.of_force + of_now.of_force + of_kept.of_torque + of_now.of_torque);
    work.dissipated += done;
    to.work[0] += share(task, entry) * done;
    to.now.set(now++, work);
  }
  void begins(const Task& task, int entry)
  {
    begun = true;
    to.begin(entry, pair_of(task, entry));
  }
  void ends(const Task& task, int entry)
  {
    to.end(entry, before++, task.pairs.own[entry], task.pairs.other[entry], share(task, entry),
           pair_of(task, entry));
  }
};

template <class BudgetOrNone, class RecordOrNone>
void evaluate_contact(const Task& task, int entry, double* displacement, BudgetOrNone budget,
                      RecordOrNone& record)
{
  const int i = task.pairs.own[entry], j = task.pairs.other[entry];
  const neighbor::Particles& particles = task.particles;
  const Rows& rows = *task.rows;
  const contact::BallPair<double> pair = pair_of(task, entry);
  const auto& law =
      task.laws.of_types[(particles.type[i] - 1) * task.laws.types + particles.type[j] - 1];
  const auto contact = contact::contact_of(pair);
  const auto result =
      contact::contact_force(contact, law, task.terms, task.step.dt, task.step.advance);
  budget.contact(task, entry, contact, result);
  record.contact(task, entry, pair, contact, result);
  displacement[0] = result.displacement.x;
  displacement[1] = result.displacement.y;
  displacement[2] = result.displacement.z;
  rows.force[i].damping += result.damping;
  add(task.sums.force[i], 1.0, result.force);
  add(task.sums.torque[i], 1.0, result.torque_i);
  if (j >= particles.nlocal) return;
  rows.force[j].damping += result.damping;
  add(task.sums.force[j], -1.0, result.force);
  add(task.sums.torque[j], 1.0, result.torque_j);
}

/// Raise the largest overlap, radii less distance of the centres [m].
void raise_overlap(const Task& task, double radii, const Vector3<double>& separation)
{
  if (!task.largest_overlap) return;
  const double overlap = radii - std::sqrt(dot(separation, separation));
  if (overlap > *task.largest_overlap) *task.largest_overlap = overlap;
}

/// Set each ball's share in the damping divisors and clear its sum of coefficients.
void begin_damping(const Task& task)
{
  const bool limited = task.terms.limited_damping;
  for (int i = 0; i < task.particles.total(); ++i) {
    task.rows->velocity[i].damping_share =
        limited ? contact::damping_share(task.sums.damping[i], task.particles.mass[i], task.step.dt)
                : 0.0;
    task.rows->force[i].damping = 0.0;
  }
}

template <class BudgetOrNone, class RecordOrNone>
void evaluate_all(const Task& task, BudgetOrNone budget, RecordOrNone record)
{
  begin_damping(task);
  for (int entry = 0; entry < task.pairs.entries; ++entry) {
    const int i = task.pairs.own[entry], j = task.pairs.other[entry];
    const auto separation =
        vector3(task.particles.position[i]) - vector3(task.particles.position[j]);
    const double radii = task.particles.radius[i] + task.particles.radius[j];
    double* displacement = task.pairs.displacement + 3 * static_cast<std::size_t>(entry);
    int& touching = task.pairs.touching[entry];
    if (dot(separation, separation) < radii * radii) {
      if (!touching) {
        displacement[0] = displacement[1] = displacement[2] = 0.0;
        record.begins(task, entry);
      }
      touching = 1;
      raise_overlap(task, radii, separation);
      evaluate_contact(task, entry, displacement, budget, record);
      continue;
    }
    budget.separated(entry);
    if (touching) record.ends(task, entry);
    if (task.step.reset_on_separation) touching = 0;
  }
  for (int i = 0; task.terms.limited_damping && task.step.advance && i < task.particles.nlocal; ++i)
    task.sums.damping[i] = task.rows->force[i].damping;
}

template <class BudgetOrNone>
void evaluate_with(const Task& task, BudgetOrNone budget)
{
  if (task.record)
    evaluate_all(task, budget, Record{*task.record});
  else
    evaluate_all(task, budget, NoRecord{});
}

}  // namespace

void evaluate(const Task& task)
{
  evaluate_with(task, NoBudget{});
}

}  // namespace millscale::kernels::v2

namespace millscale::kernels {

void evaluate_with_budget(const Task& task, energy::PairSums& sums)
{
  v2::evaluate_with(task, v2::Budget{sums});
}

}  // namespace millscale::kernels
