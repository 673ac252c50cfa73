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

/// The first three numbers at an address, and 0.
inline Pack three(const double* numbers)
{
  return Pack(Pack::Values(_mm256_maskload_pd(numbers, _mm256_setr_epi64x(-1, -1, -1, 0))));
}

inline Pack four(const double* numbers)
{
  return Pack(Pack::Values(_mm256_loadu_pd(numbers)));
}

/// The first three numbers of one, the fourth of the other.
inline Pack with_fourth(Pack first, Pack other)
{
  return Pack(Pack::Values(_mm256_blend_pd(__m256d(first.values), __m256d(other.values), 8)));
}

struct Columns {
  Vectors xyz;
  Pack fourth;
};

/// x of all four rows, y of all, z of all, the fourth of all.
template <class Row>
inline Columns columns(const Row& row)
{
  const Pack a = row(0), b = row(1), c = row(2), d = row(3);
  const Pack low_ab = shuffled<0, 4, 2, 6>(a, b), low_cd = shuffled<0, 4, 2, 6>(c, d);
  const Pack high_ab = shuffled<1, 5, 3, 7>(a, b), high_cd = shuffled<1, 5, 3, 7>(c, d);
  return {{shuffled<0, 1, 4, 5>(low_ab, low_cd), shuffled<0, 1, 4, 5>(high_ab, high_cd),
           shuffled<2, 3, 6, 7>(low_ab, low_cd)},
          shuffled<2, 3, 6, 7>(high_ab, high_cd)};
}

template <class Value>
inline Pack gather(const Value& value)
{
  return Pack(Pack::Values{value(0), value(1), value(2), value(3)});
}

/// Contacts found: entries of the list.
struct Found {
  static constexpr int block = 16 * width;
  int entry[block + width];
  int count = 0;
};

using Law = contact::BallLaw<Pack>;

inline Law gather_law(const Task& task, const int* entry)
{
  const contact::BallLaw<double>* law[width];
  for (int lane = 0; lane < width; ++lane)
    law[lane] = &task.law[(task.balls.type[task.own[entry[lane]]] - 1) * task.types +
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

struct FourRows {
  Pack of[width];
};

inline FourRows rows(const Vectors& v, Pack fourth)
{
  const Pack low_xy = shuffled<0, 4, 2, 6>(v.x, v.y), low_z = shuffled<0, 4, 2, 6>(v.z, fourth);
  const Pack high_xy = shuffled<1, 5, 3, 7>(v.x, v.y), high_z = shuffled<1, 5, 3, 7>(v.z, fourth);
  return {{shuffled<0, 1, 4, 5>(low_xy, low_z), shuffled<0, 1, 4, 5>(high_xy, high_z),
           shuffled<2, 3, 6, 7>(low_xy, low_z), shuffled<2, 3, 6, 7>(high_xy, high_z)}};
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

inline void add(double* sum, Pack part)
{
  put(sum, four(sum) + part);
}

inline void subtract(double* sum, Pack part)
{
  put(sum, four(sum) - part);
}

/// Forces of `count` <= width contacts; the lanes beyond `count` repeat one of them.
[[gnu::flatten, gnu::noinline]] void evaluate_pack(const Task& task, const int* entry, int count,
                                                   const Law& law)
{
  const Rows& rows_of = *task.rows;
  int i[width], j[width];
  for (int lane = 0; lane < width; ++lane) i[lane] = task.own[entry[lane]];
  for (int lane = 0; lane < width; ++lane) j[lane] = task.other[entry[lane]];
  const auto place = [&](int ball) { return four(&rows_of.place[ball].x); };
  const auto velocity = [&](int ball) { return four(rows_of.motion[ball].velocity); };
  const auto spin = [&](int ball) { return four(rows_of.motion[ball].spin); };
  const auto memory = [&](int lane) {
    return task.displacement + 3 * static_cast<std::size_t>(entry[lane]);
  };

  // The fourth columns carry one number of each contact beside the vectors.
  const Columns apart = columns(
      [&](int lane) { return with_fourth(place(i[lane]) - place(j[lane]), place(j[lane])); });
  const Columns speed = columns([&](int lane) {
    return with_fourth(velocity(i[lane]) - velocity(j[lane]), velocity(i[lane]));
  });
  const Columns spin_i =
      columns([&](int lane) { return with_fourth(spin(i[lane]), velocity(j[lane])); });
  const Columns spin_j =
      columns([&](int lane) { return spin(j[lane]) + with_fourth(Pack(0.0), spin(i[lane])); });
  const Columns displacement =
      columns([&](int lane) { return with_fourth(three(memory(lane)), place(i[lane])); });
  contact::BallTouch<Pack> touch;
  touch.apart = apart.xyz;
  touch.square = dot(touch.apart, touch.apart);
  touch.radius_i = displacement.fourth;
  touch.radius_j = apart.fourth;
  touch.mass_i = speed.fourth;
  touch.mass_j = spin_i.fourth;
  touch.velocity = speed.xyz;
  touch.spin_i = spin_i.xyz;
  touch.spin_j = spin_j.xyz;
  touch.displacement = displacement.xyz;
  touch.held = spin_j.fourth;

  const auto result = contact::ball_force(touch, law, task.terms, task.dt, task.advance);

  const FourRows kept = rows(result.displacement, Pack(0.0));
  const FourRows force = rows(result.force, Pack(0.0));
  const FourRows torque_i = rows(result.torque_i, result.damping);
  const FourRows torque_j = rows(result.torque_j, result.damping);
  for (int lane = 0; lane < count; ++lane) {
    store_three(memory(lane), kept.of[lane]);
    Load &on_i = rows_of.load[i[lane]], &on_j = rows_of.load[j[lane]];
    add(on_i.force, force.of[lane]);
    add(on_i.torque, torque_i.of[lane]);
    subtract(on_j.force, force.of[lane]);
    add(on_j.torque, torque_j.of[lane]);
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

/// x, y, z, radius with another sign: the difference to another ball's then holds minus the sum of
/// the radii, so that the square of the distance less that of the radii is a sum of squares, one
/// negative.
inline Pack negated_fourth(Pack numbers)
{
  const Pack::Mask sign = {0, 0, 0, -0x7fffffffffffffff - 1};
  return Pack(Pack::Values(Pack::Mask(numbers.values) ^ sign));
}

/// Bits of the four entries whose balls meet.
inline int meet(const Task& task, int entry)
{
  const Place* place = task.rows->place;
  Pack square[width];
  for (int k = 0; k < width; ++k) {
    const Pack apart =
        negated_fourth(four(&place[task.own[entry + k]].x)) - four(&place[task.other[entry + k]].x);
    square[k] = apart * negated_fourth(apart);
  }
  return bits(sums(square[0], square[1], square[2], square[3]).values < Pack::Values{});
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

/// What a contact needs lies all over the memory; asked for early, it comes while others are
/// evaluated.
inline void fetch_ahead(const Task& task, int entry)
{
  const int j = task.other[entry];
  const double* memory = task.displacement + 3 * static_cast<std::size_t>(entry);
  __builtin_prefetch(task.rows->motion + j);
  __builtin_prefetch(task.rows->load + j, 1);
  __builtin_prefetch(memory, 1);
  __builtin_prefetch(memory + 2, 1);
}

/// Evaluates the contacts found, all but a last incomplete pack, which `last` makes complete.
inline void evaluate_found(const Task& task, Law& law, Found& found, bool last)
{
  const int rest = found.count % width, full = found.count - rest;
  for (int lane = full + rest; last && rest > 0 && lane < full + width; ++lane)
    found.entry[lane] = found.entry[full];
  for (int k = 0; k < full; ++k) fetch_ahead(task, found.entry[k]);
  for (int k = 0; k < (last ? found.count : full); k += width) {
    if (task.only_type == 0) law = gather_law(task, found.entry + k);
    evaluate_pack(task, found.entry + k, k < full ? width : rest, law);
  }
  for (int k = 0; k < rest; ++k) found.entry[k] = found.entry[full + k];
  found.count = rest;
}

/// Copies what the contacts need side by side.
void pack(const Task& task)
{
  const Balls& balls = task.balls;
  const Rows rows = *task.rows;
  for (int i = 0; i < balls.all; ++i) {
    const double held =
        task.terms.bounded ? contact::damping_held(task.damping[i], balls.mass[i], task.dt) : 0.0;
    put(&rows.place[i].x, with_fourth(three(balls.position[i]), Pack(balls.radius[i])));
    put(rows.motion[i].velocity, with_fourth(three(balls.velocity[i]), Pack(balls.mass[i])));
    put(rows.motion[i].spin, with_fourth(three(balls.spin[i]), Pack(held)));
  }
}

/// Adds the loads of the owned balls to their forces, and clears them for the next step.
void unload(const Task& task)
{
  Load* const load = task.rows->load;
  for (int i = 0; i < task.balls.owned; ++i) {
    for (int d = 0; d < 3; ++d) task.force[i][d] += load[i].force[d];
    for (int d = 0; d < 3; ++d) task.torque[i][d] += load[i].torque[d];
    if (task.terms.bounded && task.advance) task.damping[i] = load[i].damping;
    put(load[i].force, Pack(0.0));
    put(load[i].torque, Pack(0.0));
  }
}

}  // namespace

int* list_partners(const Candidates& candidates, int i, Centre ball, int* out)
{
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
  pack(task);
  Found found;
  Law law = same_law(task.law[task.only_type > 0 ? (task.only_type - 1) * (task.types + 1) : 0]);
  for (int entry = 0; entry < task.entries; entry += width) {
    find(task, entry, task.entries - entry, found);
    if (found.count >= Found::block) evaluate_found(task, law, found, false);
  }
  evaluate_found(task, law, found, true);
  unload(task);
}

}  // namespace millscale::pairs::MILLSCALE_LEVEL
