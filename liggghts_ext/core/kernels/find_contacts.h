#pragma once

// Of the kernels for x86-64-v3 and v4, MILLSCALE_LEVEL being v3 or v4: which entries of the list
// are contacts, in double precision. All of it is local to the object that includes it, and calls
// no library: a function shared with other objects could be linked from here and run on a machine
// that lacks its instructions.
#include <immintrin.h>

#include "core/kernels/kernel.h"

namespace millscale::pairs::MILLSCALE_LEVEL {
namespace {

constexpr int width = 4;  ///< entries looked at together

/// Four doubles: the same number of four contacts, or three components of one ball and a spare.
/// The compiler's vector type with the few functions `contact::contact_force` asks for.
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

/// Calls `work` with each ball and what reads its vectors: three numbers and one to be ignored. Of
/// the last ball there is no fourth, and masked loads are slow on some machines.
template <class Work>
inline void for_each_ball(int balls, const Work& work)
{
  for (int i = 0; i + 1 < balls; ++i) work(i, [](const double* vector) { return four(vector); });
  if (balls > 0) work(balls - 1, [](const double* vector) { return three(vector); });
}

/// The first three numbers of one, the fourth of the other.
inline Pack with_fourth(Pack first, Pack other)
{
  return Pack(Pack::Values(_mm256_blend_pd(__m256d(first.values), __m256d(other.values), 8)));
}

/// Masked stores are slow on some machines.
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

/// Contacts found: entries of the list. What the second block needs of the memory is on its way
/// while the first is evaluated.
struct Found {
  static constexpr int block = 8;
  int entry[2 * block + most_lanes + width];
  int count = 0;
};

/// Bits of the lanes that hold.
inline int bits(Pack::Mask mask)
{
  return _mm256_movemask_pd(_mm256_castsi256_pd(__m256i(mask)));
}

/// Bits of the flags that are 1.
inline int bits(Ints flags)
{
  return _mm_movemask_ps(_mm_castsi128_ps(__m128i(flags << 31)));
}

/// Sums over the lanes of four packs.
inline Pack sums(Pack a, Pack b, Pack c, Pack d)
{
  const Pack ab = shuffled<0, 4, 2, 6>(a, b) + shuffled<1, 5, 3, 7>(a, b);
  const Pack cd = shuffled<0, 4, 2, 6>(c, d) + shuffled<1, 5, 3, 7>(c, d);
  return shuffled<0, 1, 4, 5>(ab, cd) + shuffled<2, 3, 6, 7>(ab, cd);
}

/// For four bits: which lanes they are, first ones first; and one int for each.
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

/// x, y, z, radius with another sign: the difference to another ball's then holds minus the sum of
/// the radii, so that the square of the distance less that of the radii is a sum of squares, one
/// negative.
inline Pack negated_fourth(Pack numbers)
{
  const Pack::Mask sign = {0, 0, 0, -0x7fffffffffffffff - 1};
  return Pack(Pack::Values(Pack::Mask(numbers.values) ^ sign));
}

/// Squares of the distances of four pairs less those of the sums of their radii [m^2].
template <class I, class J>
inline Pack beyond_touch(const Place* place, const I& i, const J& j)
{
  Pack square[width];
  for (int k = 0; k < width; ++k) {
    const Pack apart = negated_fourth(four(&place[i(k)].x)) - four(&place[j(k)].x);
    square[k] = apart * negated_fourth(apart);
  }
  return sums(square[0], square[1], square[2], square[3]);
}

/// Bits of the four entries whose balls meet.
inline int meet(const Task& task, int entry)
{
  const Pack beyond = beyond_touch(
      task.rows->place, [&](int k) { return task.own[entry + k]; },
      [&](int k) { return task.other[entry + k]; });
  return bits(beyond.values < Pack::Values{});
}

inline void forget(const Task& task, int entry, int parted)
{
  for (int lane = 0; lane < width; ++lane)
    if (parted >> lane & 1)
      for (int d = 0; d < 3; ++d) task.displacement[3 * (entry + lane) + d] = 0.0;
}

/// Finds the contacts among four entries, of which the first `count` are of the list.
inline void find(const Task& task, int entry, int count, Found& found)
{
  constexpr int ahead = spare_entries - width;
  for (int k = 0; k < width; ++k)
    __builtin_prefetch(task.rows->place + task.other[entry + ahead + k]);
  const int all = meet(task, entry);
  const int now = count < width ? all & ((1 << count) - 1) : all;
  const Ints flags = chosen[now].flag;
  Ints kept = flags;
  const Ints before = load<Ints>(task.touching + entry);
  const int parted = bits(before) & ~now;
  if (parted != 0) {
    if (task.forget_apart)
      forget(task, entry, parted);
    else
      kept |= before;
  }
  store(task.touching + entry, kept);
  store(found.entry + found.count, entry + chosen[now].order);
  found.count += __builtin_popcount(now);
}

/// The laws of some contacts, as a pack.
template <class Number, int lanes>
inline contact::ContactLaw<Number> gather_law(const Task& task, const int* entry)
{
  contact::ContactLaw<Number> all;
  for (int lane = 0; lane < lanes; ++lane) {
    const int a = task.balls.type[task.own[entry[lane]]] - 1;
    const int b = task.balls.type[task.other[entry[lane]]] - 1;
    const contact::ContactLaw<double>& law = task.law[a * task.types + b];
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
  return contact::damping_share(task.damping[i], task.balls.mass[i], task.dt);
}

/// Prefetches the scattered rows and history of a contact.
template <class Motion, class Load>
inline void fetch_ahead(const Task& task, int entry, const Motion* motion, const Load* load)
{
  const int j = task.other[entry];
  const double* memory = task.displacement + 3 * static_cast<std::size_t>(entry);
  __builtin_prefetch(motion + j);
  __builtin_prefetch(load + j, 1);
  __builtin_prefetch(memory, 1);
  __builtin_prefetch(memory + 2, 1);
}

/// Evaluates all contacts of the list, `lanes` at a time. `fetch` prefetches what a
/// contact needs. `forces` gets entries, how many of them count, and their laws; the others, of the
/// last pack, repeat one that does.
template <class Number, int lanes, class Fetch, class Forces>
inline void evaluate_list(const Task& task, const Fetch& fetch, const Forces& forces)
{
  constexpr int block = Found::block;
  Found found;
  auto law =
      same_law<Number>(task.law[task.only_type > 0 ? (task.only_type - 1) * (task.types + 1) : 0]);
  const auto evaluate = [&](const int* entry, int count) {
    if (task.only_type == 0) law = gather_law<Number, lanes>(task, entry);
    forces(entry, count, law);
  };
  for (int entry = 0; entry < task.entries; entry += width) {
    find(task, entry, task.entries - entry, found);
    if (found.count < 2 * block) continue;
    for (int k = 0; k < block; k += lanes) {  // in turns: the memory takes few requests at once
      for (int lane = 0; lane < lanes; ++lane) fetch(found.entry[block + k + lane]);
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
}  // namespace millscale::pairs::MILLSCALE_LEVEL
