// One pass over the balls between two evaluations of the forces, see advance.h. Compiled for
// x86-64-v3 and v4, without fused multiply-add: the engine's loop must give the same bits.
#include "core/kernels/advance.h"

#include <immintrin.h>

#include "core/kernels/levels.h"

namespace millscale::kernels::MILLSCALE_LEVEL {
namespace {

typedef double Four __attribute__((vector_size(32)));
typedef long long FourBits __attribute__((vector_size(32)));
typedef float FourSingles __attribute__((vector_size(16)));

constexpr int group = 4;  ///< balls whose sums are evaluated together

template <class Vector, class Row>
inline Vector load(const Row* row)
{
  return *reinterpret_cast<const Vector*>(row);
}
template <class Vector, class Row>
inline void store(Row* row, Vector numbers)
{
  *reinterpret_cast<Vector*>(row) = numbers;
}

/// Return the numbers with 0 in the place of the fourth.
inline Four three(Four numbers)
{
  return Four(FourBits(numbers) & FourBits{-1, -1, -1, 0});
}

/// Return (a + b) + c of each of four vectors (a, b, c, 0).
inline Four sums(const Four* v)
{
  const Four ab = __builtin_shuffle(v[0], v[1], FourBits{0, 4, 2, 6}) +
                  __builtin_shuffle(v[0], v[1], FourBits{1, 5, 3, 7});
  const Four cd = __builtin_shuffle(v[2], v[3], FourBits{0, 4, 2, 6}) +
                  __builtin_shuffle(v[2], v[3], FourBits{1, 5, 3, 7});
  return __builtin_shuffle(ab, cd, FourBits{0, 1, 4, 5}) +
         __builtin_shuffle(ab, cd, FourBits{2, 3, 6, 7});
}

/// Return the fourth number of each of four vectors.
inline Four fourths(const Four* v)
{
  const Four ab = __builtin_shuffle(v[0], v[1], FourBits{3, 7, 3, 7});
  const Four cd = __builtin_shuffle(v[2], v[3], FourBits{3, 7, 3, 7});
  return __builtin_shuffle(ab, cd, FourBits{0, 1, 4, 5});
}

/// Return a bit for each lane that is true.
inline int bits(FourBits mask)
{
  return _mm256_movemask_pd(__m256d(mask));
}

/// Force and torque on a ball: three components and, of the torque, the sum of the damping.
struct Load {
  Four force, torque;
};

/// Return what a row holds, and clear the row.
template <bool single>
inline Load take_load(const Rows& rows, int i)
{
  if constexpr (single) {
    SingleForceRow& row = rows.single_force[i];
    const Four force = __builtin_convertvector(load<FourSingles>(row.force), Four);
    const Four torque = __builtin_convertvector(load<FourSingles>(row.torque), Four);
    store(row.force, FourSingles{});
    store(row.torque, FourSingles{});
    return {force, __builtin_shuffle(torque, force, FourBits{0, 1, 2, 7})};
  } else {
    ForceRow& row = rows.force[i];
    const Load found{load<Four>(row.force), load<Four>(row.torque)};
    store(row.force, Four{});
    store(row.torque, Four{});
    return found;
  }
}

/// What the pass does besides, by the frequency of the steps.
enum class Besides { nothing, guard, guard_and_copy };

template <class Three>
inline void write(const Four& from, Three& to)
{
  for (int d = 0; d < 3; ++d) to[d] = from[d];
}

/// Return the marks of `count` balls, at most a group, in the bytes of a number.
[[gnu::always_inline]] inline unsigned load_marks(const signed char* marks, int count)
{
  unsigned four = 0;
  __builtin_memcpy(&four, marks, static_cast<unsigned>(count));
  return four;
}
[[gnu::always_inline]] inline void store_marks(signed char* to, unsigned four, int count)
{
  __builtin_memcpy(to, &four, static_cast<unsigned>(count));
}

/// Return four marks, `mark` where a bit is set.
inline unsigned spread(unsigned bits, signed char mark)
{
  const unsigned ones = (bits & 1) | (bits & 2) << 7 | (bits & 4) << 14 | (bits & 8) << 21;
  return ones * static_cast<unsigned>(mark);
}

template <bool single, bool limited, bool watched, Besides besides>
class Pass {
  static constexpr bool guarded = besides != Besides::nothing;
  static constexpr bool copied = besides == Besides::guard_and_copy;

 public:
  explicit Pass(const Advance& advance) : a(advance), wall(advance.wall_begin)
  {
    const Vector &g = a.gravity, &o = a.origin;
    gravity = Four{g[0], g[1], g[2], 0.0};
    dt = Four{a.dt, a.dt, a.dt, 0.0};
    origin = Four{o[0], o[1], o[2], 0.0};
    for (int d = 0; d < 3; ++d) {
      const Vector& c = a.turn_columns[d];
      column[d] = Four{c[0], c[1], c[2], 0.0};
    }
  }

  Advanced all()
  {
    int i = 0;
    for (; i + group <= a.balls; i += group) some(i, group);
    if (i < a.balls) some(i, a.balls - i);
    found.moved = bits(moved) != 0;
    found.left_skin = a.own_skins && bits(left) != 0;
    return found;
  }

 private:
  /// A ball at the end of the step.
  struct Ended {
    Load on;
    Four push, velocity;  ///< of half a step; at the end, with the mass
  };

  /// Squares of components and other numbers, of the balls of a group.
  struct Numbers {
    Four gone[group], relative[group], speed[group], pressure[group];
    Four with_skin[group], with_mass[group], with_damping[group];  ///< in the fourth place
  };

  /// End the step of a ball. k: its place in the group.
  [[gnu::always_inline]] Ended end(int i, int k, Numbers& numbers)
  {
    Load on = take_load<single>(a.rows, i);
    const Four before = load<Four>(a.rows.velocity[i].velocity);
    const Four weight = before[3] * gravity;
    if (a.gravity_first) on.force = on.force + weight;
    for (; wall != a.wall_end && wall->ball == i; ++wall) {
      on.force = on.force + load<Four>(wall->force);
      on.torque = on.torque + load<Four>(wall->torque);
    }
    if (!a.gravity_first) on.force = on.force + weight;
    const Four push = a.kick[i].linear * three(on.force);
    const Four velocity = before + push;
    if constexpr (limited || watched) numbers.with_mass[k] = before;
    if constexpr (limited) numbers.with_damping[k] = on.torque;
    if constexpr (guarded) {
      const Four v = three(velocity);
      numbers.speed[k] = v * v;
    }
    if constexpr (watched) {
      const Four by_contacts = three(on.force - weight);
      numbers.pressure[k] = by_contacts * by_contacts;
    }
    return {on, push, velocity};
  }

  /// Begin the next step of a ball.
  [[gnu::always_inline]] void begin(int i, int k, const Ended& ended, Numbers& numbers)
  {
    const Rows& rows = a.rows;
    VelocityRow& row = rows.velocity[i];
    const Four x = load<Four>(rows.position + i), spin = load<Four>(row.spin);
    const Four turn = a.kick[i].angular * three(ended.on.torque);
    if constexpr (copied) {
      write(x, a.copy->position[i]);
      write(ended.velocity, a.copy->velocity[i]);
      write(spin + turn, a.copy->spin[i]);
      write(ended.on.force, a.copy->force[i]);
      write(ended.on.torque, a.copy->torque[i]);
    }
    const Four half = ended.velocity + ended.push, half_spin = spin + turn + turn;
    store(row.velocity, half);
    store(row.spin, half_spin);
    if constexpr (single) {
      SingleVelocityRow& copy = rows.single_velocity[i];
      store(copy.velocity, __builtin_convertvector(half, FourSingles));
      store(copy.spin, __builtin_convertvector(half_spin, FourSingles));
    }
    const Four next = x + dt * half;
    store(rows.position + i, next);
    const Four begin = load<Four>(a.start + i);
    numbers.with_skin[k] = begin;
    const Four way = three(next - begin);
    numbers.gone[k] = way * way;
    const Four from = next - origin, held = begin - origin;
    const Four turned = held[0] * column[0] + held[1] * column[1] + held[2] * column[2];
    const Four apart = three(from - turned);
    numbers.relative[k] = apart * apart;
  }

  /// Advance `count` balls, at most a group.
  [[gnu::always_inline]] void some(int i, int count)
  {
    Numbers numbers;
    Ended ended[group]{};
    for (int k = count; k < group; ++k) {
      numbers.gone[k] = numbers.relative[k] = numbers.speed[k] = numbers.pressure[k] = Four{};
      numbers.with_skin[k] = numbers.with_mass[k] = numbers.with_damping[k] = Four{};
    }
#pragma GCC unroll 4
    for (int k = 0; k < group; ++k)
      if (k < count) ended[k] = end(i + k, k, numbers);
    if constexpr (guarded) guard(i, count, numbers, ended);
    if constexpr (watched) watch(i, count, numbers, ended);
#pragma GCC unroll 4
    for (int k = 0; k < group; ++k)
      if (k < count) begin(i + k, k, ended[k], numbers);
    if constexpr (limited) share_damping(i, count, numbers);
    moved |= sums(numbers.gone) > Four{} + a.moved_limit2;
    const Four skin = fourths(numbers.with_skin);
    left |= ~(sums(numbers.relative) <= skin * skin);
  }

  /// Store the sums of damping coefficients, and the shares they give in the next step.
  [[gnu::always_inline]] void share_damping(int i, int count, const Numbers& numbers)
  {
    const Four damping = fourths(numbers.with_damping);
    const Four share = a.dt * damping / fourths(numbers.with_mass);
    for (int k = 0; k < count; ++k) {
      a.damping[i + k] = damping[k];
      a.rows.velocity[i + k].damping_share = share[k];
      if constexpr (single)
        a.rows.single_velocity[i + k].damping_share = static_cast<float>(share[k]);
    }
  }

  // Balls are selected below by loops without an index that is known at run time only. So what is
  // known of a group stays in registers.

  /// Name the first ball that is too fast.
  [[gnu::always_inline]] void guard(int i, int count, const Numbers& numbers, const Ended* ended)
  {
    const int fast = bits(~(sums(numbers.speed) <= Four{} + a.speed_limit2));
    if (__builtin_expect(fast == 0 || found.fast, true)) return;
#pragma GCC unroll 4
    for (int k = 0; k < group; ++k) {
      if (k >= count || found.fast || !(fast >> k & 1)) continue;
      found.fast = true;
      found.first_fast.ball = i + k;
      write(load<Four>(a.rows.position + i + k), found.first_fast.position);
      write(ended[k].velocity, found.first_fast.velocity);
      write(ended[k].on.force, found.first_fast.force);
    }
  }

  /// Note the balls whose contacts differ from those seen.
  [[gnu::always_inline]] void watch(int i, int count, const Numbers& numbers, const Ended* ended)
  {
    const ContactWatch& watch = *a.watch;
    const Four mass = fourths(numbers.with_mass);
    const int pressed = bits(sums(numbers.pressure) > (Four{} + watch.least) * mass * mass);
    const unsigned marks =
        load_marks(watch.wall_marks + i, count) | spread(pressed, watch.in_contact);
    store_marks(watch.marks + i, marks, count);
    const unsigned changed = marks ^ load_marks(watch.seen + i, count);
    if (__builtin_expect(changed == 0, true)) return;
#pragma GCC unroll 4
    for (int k = 0; k < group; ++k) {
      if (k >= count || !(changed >> 8 * k & 0xff)) continue;
      Moment& moment = watch.moments[found.moments++];
      store(&moment, load<Four>(a.rows.position + i + k));
      write(ended[k].velocity, moment.velocity);
      moment.ball = i + k;
    }
  }

  const Advance& a;
  const WallForce* wall;  ///< the next one
  Four gravity, dt, origin, column[3];
  FourBits moved{}, left{};
  Advanced found;
};

template <bool single, bool limited, bool watched>
Advanced advance_watched(const Advance& a)
{
  if (a.copy) return Pass<single, limited, watched, Besides::guard_and_copy>(a).all();
  return a.checks_speed ? Pass<single, limited, watched, Besides::guard>(a).all()
                        : Pass<single, limited, watched, Besides::nothing>(a).all();
}

template <bool single, bool limited>
Advanced advance_limited(const Advance& a)
{
  return a.watch ? advance_watched<single, limited, true>(a)
                 : advance_watched<single, limited, false>(a);
}

template <bool single>
Advanced advance_in(const Advance& a)
{
  return a.damping ? advance_limited<single, true>(a) : advance_limited<single, false>(a);
}

}  // namespace

Advanced advance(const Advance& a)
{
  return a.single ? advance_in<true>(a) : advance_in<false>(a);
}

}  // namespace millscale::kernels::MILLSCALE_LEVEL
