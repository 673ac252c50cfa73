// Evaluates eight contacts at a time in mixed precision. Which particles overlap, by how much, and
// all sums over time are in double precision; velocities, the law and the sum of a particle's
// forces are in single precision. Compiled for x86-64-v3 and v4, see find_contacts.h.
#include "core/kernels/find_contacts.h"

namespace millscale::kernels::MILLSCALE_LEVEL {
namespace {

constexpr int lanes = 8;

/// Eight floats: one number of each of eight contacts, or rows of four of contacts k and k + 4.
struct Singles {
  typedef float Values __attribute__((vector_size(32)));
  typedef int Mask __attribute__((vector_size(32)));

  Values values;

  Singles() = default;
  explicit Singles(double all) : values(Values{} + static_cast<float>(all)) {}
  explicit Singles(Values v) : values(v) {}

  friend Singles operator+(Singles a, Singles b) { return Singles(a.values + b.values); }
  friend Singles operator-(Singles a, Singles b) { return Singles(a.values - b.values); }
  friend Singles operator*(Singles a, Singles b) { return Singles(a.values * b.values); }
  friend Singles operator/(Singles a, Singles b) { return Singles(a.values / b.values); }
  friend Mask operator>(Singles a, Singles b) { return a.values > b.values; }
  friend Singles choose(Mask condition, Singles yes, Singles no)
  {
    return Singles(condition ? yes.values : no.values);
  }
  friend Singles sqrt(Singles a) { return Singles(_mm256_sqrt_ps(__m256(a.values))); }
  friend Singles abs(Singles a)
  {
    return Singles(_mm256_andnot_ps(_mm256_set1_ps(-0.0f), __m256(a.values)));
  }
};

using Vectors = Vector3<Singles>;
using Law = contact::ContactLaw<Singles>;

inline __m256 m(Singles a)
{
  return __m256(a.values);
}

/// Return two rows of four side by side.
inline Singles beside(__m128 first, __m128 second)
{
  return Singles(_mm256_insertf128_ps(_mm256_castps128_ps256(first), second, 1));
}

/// Return `first` with the fourth number of both rows from `other`.
inline Singles with_fourths(Singles first, Singles other)
{
  return Singles(_mm256_blend_ps(m(first), m(other), 0x88));
}

inline __m128 single(Pack numbers)
{
  return _mm256_cvtpd_ps(__m256d(numbers.values));
}

/// Rows of eight contacts, or their columns.
struct Quads {
  Singles of[4];
};

inline Quads transposed(const Quads& q)
{
  const __m256 low_ab = _mm256_unpacklo_ps(m(q.of[0]), m(q.of[1]));
  const __m256 high_ab = _mm256_unpackhi_ps(m(q.of[0]), m(q.of[1]));
  const __m256 low_cd = _mm256_unpacklo_ps(m(q.of[2]), m(q.of[3]));
  const __m256 high_cd = _mm256_unpackhi_ps(m(q.of[2]), m(q.of[3]));
  return {{Singles(_mm256_shuffle_ps(low_ab, low_cd, 0x44)),
           Singles(_mm256_shuffle_ps(low_ab, low_cd, 0xee)),
           Singles(_mm256_shuffle_ps(high_ab, high_cd, 0x44)),
           Singles(_mm256_shuffle_ps(high_ab, high_cd, 0xee))}};
}

/// Return the columns of row(k), the rows of contacts k and k + 4.
template <class Row>
inline Quads columns(const Row& row)
{
  return transposed({{row(0), row(1), row(2), row(3)}});
}

inline Vectors vectors(const Quads& columns)
{
  return {columns.of[0], columns.of[1], columns.of[2]};
}

inline Quads rows(const Vectors& v, Singles fourth)
{
  return transposed({{v.x, v.y, v.z, fourth}});
}

/// Return, for eight pairs, the square of the sum of the radii less the squared separation [m^2],
/// exact to single precision however small.
inline Singles excess(const PositionRow* position, const int* i, const int* j)
{
  const auto of = [&](int first) {
    const Pack gap = gap_of_squares(
        position, [&](int k) { return i[first + k]; }, [&](int k) { return j[first + k]; });
    return single(Pack(0.0) - gap);
  };
  return beside(of(0), of(4));
}

/// Return eight pairs.
inline contact::BallPair<Singles> pair_of(const Task& task, const int* entry, const int* i,
                                          const int* j)
{
  const PositionRow* const position = task.rows->position;
  const SingleVelocityRow* const row_of = task.rows->single_velocity;
  const auto at = [&](int ball) { return four(&position[ball].x); };
  const auto two = [](auto of) { return [of](int k) { return beside(of(k), of(k + 4)); }; };
  // The fourth column holds one scalar of each contact.
  const Quads separation =
      columns(two([&](int k) { return single(with_fourth(at(i[k]) - at(j[k]), at(j[k]))); }));
  const Quads history = columns(two([&](int k) {
    return single(with_fourth(
        four(task.pairs.displacement + 3 * static_cast<std::size_t>(entry[k])), at(i[k])));
  }));
  const auto velocity_i = two([&](int k) { return _mm_load_ps(row_of[i[k]].velocity); });
  const auto velocity_j = two([&](int k) { return _mm_load_ps(row_of[j[k]].velocity); });
  const auto turning_i = two([&](int k) { return _mm_load_ps(row_of[i[k]].spin); });
  const auto turning_j = two([&](int k) { return _mm_load_ps(row_of[j[k]].spin); });
  const Quads speed = columns([&](int k) {
    const Singles of_i = velocity_i(k);
    return with_fourths(of_i - velocity_j(k), of_i);
  });
  const Quads spin_i = columns([&](int k) { return with_fourths(turning_i(k), velocity_j(k)); });
  const Quads spin_j = columns([&](int k) {
    const Singles of_j = turning_j(k);
    return with_fourths(of_j, of_j + turning_i(k));
  });
  contact::BallPair<Singles> pair;
  pair.separation = vectors(separation);
  pair.r2 = dot(pair.separation, pair.separation);
  pair.excess = excess(position, i, j);
  pair.radius_i = history.of[3];
  pair.radius_j = separation.of[3];
  pair.mass_i = speed.of[3];
  pair.mass_j = spin_i.of[3];
  pair.velocity = vectors(speed);
  pair.spin_i = vectors(spin_i);
  pair.spin_j = vectors(spin_j);
  pair.displacement = vectors(history);
  pair.damping_share = spin_j.of[3];
  return pair;
}

inline void add(SingleForceRow& row, __m256 part)
{
  _mm256_store_ps(row.force, _mm256_add_ps(_mm256_load_ps(row.force), part));
}

/// Evaluate `count` <= lanes contacts.
[[gnu::flatten, gnu::noinline]] void evaluate_pack(const Task& task, const int* entry, int count,
                                                   const Law& law)
{
  int i[lanes], j[lanes];
  for (int lane = 0; lane < lanes; ++lane) i[lane] = task.pairs.own[entry[lane]];
  for (int lane = 0; lane < lanes; ++lane) j[lane] = task.pairs.other[entry[lane]];
  const auto result = contact::contact_force(contact::contact_of<true>(pair_of(task, entry, i, j)),
                                             law, task.terms, task.step.dt, task.step.advance);

  const Singles zero(0.0);
  const Quads kept = rows(result.displacement, zero);
  const Quads force = rows(result.force, result.damping);
  const Quads back =
      rows({zero - result.force.x, zero - result.force.y, zero - result.force.z}, result.damping);
  const Quads torque_i = rows(result.torque_i, zero), torque_j = rows(result.torque_j, zero);
  const auto store = [&](int lane, __m128 history, __m256 on_i, __m256 on_j) {
    if (task.step.advance)
      store_three(task.pairs.displacement + 3 * static_cast<std::size_t>(entry[lane]),
                  Pack(Pack::Values(_mm256_cvtps_pd(history))));
    add(task.rows->single_force[i[lane]], on_i);
    add(task.rows->single_force[j[lane]], on_j);
  };
  for (int k = 0; k < 4 && k < count; ++k)
    store(k, _mm256_castps256_ps128(m(kept.of[k])),
          _mm256_permute2f128_ps(m(force.of[k]), m(torque_i.of[k]), 0x20),
          _mm256_permute2f128_ps(m(back.of[k]), m(torque_j.of[k]), 0x20));
  for (int k = 0; k + 4 < count; ++k)
    store(k + 4, _mm256_extractf128_ps(m(kept.of[k]), 1),
          _mm256_permute2f128_ps(m(force.of[k]), m(torque_i.of[k]), 0x31),
          _mm256_permute2f128_ps(m(back.of[k]), m(torque_j.of[k]), 0x31));
}

/// Copy positions and velocities of all particles into rows.
void fill_single_rows(const Task& task)
{
  const neighbor::Particles& particles = task.particles;
  const Rows rows = *task.rows;
  for_each_particle(particles.total(), [&](int i, const auto& vector) {
    SingleVelocityRow& row_of = rows.single_velocity[i];
    put(&rows.position[i].x, with_fourth(vector(particles.position[i]), Pack(particles.radius[i])));
    _mm_store_ps(row_of.velocity,
                 single(with_fourth(vector(particles.velocity[i]), Pack(particles.mass[i]))));
    _mm_store_ps(row_of.spin,
                 single(with_fourth(vector(particles.spin[i]), Pack(damping_share(task, i)))));
  });
}

/// Add the force rows of the local particles to their sums, and clear the rows.
void add_single_forces(const Task& task)
{
  SingleForceRow* const row = task.rows->single_force;
  for (int i = 0; i < task.particles.nlocal; ++i) {
    for (int d = 0; d < 3; ++d) task.sums.force[i][d] += row[i].force[d];
    for (int d = 0; d < 3; ++d) task.sums.torque[i][d] += row[i].torque[d];
    if (task.terms.limited_damping && task.step.advance) task.sums.damping[i] = row[i].damping;
    row[i] = SingleForceRow{};
  }
}

}  // namespace

void evaluate_rows_mixed(const Task& task)
{
  evaluate_list<Singles, lanes>(
      task,
      [&](int entry) {
        prefetch_contact(task, entry, task.rows->single_velocity, task.rows->single_force);
      },
      [&](const int* entry, int count, const Law& law) { evaluate_pack(task, entry, count, law); });
}

void evaluate_mixed(const Task& task)
{
  fill_single_rows(task);
  evaluate_rows_mixed(task);
  add_single_forces(task);
}

}  // namespace millscale::kernels::MILLSCALE_LEVEL
