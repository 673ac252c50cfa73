#pragma once

// Finds the contacts of the pair list in double precision, for the kernels of x86-64-v3 and v4;
// MILLSCALE_LEVEL is v3 or v4. All functions here are local to the object file and call no library.
// A function shared between object files could be linked from this one, and would then run on a
// machine that lacks its instructions.
#include <immintrin.h>

#include "core/contact/damping_limit.h"
#include "core/kernels/levels.h"

namespace millscale::kernels::MILLSCALE_LEVEL {
namespace {

constexpr int width = 4;  ///< entries examined together

/// Four doubles: one number of each of four contacts, or the components of one vector and a fourth
/// number. The compiler's vector type with the functions that `contact::contact_force` needs.
struct Pack {
  typedef double Values __attribute__((vector_size(32)));
  typedef long long Mask __attribute__((vector_size(32)));

  Values values;

  Pack() = default;
  explicit Pack(double all) : values(Values{} + all) {}
  explicit Pack(Values v) : values(v) {}

  friend Pack operator+(Pack a, Pack b) { return Pack(a.values + b.values); }
  friend Pack operator-(Pack a, Pack b) { return Pack(a.values - b.values); }
  friend Pack operator*(Pack a, Pack b) { return Pack(a.values * b.values); }
  friend Pack operator/(Pack a, Pack b) { return Pack(a.values / b.values); }
  friend Mask operator>(Pack a, Pack b) { return a.values > b.values; }
  friend Pack choose(Mask condition, Pack yes, Pack no)
  {
    return Pack(condition ? yes.values : no.values);
  }
  friend Pack sqrt(Pack a)
  {
    Pack root;
    for (int lane = 0; lane < width; ++lane) root.values[lane] = __builtin_sqrt(a.values[lane]);
    return root;
  }
  friend Pack abs(Pack a)
  {
    Pack size;
    for (int lane = 0; lane < width; ++lane) size.values[lane] = __builtin_fabs(a.values[lane]);
    return size;
  }
};

typedef int Ints __attribute__((vector_size(16)));

template <int a, int b, int c, int d>
inline Pack shuffled(Pack first, Pack second)
{
  return Pack(__builtin_shuffle(first.values, second.values, Pack::Mask{a, b, c, d}));
}

/// The first three numbers at an address, and 0.
inline Pack three(const double* numbers)
{
  return Pack(Pack::Values(_mm256_maskload_pd(numbers, _mm256_setr_epi64x(-1, -1, -1, 0))));
}

inline Pack four(const double* numbers)
{
  return Pack(Pack::Values(_mm256_loadu_pd(numbers)));
}

/// Call work(i, read) for each particle; read(vector) loads three components and a fourth number to
/// ignore. Only the last particle's vectors need a masked load, which is slow on some machines.
template <class Work>
inline void for_each_particle(int count, const Work& work)
{
  for (int i = 0; i + 1 < count; ++i) work(i, [](const double* vector) { return four(vector); });
  if (count > 0) work(count - 1, [](const double* vector) { return three(vector); });
}

/// Return the first three numbers of `first` and the fourth of `other`.
inline Pack with_fourth(Pack first, Pack other)
{
  return Pack(Pack::Values(_mm256_blend_pd(__m256d(first.values), __m256d(other.values), 8)));
}

/// Store three numbers without a masked store, which is slow on some machines.
inline void store_three(double* to, Pack numbers)
{
  _mm_storeu_pd(to, _mm256_castpd256_pd128(__m256d(numbers.values)));
  _mm_store_sd(to + 2, _mm256_extractf128_pd(__m256d(numbers.values), 1));
}

inline void put(double* to, Pack numbers)
{
  _mm256_store_pd(to, __m256d(numbers.values));
}

constexpr int most_lanes = 8;

/// Entries of the list that are contacts. The rows of the second block are prefetched while the
/// first block is evaluated.
struct Found {
  static constexpr int block = 8;
  int entry[2 * block + most_lanes + width];
  int count = 0;
};

/// Return a bit for each lane that is true.
inline int bits(Pack::Mask mask)
{
  return _mm256_movemask_pd(_mm256_castsi256_pd(__m256i(mask)));
}

/// Return a bit for each flag that is 1.
inline int bits(Ints flags)
{
  return _mm_movemask_ps(_mm_castsi128_ps(__m128i(flags << 31)));
}

/// Return the sums over the lanes of four packs.
inline Pack sums(Pack a, Pack b, Pack c, Pack d)
{
  const Pack ab = shuffled<0, 4, 2, 6>(a, b) + shuffled<1, 5, 3, 7>(a, b);
  const Pack cd = shuffled<0, 4, 2, 6>(c, d) + shuffled<1, 5, 3, 7>(c, d);
  return shuffled<0, 1, 4, 5>(ab, cd) + shuffled<2, 3, 6, 7>(ab, cd);
}

/// For each combination of four bits: the lanes of its bits in ascending order, and each bit as an
/// int.
struct Chosen {
  Ints order, flag;
};
constexpr int chosen_lane(int bits, int rank)
{
  for (int lane = 0; lane < 4; ++lane)
    if ((bits >> lane & 1) && rank-- == 0) return lane;
  return 0;
}
#define MILLSCALE_CHOSEN(b)                                                       \
  {                                                                               \
    {chosen_lane(b, 0), chosen_lane(b, 1), chosen_lane(b, 2), chosen_lane(b, 3)}, \
    {                                                                             \
      (b) & 1, (b) >> 1 & 1, (b) >> 2 & 1, (b) >> 3 & 1                           \
    }                                                                             \
  }
constexpr Chosen chosen[16] = {
    MILLSCALE_CHOSEN(0),  MILLSCALE_CHOSEN(1),  MILLSCALE_CHOSEN(2),  MILLSCALE_CHOSEN(3),
    MILLSCALE_CHOSEN(4),  MILLSCALE_CHOSEN(5),  MILLSCALE_CHOSEN(6),  MILLSCALE_CHOSEN(7),
    MILLSCALE_CHOSEN(8),  MILLSCALE_CHOSEN(9),  MILLSCALE_CHOSEN(10), MILLSCALE_CHOSEN(11),
    MILLSCALE_CHOSEN(12), MILLSCALE_CHOSEN(13), MILLSCALE_CHOSEN(14), MILLSCALE_CHOSEN(15)};
#undef MILLSCALE_CHOSEN

template <class Vector>
inline Vector load(const void* from)
{
  Vector v;
  __builtin_memcpy(&v, from, sizeof v);
  return v;
}

inline void store(int* to, Ints numbers)
{
  __builtin_memcpy(to, &numbers, sizeof numbers);
}

/// Return x, y, z and the negated radius. The difference to another particle's row then has minus
/// the sum of the radii as its fourth number.
inline Pack negated_fourth(Pack numbers)
{
  const Pack::Mask sign = {0, 0, 0, -0x7fffffffffffffff - 1};
  return Pack(Pack::Values(Pack::Mask(numbers.values) ^ sign));
}

/// Return, for four pairs, the squared separation less the square of the sum of the radii [m^2].
template <class I, class J>
inline Pack gap_of_squares(const PositionRow* row, const I& i, const J& j)
{
  Pack square[width];
  for (int k = 0; k < width; ++k) {
    const Pack difference = negated_fourth(four(&row[i(k)].x)) - four(&row[j(k)].x);
    square[k] = difference * negated_fourth(difference);
  }
  return sums(square[0], square[1], square[2], square[3]);
}

/// Return a bit for each of the four entries whose particles overlap.
inline int overlapping(const Task& task, int entry)
{
  const Pack gap = gap_of_squares(
      task.rows->position, [&](int k) { return task.pairs.own[entry + k]; },
      [&](int k) { return task.pairs.other[entry + k]; });
  return bits(gap.values < Pack::Values{});
}

/// Clear the history of contacts that begin. That of pairs not in contact is never read.
inline void begin_history(const Task& task, int entry, int begun)
{
  for (int lane = 0; lane < width; ++lane)
    if (begun >> lane & 1)
      for (int d = 0; d < 3; ++d) task.pairs.displacement[3 * (entry + lane) + d] = 0.0;
}

/// Find the contacts among four entries, of which the first `count` belong to the list.
inline void find(const Task& task, int entry, int count, Found& found)
{
  constexpr int ahead = neighbor::spare_entries - width;
  for (int k = 0; k < width; ++k)
    __builtin_prefetch(task.rows->position + task.pairs.other[entry + ahead + k]);
  const int all = overlapping(task, entry);
  const int now = count < width ? all & ((1 << count) - 1) : all;
  const Ints before = load<Ints>(task.pairs.touching + entry);
  Ints kept = chosen[now].flag;
  if (!task.step.reset_on_separation) kept |= before;
  const int begun = now & ~bits(before);
  if (begun != 0) begin_history(task, entry, begun);
  store(task.pairs.touching + entry, kept);
  store(found.entry + found.count, entry + chosen[now].order);
  found.count += __builtin_popcount(now);
}

/// Return the laws of the contacts as a pack.
template <class Number, int lanes>
inline contact::ContactLaw<Number> gather_law(const Task& task, const int* entry)
{
  contact::ContactLaw<Number> all;
  for (int lane = 0; lane < lanes; ++lane) {
    const int a = task.particles.type[task.pairs.own[entry[lane]]] - 1;
    const int b = task.particles.type[task.pairs.other[entry[lane]]] - 1;
    const contact::ContactLaw<double>& law = task.laws.of_types[a * task.laws.types + b];
    all.normal_stiffness.values[lane] = law.normal_stiffness;
    all.tangential_stiffness.values[lane] = law.tangential_stiffness;
    all.normal_damping.values[lane] = law.normal_damping;
    all.tangential_damping.values[lane] = law.tangential_damping;
    all.sliding.values[lane] = law.sliding;
    all.rolling.values[lane] = law.rolling;
  }
  return all;
}

template <class Number>
inline contact::ContactLaw<Number> same_law(const contact::ContactLaw<double>& law)
{
  return {Number(law.normal_stiffness), Number(law.tangential_stiffness),
          Number(law.normal_damping),   Number(law.tangential_damping),
          Number(law.sliding),          Number(law.rolling)};
}

/// Return a ball's share in the divisor of its contacts' damping [-], 0 if damping is not limited.
inline double damping_share(const Task& task, int i)
{
  if (!task.terms.limited_damping) return 0.0;
  return contact::damping_share(task.sums.damping[i], task.particles.mass[i], task.step.dt);
}

/// Prefetch the scattered rows and the history of a contact.
template <class Velocity, class Force>
inline void prefetch_contact(const Task& task, int entry, const Velocity* velocity,
                             const Force* force)
{
  const int j = task.pairs.other[entry];
  const double* displacement = task.pairs.displacement + 3 * static_cast<std::size_t>(entry);
  __builtin_prefetch(velocity + j);
  __builtin_prefetch(force + j, 1);
  __builtin_prefetch(displacement, 1);
  __builtin_prefetch(displacement + 2, 1);
}

/// Evaluate all contacts of the list, `lanes` at a time. prefetch(entry) prefetches a contact.
/// forces(entries, count, law) evaluates `count` contacts; the entries beyond `count`, in the last
/// pack, repeat one of them.
template <class Number, int lanes, class Prefetch, class Forces>
inline void evaluate_list(const Task& task, const Prefetch& prefetch, const Forces& forces)
{
  constexpr int block = Found::block;
  Found found;
  auto law = same_law<Number>(
      task.laws.of_types[task.laws.only_type > 0 ? (task.laws.only_type - 1) * (task.laws.types + 1)
                                                 : 0]);
  const auto evaluate = [&](const int* entry, int count) {
    if (task.laws.only_type == 0) law = gather_law<Number, lanes>(task, entry);
    forces(entry, count, law);
  };
  for (int entry = 0; entry < task.pairs.entries; entry += width) {
    find(task, entry, task.pairs.entries - entry, found);
    if (found.count < 2 * block) continue;
    for (int k = 0; k < block; k += lanes) {  // alternating: few prefetches are in flight
      for (int lane = 0; lane < lanes; ++lane) prefetch(found.entry[block + k + lane]);
      evaluate(found.entry + k, lanes);
    }
    found.count -= block;
    for (int k = 0; k < block + width; ++k) found.entry[k] = found.entry[block + k];
  }
  for (int lane = 0; lane < lanes; ++lane) {
    const int k = found.count + lane;
    found.entry[k] = found.entry[k / lanes * lanes];
  }
  for (int k = 0; k < found.count; k += lanes)
    evaluate(found.entry + k, found.count - k < lanes ? found.count - k : lanes);
}

}  // namespace
}  // namespace millscale::kernels::MILLSCALE_LEVEL
