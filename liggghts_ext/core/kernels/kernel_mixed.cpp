// Compiled for x86-64-v3 and v4, see find_contacts.h: forces of eight contacts at a time. Which
// balls touch, their overlaps, and all that is summed over time are in double precision;
// velocities, the law and the sum of a ball's forces are in single precision.
#include "core/kernels/find_contacts.h"

namespace millscale::pairs::MILLSCALE_LEVEL {
namespace {

constexpr int lanes = 8;

/// Eight floats: the same number of eight contacts, or two rows of four of contacts k and k + 4.
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

/// Two rows of four side by side.
inline Singles beside(__m128 first, __m128 second)
{
  return Singles(_mm256_insertf128_ps(_mm256_castps128_ps256(first), second, 1));
}

/// The fourth number of both rows from the other.
inline Singles with_fourths(Singles first, Singles other)
{
  return Singles(_mm256_blend_ps(m(first), m(other), 0x88));
}

inline __m128 single(Pack numbers)
{
  return _mm256_cvtpd_ps(__m256d(numbers.values));
}

/// Rows of eight contacts to columns and back.
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

/// Columns of the rows that `row` gives for contacts k and k + 4.
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

/// How far eight pairs reach into each other: squares of the sums of radii less those of the
/// distances [m^2], exact to single precision however small they are.
inline Singles excess(const Place* place, const int* i, const int* j)
{
  const auto of = [&](int first) {
    const Pack beyond = beyond_touch(
        place, [&](int k) { return i[first + k]; }, [&](int k) { return j[first + k]; });
    return single(Pack(0.0) - beyond);
  };
  return beside(of(0), of(4));
}

/// What the force of eight contacts asks for.
inline contact::BallPair<Singles> pair_of(const Task& task, const int* entry, const int* i,
                                          const int* j)
{
  const Place* const place = task.rows->place;
  const SingleMotion* const motion = task.rows->single_motion;
  const auto at = [&](int ball) { return four(&place[ball].x); };
  const auto two = [](auto of) { return [of](int k) { return beside(of(k), of(k + 4)); }; };
  // The fourth columns carry one number of each contact beside the vectors.
  const Quads apart =
      columns(two([&](int k) { return single(with_fourth(at(i[k]) - at(j[k]), at(j[k]))); }));
  const Quads memory = columns(two([&](int k) {
    return single(
        with_fourth(four(task.displacement + 3 * static_cast<std::size_t>(entry[k])), at(i[k])));
  }));
  const auto velocity_i = two([&](int k) { return _mm_load_ps(motion[i[k]].velocity); });
  const auto velocity_j = two([&](int k) { return _mm_load_ps(motion[j[k]].velocity); });
  const auto turning_i = two([&](int k) { return _mm_load_ps(motion[i[k]].spin); });
  const auto turning_j = two([&](int k) { return _mm_load_ps(motion[j[k]].spin); });
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
  pair.separation = vectors(apart);
  pair.r2 = dot(pair.separation, pair.separation);
  pair.excess = excess(place, i, j);
  pair.radius_i = memory.of[3];
  pair.radius_j = apart.of[3];
  pair.mass_i = speed.of[3];
  pair.mass_j = spin_i.of[3];
  pair.velocity = vectors(speed);
  pair.spin_i = vectors(spin_i);
  pair.spin_j = vectors(spin_j);
  pair.displacement = vectors(memory);
  pair.damping_share = spin_j.of[3];
  return pair;
}

inline void add(SingleLoad& load, __m256 part)
{
  _mm256_store_ps(load.force, _mm256_add_ps(_mm256_load_ps(load.force), part));
}

/// Forces of `count` <= lanes contacts.
[[gnu::flatten, gnu::noinline]] void evaluate_pack(const Task& task, const int* entry, int count,
                                                   const Law& law)
{
  int i[lanes], j[lanes];
  for (int lane = 0; lane < lanes; ++lane) i[lane] = task.own[entry[lane]];
  for (int lane = 0; lane < lanes; ++lane) j[lane] = task.other[entry[lane]];
  const auto result = contact::contact_force(contact::contact_of<true>(pair_of(task, entry, i, j)),
                                             law, task.terms, task.dt, task.advance);

  const Singles zero(0.0);
  const Quads kept = rows(result.displacement, zero);
  const Quads force = rows(result.force, result.damping);
  const Quads back =
      rows({zero - result.force.x, zero - result.force.y, zero - result.force.z}, result.damping);
  const Quads torque_i = rows(result.torque_i, zero), torque_j = rows(result.torque_j, zero);
  const auto store = [&](int lane, __m128 memory, __m256 on_i, __m256 on_j) {
    if (task.advance)
      store_three(task.displacement + 3 * static_cast<std::size_t>(entry[lane]),
                  Pack(Pack::Values(_mm256_cvtps_pd(memory))));
    add(task.rows->single_load[i[lane]], on_i);
    add(task.rows->single_load[j[lane]], on_j);
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

/// Copies what the contacts need side by side.
void pack_single(const Task& task)
{
  const Balls& balls = task.balls;
  const Rows rows = *task.rows;
  for_each_ball(balls.all, [&](int i, const auto& vector) {
    SingleMotion& motion = rows.single_motion[i];
    put(&rows.place[i].x, with_fourth(vector(balls.position[i]), Pack(balls.radius[i])));
    _mm_store_ps(motion.velocity,
                 single(with_fourth(vector(balls.velocity[i]), Pack(balls.mass[i]))));
    _mm_store_ps(motion.spin,
                 single(with_fourth(vector(balls.spin[i]), Pack(damping_share(task, i)))));
  });
}

/// Adds the loads of the owned balls to their forces, and clears them for the next step.
void unload_single(const Task& task)
{
  SingleLoad* const load = task.rows->single_load;
  for (int i = 0; i < task.balls.owned; ++i) {
    for (int d = 0; d < 3; ++d) task.force[i][d] += load[i].force[d];
    for (int d = 0; d < 3; ++d) task.torque[i][d] += load[i].torque[d];
    if (task.terms.limited_damping && task.advance) task.damping[i] = load[i].damping;
    load[i] = SingleLoad{};
  }
}

}  // namespace

void evaluate_mixed(const Task& task)
{
  pack_single(task);
  evaluate_list<Singles, lanes>(
      task,
      [&](int entry) {
        fetch_ahead(task, entry, task.rows->single_motion, task.rows->single_load);
      },
      [&](const int* entry, int count, const Law& law) { evaluate_pack(task, entry, count, law); });
  unload_single(task);
}

}  // namespace millscale::pairs::MILLSCALE_LEVEL
