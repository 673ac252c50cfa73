// Compiled for x86-64-v3 and v4, MILLSCALE_LEVEL being v3 or v4. All of it but the
// entry points is local to the object, and it calls no library: a function shared with other
// objects could be linked from here and run on a machine that lacks its instructions.
#include <immintrin.h>

#include "pairs/kernel.h"

namespace millscale::pairs::MILLSCALE_LEVEL {
namespace {

constexpr int width = 4;

/// Four doubles: the same number of four contacts, or three components of one ball and a spare.
/// The compiler's vector type with the few functions `contact::ball_force` asks for.
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

using Vectors = contact::Triple<Pack>;
typedef int Ints __attribute__((vector_size(16)));

template <int a, int b, int c, int d>
inline Pack shuffled(Pack first, Pack second)
{
  return Pack(__builtin_shuffle(first.values, second.values, Pack::Mask{a, b, c, d}));
}

/// x, y, z, 0 of one ball.
inline Pack row(const double* vector)
{
  return Pack(Pack::Values(_mm256_maskload_pd(vector, _mm256_setr_epi64x(-1, -1, -1, 0))));
}

/// x of all four rows, y of all, z of all.
inline Vectors columns(Pack a, Pack b, Pack c, Pack d)
{
  const Pack low_ab = shuffled<0, 4, 2, 6>(a, b), low_cd = shuffled<0, 4, 2, 6>(c, d);
  const Pack high_ab = shuffled<1, 5, 3, 7>(a, b), high_cd = shuffled<1, 5, 3, 7>(c, d);
  return {shuffled<0, 1, 4, 5>(low_ab, low_cd), shuffled<0, 1, 4, 5>(high_ab, high_cd),
          shuffled<2, 3, 6, 7>(low_ab, low_cd)};
}

template <class Ball>
inline Vectors gather(const double (*field)[3], const Ball& ball)
{
  return columns(row(field[ball(0)]), row(field[ball(1)]), row(field[ball(2)]),
                 row(field[ball(3)]));
}

template <class Value>
inline Pack gather(const Value& value)
{
  return Pack(Pack::Values{value(0), value(1), value(2), value(3)});
}

/// Contacts found: entries of the list and the balls i they belong to.
struct Found {
  static constexpr int block = 16 * width;
  int entry[block + width], i[block + width];
  int count = 0;
};

using Law = contact::BallLaw<Pack>;

inline Law gather_law(const Task& task, const int* entry, const int* i)
{
  const contact::BallLaw<double>* law[width];
  for (int lane = 0; lane < width; ++lane)
    law[lane] = &task.law[(task.balls.type[i[lane]] - 1) * task.types +
                          task.balls.type[task.other[entry[lane]]] - 1];
  return {gather([&](int lane) { return law[lane]->normal_stiffness; }),
          gather([&](int lane) { return law[lane]->tangential_stiffness; }),
          gather([&](int lane) { return law[lane]->normal_damping; }),
          gather([&](int lane) { return law[lane]->tangential_damping; }),
          gather([&](int lane) { return law[lane]->sliding; }),
          gather([&](int lane) { return law[lane]->rolling; })};
}

inline Law same_law(const contact::BallLaw<double>& law)
{
  return {Pack(law.normal_stiffness), Pack(law.tangential_stiffness),
          Pack(law.normal_damping),   Pack(law.tangential_damping),
          Pack(law.sliding),          Pack(law.rolling)};
}

/// Adds, or subtracts, x, y, z of a row to those of a ball.
template <bool adds>
inline void accumulate(double* sum, Pack part)
{
  for (int d = 0; d < 3; ++d) sum[d] = adds ? sum[d] + part.values[d] : sum[d] - part.values[d];
}

struct Rows {
  Pack of[width];
};

inline Rows rows(const Vectors& v)
{
  const Pack zero(0.0);
  const Pack low_xy = shuffled<0, 4, 2, 6>(v.x, v.y), low_z = shuffled<0, 4, 2, 6>(v.z, zero);
  const Pack high_xy = shuffled<1, 5, 3, 7>(v.x, v.y), high_z = shuffled<1, 5, 3, 7>(v.z, zero);
  return {{shuffled<0, 1, 4, 5>(low_xy, low_z), shuffled<0, 1, 4, 5>(high_xy, high_z),
           shuffled<2, 3, 6, 7>(low_xy, low_z), shuffled<2, 3, 6, 7>(high_xy, high_z)}};
}

/// Forces of `count` <= width contacts; the lanes beyond `count` repeat one of them.
[[gnu::flatten, gnu::noinline]] void evaluate_pack(const Task& task, const int* entry,
                                                   const int* own, int count, const Law& law)
{
  const Balls& balls = task.balls;
  int other[width];
  for (int lane = 0; lane < width; ++lane) other[lane] = task.other[entry[lane]];
  const auto i = [&](int lane) { return own[lane]; };
  const auto j = [&](int lane) { return other[lane]; };
  const auto memory = reinterpret_cast<double(*)[3]>(task.displacement);

  contact::BallTouch<Pack> touch;
  touch.apart = gather(balls.position, i) - gather(balls.position, j);
  touch.square = dot(touch.apart, touch.apart);
  touch.radius_i = gather([&](int lane) { return balls.radius[i(lane)]; });
  touch.radius_j = gather([&](int lane) { return balls.radius[j(lane)]; });
  touch.mass_i = gather([&](int lane) { return balls.mass[i(lane)]; });
  touch.mass_j = gather([&](int lane) { return balls.mass[j(lane)]; });
  touch.velocity = gather(balls.velocity, i) - gather(balls.velocity, j);
  touch.spin_i = gather(balls.spin, i);
  touch.spin_j = gather(balls.spin, j);
  touch.displacement = gather(memory, [&](int lane) { return entry[lane]; });

  const auto result = contact::ball_force(touch, law, task.terms, task.dt, task.advance);

  const Rows displacement = rows(result.displacement), force = rows(result.force);
  const Rows torque_i = rows(result.torque_i), torque_j = rows(result.torque_j);
  for (int lane = 0; lane < count; ++lane) {
    for (int d = 0; d < 3; ++d) memory[entry[lane]][d] = displacement.of[lane].values[d];
    accumulate<true>(task.force[i(lane)], force.of[lane]);
    accumulate<true>(task.torque[i(lane)], torque_i.of[lane]);
    if (j(lane) < balls.owned) {
      accumulate<false>(task.force[j(lane)], force.of[lane]);
      accumulate<true>(task.torque[j(lane)], torque_j.of[lane]);
    }
  }
}

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

/// Bits of the four balls that meet a ball at the centre. Both have their radius as fourth number,
/// so that the square of the distance less that of the radii is a sum of squares, one negative.
template <class Ball>
inline int meet(Pack centre, const Ball& ball)
{
  Pack square[width];
  for (int k = 0; k < width; ++k) {
    const Pack other = ball(k);
    const Pack apart = choose(Pack::Mask{0, 0, 0, -1}, centre + other, centre - other);
    square[k] = apart * apart * Pack(Pack::Values{1.0, 1.0, 1.0, -1.0});
  }
  return bits(sums(square[0], square[1], square[2], square[3]).values < Pack::Values{});
}

/// x, y, z, radius of a ball.
inline Pack position_and_radius(const Balls& balls, int i)
{
  return choose(Pack::Mask{0, 0, 0, -1}, Pack(balls.radius[i]), row(balls.position[i]));
}

inline void forget(const Task& task, int entry, int parted)
{
  for (int lane = 0; lane < width; ++lane)
    if (parted >> lane & 1)
      for (int d = 0; d < 3; ++d) task.displacement[3 * (entry + lane) + d] = 0.0;
}

/// Finds the contacts of ball i among four entries, of which the first `count` are its own.
inline void find(const Task& task, int i, Pack centre, int entry, int count, Found& found)
{
  __builtin_prefetch(task.displacement + 3 * entry);
  __builtin_prefetch(task.displacement + 3 * entry + 8);
  const int all =
      meet(centre, [&](int k) { return position_and_radius(task.balls, task.other[entry + k]); });
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
  store(found.i + found.count, i + Ints{});
  found.count += __builtin_popcount(now);
}

/// Evaluates the contacts found, all but a last incomplete pack, which `last` makes complete.
inline void evaluate_found(const Task& task, Law& law, Found& found, bool last)
{
  int rest = found.count % width;
  const int full = found.count - rest;
  for (int lane = full + rest; last && rest > 0 && lane < full + width; ++lane) {
    found.entry[lane] = found.entry[full];
    found.i[lane] = found.i[full];
  }
  for (int k = 0; k < (last ? found.count : full); k += width) {
    if (task.only_type == 0) law = gather_law(task, found.entry + k, found.i + k);
    evaluate_pack(task, found.entry + k, found.i + k, k < full ? width : rest, law);
  }
  for (int k = 0; k < rest; ++k) {
    found.entry[k] = found.entry[full + k];
    found.i[k] = found.i[full + k];
  }
  found.count = rest;
}

}  // namespace

int* list_partners(const Candidates& candidates, int i, Centre ball, int* out)
{
  const auto four = [](const double* numbers) { return Pack(load<Pack::Values>(numbers)); };
  for (int k = 0; k < candidates.count; k += width) {
    const Pack x = Pack(ball.x) - four(candidates.x + k), y = Pack(ball.y) - four(candidates.y + k);
    const Pack z = Pack(ball.z) - four(candidates.z + k);
    const Pack radii = Pack(ball.radius) + four(candidates.radius + k);
    const int near = bits(radii * radii > x * x + y * y + z * z);
    const Ints index = load<Ints>(candidates.index + k);
    const int left = candidates.count - k, own = left < width ? (1 << left) - 1 : 15;
    const int later = near & own & bits(Ints(index > i) & 1);
    store(out, __builtin_shuffle(index, chosen[later].order));
    out += __builtin_popcount(later);
  }
  return out;
}

void evaluate(const Task& task)
{
  Found found;
  Law law = same_law(task.law[task.only_type > 0 ? (task.only_type - 1) * (task.types + 1) : 0]);
  for (int i = 0; i < task.balls.owned; ++i) {
    const Pack centre = position_and_radius(task.balls, i);
    const int end = task.first[i] + task.partners[i];
    for (int entry = task.first[i]; entry < end; entry += width) {
      find(task, i, centre, entry, end - entry, found);
      if (found.count >= Found::block) evaluate_found(task, law, found, false);
    }
  }
  evaluate_found(task, law, found, true);
}

}  // namespace millscale::pairs::MILLSCALE_LEVEL
