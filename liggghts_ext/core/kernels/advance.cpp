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

inline void write(const Four& from, Vector& to)
{
  for (int d = 0; d < 3; ++d) to[d] = from[d];
}

/// Four ints, from the bytes of marks.
inline int load_marks(const signed char* marks)
{
  int four;
  __builtin_memcpy(&four, marks, sizeof four);
  return four;
}

/// Return four marks, `mark` where a bit is set.
inline int spread(int bits, signed char mark)
{
  const int ones = (bits & 1) | (bits & 2) << 7 | (bits & 4) << 14 | (bits & 8) << 21;
  return ones * mark;
}

template <bool single, bool limited, bool watched, bool guarded>
class Pass {
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
  /// Advance a ball. k: its lane in the group.
  [[gnu::always_inline]] void one(int i, int k)
  {
    const Rows& rows = a.rows;
    Load on = take_load<single>(rows, i);
    VelocityRow& row = rows.velocity[i];
    const Four before = load<Four>(row.velocity), spin = load<Four>(row.spin);
    const Four weight = before[3] * gravity;
    if (a.gravity_first) on.force = on.force + weight;
    for (; wall != a.wall_end && wall->ball == i; ++wall) {
      on.force = on.force + load<Four>(wall->force);
      on.torque = on.torque + load<Four>(wall->torque);
    }
    if (!a.gravity_first) on.force = on.force + weight;
    const Four push = a.kick[i].linear * three(on.force);
    const Four turn = a.kick[i].angular * three(on.torque);
    const Four full = before + push, half = full + push;
    const Four half_spin = spin + turn + turn;
    store(row.velocity, half);
    store(row.spin, half_spin);
    if constexpr (single) {
      SingleVelocityRow& copy = rows.single_velocity[i];
      store(copy.velocity, __builtin_convertvector(half, FourSingles));
      store(copy.spin, __builtin_convertvector(half_spin, FourSingles));
    }
    const Four x = load<Four>(rows.position + i);
    const Four next = x + dt * half;
    store(rows.position + i, next);
    if constexpr (limited || watched) mass[k] = before[3];
    if constexpr (limited) damping[k] = on.torque[3];

    if constexpr (watched || guarded) {
      position[k] = x;
      velocity[k] = full;
    }
    const Four begin = load<Four>(a.start + i);
    skin[k] = begin[3];
    const Four way = three(next - begin);
    gone[k] = way * way;
    const Four from = next - origin, held = begin - origin;
    const Four turned = held[0] * column[0] + held[1] * column[1] + held[2] * column[2];
    const Four apart = three(from - turned);
    relative[k] = apart * apart;
    if constexpr (guarded) {
      force_on[k] = on.force;
      const Four v = three(full);
      speed[k] = v * v;
    }
    if constexpr (watched) {
      const Four by_contacts = three(on.force - weight);
      pressure[k] = by_contacts * by_contacts;
    }
  }

  /// Advance `count` balls, at most a group.
  [[gnu::always_inline]] void some(int i, int count)
  {
    for (int k = count; k < group; ++k) {
      gone[k] = relative[k] = speed[k] = pressure[k] = skin = mass = damping = Four{};
    }
#pragma GCC unroll 4
    for (int k = 0; k < count; ++k) one(i + k, k);
    if constexpr (limited) share_damping(i, count);
    moved |= sums(gone) > Four{} + a.moved_limit2;
    left |= ~(sums(relative) <= skin * skin);
    if constexpr (guarded) {
      const int fast = bits(~(sums(speed) <= Four{} + a.speed_limit2));
      if (fast && !found.fast) name_fast(i + __builtin_ctz(fast), __builtin_ctz(fast));
    }
    if constexpr (watched) watch(i, count);
  }

  /// Store the sums of damping coefficients, and the shares they give in the next step.
  [[gnu::always_inline]] void share_damping(int i, int count)
  {
    const Four share = a.dt * damping / mass;
    for (int k = 0; k < count; ++k) {
      a.damping[i + k] = damping[k];
      a.rows.velocity[i + k].damping_share = share[k];
      if constexpr (single)
        a.rows.single_velocity[i + k].damping_share = static_cast<float>(share[k]);
    }
  }

  [[gnu::noinline]] void name_fast(int i, int k)
  {
    found.fast = true;
    found.first_fast.ball = i;
    write(position[k], found.first_fast.position);
    write(velocity[k], found.first_fast.velocity);
    write(force_on[k], found.first_fast.force);
  }

  [[gnu::always_inline]] void watch(int i, int count)
  {
    const ContactWatch& watch = *a.watch;
    const int pressed = bits(sums(pressure) > (Four{} + watch.least) * mass * mass);
    if (count == group) {
      const int marks = load_marks(watch.wall_marks + i) | spread(pressed, watch.in_contact);
      __builtin_memcpy(watch.marks + i, &marks, sizeof marks);
      if (marks == load_marks(watch.seen + i)) return;
    }
    for (int k = 0; k < count; ++k) {
      const signed char mark = watch.wall_marks[i + k] |
                               (pressed >> k & 1 ? watch.in_contact : static_cast<signed char>(0));
      watch.marks[i + k] = mark;
      if (mark == watch.seen[i + k]) continue;
      Moment& moment = watch.moments[found.moments++];
      moment.ball = i + k;
      write(position[k], moment.position);
      write(velocity[k], moment.velocity);
    }
  }

  const Advance& a;
  const WallForce* wall;  ///< the next one
  Four gravity, dt, origin, column[3];
  // Of the balls of a group, at the end of the step: three components and another number.
  Four position[group], velocity[group], force_on[group];
  Four gone[group], relative[group], speed[group], pressure[group];  ///< squares of components
  Four skin, mass, damping;
  FourBits moved{}, left{};
  Advanced found;
};

template <bool single, bool limited, bool watched>
Advanced advance_watched(const Advance& a)
{
  return a.checks_speed ? Pass<single, limited, watched, true>(a).all()
                        : Pass<single, limited, watched, false>(a).all();
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
