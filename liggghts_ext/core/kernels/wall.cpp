// The kernels of walls, see wall.h. Compiled for x86-64-v2, v3 and v4 with MILLSCALE_LEVEL. All
// functions here are local to the object file but those at the end, and call no library.
#include "core/kernels/levels.h"
#include "core/kernels/wall_contact.h"

#if defined(__AVX512DQ__) || defined(__AVX2__)
#include <immintrin.h>
#else
#include <emmintrin.h>
#endif

namespace millscale::kernels::MILLSCALE_LEVEL {
namespace {

#if defined(__AVX512DQ__)
constexpr int lanes = 8;
#elif defined(__AVX2__)
constexpr int lanes = 4;
#else
constexpr int lanes = 2;
#endif

/// One number of each of several contacts.
struct Pack {
  typedef double Values __attribute__((vector_size(lanes * sizeof(double))));
  using Mask = decltype(Values{} > Values{});

  Values values;

  Pack() = default;
  explicit Pack(double all) : values(Values{} + all) {}
  static Pack of(Values v)
  {
    Pack pack;
    pack.values = v;
    return pack;
  }
  static Pack load(const double* from)
  {
    Pack pack;
    __builtin_memcpy(&pack.values, from, sizeof pack.values);
    return pack;
  }
  void store(double* to) const { __builtin_memcpy(to, &values, sizeof values); }

  friend Pack operator+(Pack a, Pack b) { return of(a.values + b.values); }
  friend Pack operator-(Pack a, Pack b) { return of(a.values - b.values); }
  friend Pack operator*(Pack a, Pack b) { return of(a.values * b.values); }
  friend Pack operator/(Pack a, Pack b) { return of(a.values / b.values); }
  friend Mask operator>(Pack a, Pack b) { return a.values > b.values; }
  friend Pack choose(Mask condition, Pack yes, Pack no)
  {
    return of(condition ? yes.values : no.values);
  }
  friend Pack sqrt(Pack a)
  {
    Pack root;
    for (int lane = 0; lane < lanes; ++lane) root.values[lane] = __builtin_sqrt(a.values[lane]);
    return root;
  }
  friend Pack abs(Pack a) { return of(a.values < Values{} ? -a.values : a.values); }
};

#if defined(__AVX512DQ__)
inline unsigned bits(Pack::Mask mask)
{
  return _mm512_movepi64_mask(__m512i(mask));
}
#elif defined(__AVX2__)
inline unsigned bits(Pack::Mask mask)
{
  return _mm256_movemask_pd(__m256d(mask));
}
#else
inline unsigned bits(Pack::Mask mask)
{
  return _mm_movemask_pd(__m128d(mask));
}
#endif

using Vectors = Vector3<Pack>;

/// Return number(lane) of each lane.
template <class OfLane>
[[gnu::always_inline]] inline Pack gather(const OfLane& number)
{
  Pack pack;
  for (int lane = 0; lane < lanes; ++lane) pack.values[lane] = number(lane);
  return pack;
}

/// Return numbers of the balls of the lanes.
[[gnu::always_inline]] inline Pack numbers(const BallNumbers& of, const int* ball, int d = 0)
{
  return gather([&](int lane) { return of[ball[lane]][d]; });
}
[[gnu::always_inline]] inline Vectors vectors(const BallNumbers& of, const int* ball)
{
  return {numbers(of, ball, 0), numbers(of, ball, 1), numbers(of, ball, 2)};
}

[[gnu::always_inline]] inline Vectors load(const double (&from)[3][WallBatch::most], int k)
{
  return {Pack::load(from[0] + k), Pack::load(from[1] + k), Pack::load(from[2] + k)};
}
[[gnu::always_inline]] inline void store(double (&to)[3][WallBatch::most], int k, const Vectors& v)
{
  v.x.store(to[0] + k);
  v.y.store(to[1] + k);
  v.z.store(to[2] + k);
}

[[gnu::always_inline]] inline liner::PatchOf<Pack> patches(const liner::Patch* of, const int* index)
{
  const auto column = [&](double liner::Patch::*number) {
    return gather([&](int lane) { return of[index[lane]].*number; });
  };
  using Patch = liner::Patch;
  return {column(&Patch::x),
          column(&Patch::z),
          column(&Patch::normal_x),
          column(&Patch::normal_z),
          column(&Patch::normal_along),
          column(&Patch::offset),
          column(&Patch::side),
          column(&Patch::turns)};
}

using Law = contact::ContactLaw<double>;
using Laws = contact::ContactLaw<Pack>;

/// Return the laws number(lane) of the lanes.
template <class OfLane>
[[gnu::always_inline]] inline Laws laws(const Law* of, const OfLane& number)
{
  const auto column = [&](double Law::*constant) {
    return gather([&](int lane) { return of[number(lane)].*constant; });
  };
  return {column(&Law::normal_stiffness), column(&Law::tangential_stiffness),
          column(&Law::normal_damping),   column(&Law::tangential_damping),
          column(&Law::sliding),          column(&Law::rolling)};
}

/// Set the balls' shares in the divisors of the damping: of all their contacts with this wall, and
/// of those with balls. `damping` holds the coefficients of the contacts.
void set_damping_shares(const WallTask& task, WallBatch& batch)
{
  for (int k = 0; k < batch.count;) {
    const int ball = batch.ball[k], begin = k;
    double sum = task.damping_of_balls ? task.balls.damping[ball] : 0.0;
    for (; k < batch.count && batch.ball[k] == ball; ++k) sum += batch.damping[k];
    const double share = contact::damping_share(sum, *task.balls.mass[ball], task.dt);
    for (int c = begin; c < k; ++c) batch.damping_share[c] = share;
  }
}

/// Fill the last pack with repetitions of the last contact.
void fill_last_pack(WallBatch& batch)
{
  for (int k = batch.count; k % lanes != 0; ++k) {
    batch.ball[k] = batch.ball[k - 1];
    batch.patch[k] = batch.patch[k - 1];
    batch.law[k] = batch.law[k - 1];
    for (auto& numbers : batch.displacement) numbers[k] = numbers[k - 1];
    batch.damping_share[k] = 0.0;
  }
}

template <bool recorded>
[[gnu::flatten]] void evaluate_all(const WallTask& task, WallBatch& batch)
{
  fill_last_pack(batch);
  const auto law_at = [&](int k) {
    return task.only_law >= 0 ? laws(task.laws, [&](int) { return task.only_law; })
                              : laws(task.laws, [&](int lane) { return batch.law[k + lane]; });
  };
  const auto touch_at = [&](int k, const liner::PatchOf<Pack>& patch, Pack radius) {
    return on_patch(task.frame, patch, vectors(task.balls.position, batch.ball + k), radius);
  };
  if (task.terms.limited_damping) {
    for (int k = 0; k < batch.count; k += lanes) {
      const Pack radius = numbers(task.balls.radius, batch.ball + k);
      const auto touch = touch_at(k, patches(task.patches, batch.patch + k), radius);
      const Pack a = contact::contact_radius(radius, touch.overlap);
      const Pack mass = numbers(task.balls.mass, batch.ball + k);
      (law_at(k).tangential_damping * contact::damping_scale(a, mass)).store(batch.damping + k);
    }
    set_damping_shares(task, batch);
  } else {
    for (double& share : batch.damping_share) share = 0.0;
  }
  for (int k = 0; k < batch.count; k += lanes) {
    const int* ball = batch.ball + k;
    const auto patch = patches(task.patches, batch.patch + k);
    const BallMotion<Pack> motion{numbers(task.balls.radius, ball), numbers(task.balls.mass, ball),
                                  vectors(task.balls.velocity, ball),
                                  vectors(task.balls.spin, ball)};
    const auto touch = touch_at(k, patch, motion.radius);
    const auto contact =
        contact_of(task.frame, touch, patch.turns, motion, load(batch.displacement, k),
                   Pack::load(batch.damping_share + k));
    const auto result =
        contact::contact_force(contact, law_at(k), task.terms, task.dt, task.dt > 0.0);
    touch.overlap.store(batch.overlap + k);
    store(batch.stretch, k, result.displacement);
    store(batch.force, k, result.force);
    store(batch.torque, k, result.torque_i);
    store(batch.moment, k, cross(touch.arm, result.force) + result.torque_i);
    result.damping.store(batch.damping + k);
    if constexpr (recorded) {
      const Pack zero(0.0), half(0.5), speed = dot(contact.velocity, contact.normal);
      const Vectors loads = result.force - result.elastic_force * contact.normal;
      store(batch.loads, k, loads);
      (patch.turns * dot(all<Pack>(task.frame.spin), cross(touch.arm, loads) + result.torque_i))
          .store(batch.wall_power + k);
      choose(speed > zero, zero, half * contact.mass * speed * speed).store(batch.approach + k);
      (half * result.tangential_stiffness * dot(result.displacement, result.displacement))
          .store(batch.stored + k);
    }
  }
}

std::uint64_t find_moved(const WallTask& task, const NearBalls& near, int first)
{
  const int count = near.count - first < 64 ? near.count - first : 64;
  const auto x = all<Pack>(task.frame.x), z = all<Pack>(task.frame.z),
             axis = all<Pack>(task.frame.axis), origin = all<Pack>(task.frame.origin);
  std::uint64_t found = 0;
  for (int k = 0; k < count; k += lanes) {
    const int* ball = near.ball + first + k;
    const Vectors arm = vectors(task.balls.position, ball) - origin;
    const auto seen = [&](const double* numbers) { return Pack::load(numbers + first + k); };
    const Vectors way{dot(arm, x) - seen(near.x), dot(arm, z) - seen(near.z),
                      dot(arm, axis) - seen(near.along)};
    const std::uint64_t near_by = bits(seen(near.clear2) > dot(way, way));
    found |= (near_by ^ ((1u << lanes) - 1)) << k;
  }
  return count < 64 ? found & ((std::uint64_t{1} << count) - 1) : found;
}

}  // namespace

const WallKernels wall{find_moved, evaluate_all<false>, evaluate_all<true>};

}  // namespace millscale::kernels::MILLSCALE_LEVEL
