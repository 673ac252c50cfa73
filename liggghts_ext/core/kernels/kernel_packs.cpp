// Evaluates a pack of contacts at a time. In mixed precision, which particles overlap, by how much,
// and all sums over time are in double precision; velocities, the law and the sum of a particle's
// forces are in single precision. Compiled for x86-64-v3 and v4, see pack.h. Both give the same
// bits: they add the contacts to the rows in the order of the list.
#include "core/contact/damping_limit.h"
#include "core/kernels/find_contacts.h"

namespace millscale::kernels::MILLSCALE_LEVEL {
namespace {

template <class Number>
using Law = contact::ContactLaw<Number>;

template <class Number>
inline Law<Number> same_law(const Law<double>& law)
{
  return {Number(law.normal_stiffness), Number(law.tangential_stiffness),
          Number(law.normal_damping),   Number(law.tangential_damping),
          Number(law.sliding),          Number(law.rolling)};
}

/// Return the laws of a pack of contacts.
template <class Half>
inline Law<Two<Half>> gathered_law(const Task& task, const Found& found, int first)
{
  static_assert(sizeof(Law<double>) == 6 * sizeof(double));
  constexpr int lanes = Two<Half>::lanes;
  const double* law[lanes];
  for (int lane = 0; lane < lanes; ++lane) {
    const auto type_of = [&](Ball ball) { return task.particles.type[ball / 8] - 1; };
    const int a = type_of(found.i[first + lane]), b = type_of(found.j[first + lane]);
    law[lane] = &task.laws.of_types[a * task.laws.types + b].normal_stiffness;
  }
  const auto four = [&](int from) {
    const auto half = [&](int begin) {
      return columns<Half>([&](int lane) { return _mm256_loadu_pd(law[begin + lane] + from); });
    };
    return two(half(0), half(Half::lanes));
  };
  const auto head = four(0), tail = four(2);
  return {head.xyz.x, head.xyz.y, head.xyz.z, head.fourth, tail.xyz.z, tail.fourth};
}

inline VelocityRow* velocity_rows(const Rows& rows, Doubles)
{
  return rows.velocity;
}
inline SingleVelocityRow* velocity_rows(const Rows& rows, Singles)
{
  return rows.single_velocity;
}
inline ForceRow* force_rows(const Rows& rows, Doubles)
{
  return rows.force;
}
inline SingleForceRow* force_rows(const Rows& rows, Singles)
{
  return rows.single_force;
}

/// Square of the sum of the radii less the squared separation [m^2], exact however small.
inline Doubles excess_of(const Found& found, int first, Doubles)
{
  const auto column = [&](const double* all) { return from_doubles<Doubles>(all + first); };
  return excess({column(found.x), column(found.y), column(found.z)}, column(found.minus_radii));
}
inline Singles excess_of(const Found& found, int first, Singles)
{
  return singles(excess_of(found, first, Doubles{}), excess_of(found, first + width, Doubles{}));
}

/// Return a pack of pairs.
template <class Half>
inline contact::BallPair<Two<Half>> pairs_of(const Task& task, const Found& found, int first)
{
  const Rows& rows = *task.rows;
  const auto both = [&](const auto& of) { return two(of(first), of(first + Half::lanes)); };
  const auto column = [&](const double* all) {
    return both([&](int k) { return from_doubles<Half>(all + k); });
  };
  const auto velocity_of = [&](const Ball* ball) {
    return both([&](int k) { return velocities(velocity_rows(rows, Half{}), ball + k); });
  };
  const auto of_i = velocity_of(found.i), of_j = velocity_of(found.j);
  const auto history = both([&](int k) {  // fourth: radius of i
    return columns<Half>([&](int lane) {
      const double* displacement = task.pairs.displacement + found.displacement[k + lane];
      return _mm256_blend_pd(_mm256_loadu_pd(displacement),
                             _mm256_load_pd(&row_of(rows.position, found.i[k + lane]).x), 8);
    });
  });
  contact::BallPair<Two<Half>> pair;
  pair.separation = {column(found.x), column(found.y), column(found.z)};
  // Rounded as by the engine, not fused: a small overlap is known no better than this rounding.
  const auto square = [](const Two<Half>& a) { return Two<Half>(a * a); };
  pair.r2 = square(pair.separation.x) + square(pair.separation.y) + square(pair.separation.z);
  pair.radius_i = history.fourth;
  pair.radius_j = Two<Half>(0.0) - column(found.minus_radii) - pair.radius_i;
  pair.mass_i = of_i.velocity.fourth;
  pair.mass_j = of_j.velocity.fourth;
  pair.velocity = of_i.velocity.xyz - of_j.velocity.xyz;
  pair.spin_i = of_i.spin.xyz;
  pair.spin_j = of_j.spin.xyz;
  pair.displacement = history.xyz;
  pair.damping_share = of_i.spin.fourth + of_j.spin.fourth;
  pair.excess = both([&](int k) { return excess_of(found, k, Half{}); });
  return pair;
}

/// Store the first `count` displacements at address(lane).
template <class Address, class Half>
inline void store_at(const Address& address, int count, const Vector3<Half>& v)
{
  store_each([&](int lane, __m256d row) { store_three(address(lane), row); }, count,
             Columns<Half>{v, v.z});
}

template <class Half>
inline Two<Half> as_kept(const Two<Half>& a)
{
  return {as_kept(a.first), as_kept(a.second)};
}
template <class Half>
inline Vector3<Two<Half>> as_kept(const Vector3<Two<Half>>& v)
{
  return {as_kept(v.x), as_kept(v.y), as_kept(v.z)};
}

/// What the contacts of a pack kept, gathered one by one.
struct Gathered {
  float loads[6][2 * Singles::lanes];
  double dissipated[2 * Singles::lanes];

  energy::WorkColumns columns()
  {
    return {{loads[0], loads[1], loads[2]}, {loads[3], loads[4], loads[5]}, dissipated};
  }
};

/// Gather what the next `count` contacts kept, from number n on.
[[gnu::flatten, gnu::noinline]] inline void gather(const energy::WorkColumns& from,
                                                   Splices& splices, int n, int count, Gathered& to)
{
  __builtin_memset(&to, 0, sizeof to);
  for (int lane = 0; lane < count; ++lane) {
    const int k = splices.use_for(n + lane);
    if (k != Splices::no_contact) to.columns().set(lane, from.get(k));
  }
}

/// Record the loads of the first `count` of a pack of contacts, and the work against the loads of
/// this step and of the step before with the velocity between both: velocity Verlet applies a force
/// in two half steps. The loads are kept in single precision. What they lose is counted here, so
/// that only the change of the velocity until the next step meets the rounding.
template <class Half>
inline void record_work(const Task& task, Found& found, int first, int count,
                        const contact::BallPair<Two<Half>>& pair,
                        const contact::Contact<Two<Half>>& contact,
                        const contact::ContactForce<Two<Half>>& result)
{
  using Number = Two<Half>;
  energy::WorkRecord& record = *task.record;
  const int n = found.evaluated + first;
  Gathered gathered;
  energy::WorkColumns before = record.before;
  int at = 0;
  if (__builtin_expect(found.splices.none(n, count), true)) {
    at = found.splices.use(count);
  } else {
    gather(record.before, found.splices, n, count, gathered);
    before = gathered.columns();
  }
  const auto column = [&](const float* all) {
    return two(from_singles(all + at, Half{}), from_singles(all + at + Half::lanes, Half{}));
  };
  const auto vector = [&](float* const* all) {
    return Vector3<Number>{column(all[0]), column(all[1]), column(all[2])};
  };
  const auto of_kept = energy::powers_of_kept(vector(before.force), vector(before.torque), pair,
                                              contact.inverse_distance, task.step.dt);
  const Vector3<Number> force = subtract_scaled(result.force, result.elastic_force, contact.normal);
  const Vector3<Number>& torque = result.rolling_torque;
  const Vector3<Number> kept_force = as_kept(force), kept_torque = as_kept(torque);
  const auto of_now = energy::powers_of_loads(force + (force - kept_force),
                                              torque + (torque - kept_torque), contact);
  const Number done = Number(-record.half_step) * Number((of_kept.of_force + of_now.of_force) +
                                                         (of_kept.of_torque + of_now.of_torque));
  // Sums over time are in double precision.
  const Ball ghosts = 8u * static_cast<Ball>(task.particles.nlocal);
  const auto add = [&](const Half& of_half, int begin) {
    for (int p = 0; p < Half::lanes / width; ++p) {
      const int lane = begin + p * width;
      const Doubles work = in_doubles(of_half, p);
      store_numbers(record.now.dissipated + n + lane,
                    from_doubles<Doubles>(before.dissipated + at + lane) + work);
      double* const total = record.work + lane % energy::WorkRecord::lanes;
      store_numbers(total, from_doubles<Doubles>(total) +
                               shares(found.j + first + lane, ghosts, count - lane) * work);
    }
  };
  add(done.first, 0);
  add(done.second, Half::lanes);
  const auto store = [&](float* const* to, const Vector3<Number>& v) {
    const auto store_column = [&](float* all, const Number& numbers) {
      store_numbers(all + n, numbers.first);
      store_numbers(all + n + Half::lanes, numbers.second);
    };
    store_column(to[0], v.x);
    store_column(to[1], v.y);
    store_column(to[2], v.z);
  };
  store(record.now.force, kept_force);
  store(record.now.torque, kept_torque);
}

/// Evaluate the first `count` of a pack of contacts. `usual` fixes the terms of the law that decks
/// have as a rule.
template <class Half, bool usual, bool limited, bool recorded>
[[gnu::flatten, gnu::noinline]] void evaluate_pack(const Task& task, Found& found, int first,
                                                   int count, const Law<Two<Half>>& law)
{
  constexpr bool single = std::is_same_v<Half, Singles>;
  const contact::ContactTerms terms =
      usual ? contact::ContactTerms{true, true, limited, true} : task.terms;
  const bool advance = usual || task.step.advance;
  const auto pair = pairs_of<Half>(task, found, first);
  const auto contact = contact::contact_of<single>(pair);
  const auto result = contact::contact_force(contact, law, terms, task.step.dt, advance);
  const Loads<Two<Half>> loads{result.force, result.torque_i, result.torque_j, result.damping};
  const auto store = [&](int begin, int count, const Vector3<Half>& displacement,
                         const Loads<Half>& loads) {
    if (advance && terms.history)
      store_at([&](int lane) { return task.pairs.displacement + found.displacement[begin + lane]; },
               count, displacement);
    add_loads(force_rows(*task.rows, Half{}), found.i + begin, found.j + begin, count, loads);
  };
  // Addresses are read again from here on: kept, they would take the registers of the law.
  asm volatile("" ::: "memory");
  store(first, count, first_of(result.displacement), first_of(loads));
  if (count > Half::lanes)
    store(first + Half::lanes, count - Half::lanes, second_of(result.displacement),
          second_of(loads));
  if constexpr (recorded) record_work<Half>(task, found, first, count, pair, contact, result);
}

template <class Half, bool usual, bool limited, bool recorded>
inline void evaluate_list(const Task& task)
{
  constexpr int lanes = Two<Half>::lanes;
  const Laws& laws = task.laws;
  Law<Two<Half>> law;
  if (laws.only_type > 0)
    law = same_law<Two<Half>>(laws.of_types[(laws.only_type - 1) * (laws.types + 1)]);
  const auto* const velocity = velocity_rows(*task.rows, Half{});
  const auto* const force = force_rows(*task.rows, Half{});
  for_each_pack<lanes, recorded>(
      task,
      [&](const Found& found, int first) {
        for (int lane = 0; lane < lanes; ++lane) {
          const Ball j = found.j[first + lane];
          __builtin_prefetch(&row_of(velocity, j));
          __builtin_prefetch(&row_of(force, j), 1);
        }
      },
      [&](Found& found, int first, int count) {
        if (laws.only_type == 0) law = gathered_law<Half>(task, found, first);
        evaluate_pack<Half, usual, limited, recorded>(task, found, first, count, law);
      });
}

template <class Half, bool recorded>
inline void evaluate_terms(const Task& task)
{
  const contact::ContactTerms& terms = task.terms;
  const bool usual =
      terms.history && terms.tangential_damping && terms.rolling && task.step.advance;
  if (!usual)
    evaluate_list<Half, false, false, recorded>(task);
  else if (terms.limited_damping)
    evaluate_list<Half, true, true, recorded>(task);
  else
    evaluate_list<Half, true, false, recorded>(task);
}

template <class Half>
inline void evaluate_number(const Task& task)
{
  if (task.record)
    evaluate_terms<Half, true>(task);
  else
    evaluate_terms<Half, false>(task);
}

/// Return the first three numbers at an address, and 0.
inline __m256d three(const double* numbers)
{
  return _mm256_maskload_pd(numbers, _mm256_setr_epi64x(-1, -1, -1, 0));
}

/// Copy positions and velocities of all particles into rows with store(row, numbers).
template <class Row, class Store>
inline void fill_rows(const Task& task, Row* row, const Store& store)
{
  const neighbor::Particles& particles = task.particles;
  const auto fill = [&](int i, const auto& vector) {
    const auto with = [&](const double* v, double fourth) {
      return _mm256_blend_pd(vector(v), _mm256_set1_pd(fourth), 8);
    };
    const double share =
        task.terms.limited_damping
            ? contact::damping_share(task.sums.damping[i], particles.mass[i], task.step.dt)
            : 0.0;
    _mm256_store_pd(&task.rows->position[i].x, with(particles.position[i], particles.radius[i]));
    store(row[i].velocity, with(particles.velocity[i], particles.mass[i]));
    store(row[i].spin, with(particles.spin[i], share));
  };
  // Only the last particle's vectors need a masked load, which is slow on some machines.
  const int last = particles.total() - 1;
  for (int i = 0; i < last; ++i) fill(i, [](const double* v) { return _mm256_loadu_pd(v); });
  if (last >= 0) fill(last, three);
}

/// Add the force rows of the local particles to their sums, and clear the rows.
template <class Row>
inline void add_forces(const Task& task, Row* row)
{
  for (int i = 0; i < task.particles.nlocal; ++i) {
    for (int d = 0; d < 3; ++d) task.sums.force[i][d] += row[i].force[d];
    for (int d = 0; d < 3; ++d) task.sums.torque[i][d] += row[i].torque[d];
    if (task.terms.limited_damping && task.step.advance) task.sums.damping[i] = row[i].damping;
    row[i] = Row{};
  }
}

}  // namespace

void evaluate_rows(const Task& task)
{
  evaluate_number<Doubles>(task);
}

void evaluate_rows_mixed(const Task& task)
{
  evaluate_number<Singles>(task);
}

void evaluate(const Task& task)
{
  fill_rows(task, task.rows->velocity,
            [](double* to, __m256d numbers) { _mm256_store_pd(to, numbers); });
  evaluate_rows(task);
  add_forces(task, task.rows->force);
}

void evaluate_mixed(const Task& task)
{
  fill_rows(task, task.rows->single_velocity,
            [](float* to, __m256d numbers) { _mm_store_ps(to, _mm256_cvtpd_ps(numbers)); });
  evaluate_rows_mixed(task);
  add_forces(task, task.rows->single_force);
}

}  // namespace millscale::kernels::MILLSCALE_LEVEL
