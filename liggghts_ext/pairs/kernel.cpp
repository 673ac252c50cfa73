// Compiled once for each level of x86-64, MILLSCALE_LEVEL being v2, v3 or v4. All of it but the
// entry point is local to the object, and it calls no library: a function shared with other
// objects could be linked from here and run on a machine that lacks its instructions.
#include "pairs/kernel.h"

namespace millscale::pairs::MILLSCALE_LEVEL {
namespace {

#if defined(__AVX512F__)
constexpr int width = 8;
#elif defined(__AVX__)
constexpr int width = 4;
#else
constexpr int width = 2;
#endif
/// `width` doubles that are added, multiplied ... together: the compiler's vector type with the
/// few functions `contact::ball_force` asks for.
struct Pack {
  typedef double Values __attribute__((vector_size(8 * width)));
  typedef long long Mask __attribute__((vector_size(8 * width)));

  Values values;

  Pack() = default;
  explicit Pack(double all) : values(Values{} + all) {}
  explicit Pack(Values v) : values(v) {}

  double operator[](int lane) const { return values[lane]; }

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

using Numbers = Pack;
using Vectors = contact::Triple<Numbers>;

/// A contact found: its balls and its entry of the list.
struct Found {
  int i, j, entry;
};

template <class Value>
inline Numbers gather(const Value& value)
{
  Numbers::Values v;
  for (int lane = 0; lane < width; ++lane) v[lane] = value(lane);
  return Numbers(v);
}

template <class Ball>
inline Vectors gather(const double (*field)[3], const Ball& ball)
{
  return {gather([&](int lane) { return field[ball(lane)][0]; }),
          gather([&](int lane) { return field[ball(lane)][1]; }),
          gather([&](int lane) { return field[ball(lane)][2]; })};
}

inline contact::BallLaw<Numbers> gather_law(const Task& task, const Found* found)
{
  const auto law = [&](int lane) -> const contact::BallLaw<double>& {
    return task.law[(task.balls.type[found[lane].i] - 1) * task.types +
                    task.balls.type[found[lane].j] - 1];
  };
  return {gather([&](int lane) { return law(lane).normal_stiffness; }),
          gather([&](int lane) { return law(lane).tangential_stiffness; }),
          gather([&](int lane) { return law(lane).normal_damping; }),
          gather([&](int lane) { return law(lane).tangential_damping; }),
          gather([&](int lane) { return law(lane).sliding; }),
          gather([&](int lane) { return law(lane).rolling; })};
}

inline contact::BallLaw<Numbers> same_law(const contact::BallLaw<double>& law)
{
  return {Numbers(law.normal_stiffness), Numbers(law.tangential_stiffness),
          Numbers(law.normal_damping),   Numbers(law.tangential_damping),
          Numbers(law.sliding),          Numbers(law.rolling)};
}

inline void add(double* sum, const Vectors& part, int lane)
{
  sum[0] += part.x[lane];
  sum[1] += part.y[lane];
  sum[2] += part.z[lane];
}

inline void subtract(double* sum, const Vectors& part, int lane)
{
  sum[0] -= part.x[lane];
  sum[1] -= part.y[lane];
  sum[2] -= part.z[lane];
}

/// Forces of `count` <= width contacts; beyond `count` the lanes of `found` repeat one.
[[gnu::flatten, gnu::noinline]] void evaluate_pack(const Task& task, const Found* found, int count,
                                                   const contact::BallLaw<Numbers>& law)
{
  const Balls& balls = task.balls;
  const auto i = [&](int lane) { return found[lane].i; };
  const auto j = [&](int lane) { return found[lane].j; };
  contact::BallTouch<Numbers> touch;
  touch.apart = gather(balls.position, i) - gather(balls.position, j);
  touch.square = dot(touch.apart, touch.apart);
  touch.radius_i = gather([&](int lane) { return balls.radius[i(lane)]; });
  touch.radius_j = gather([&](int lane) { return balls.radius[j(lane)]; });
  touch.mass_i = gather([&](int lane) { return balls.mass[i(lane)]; });
  touch.mass_j = gather([&](int lane) { return balls.mass[j(lane)]; });
  touch.velocity = gather(balls.velocity, i) - gather(balls.velocity, j);
  touch.spin_i = gather(balls.spin, i);
  touch.spin_j = gather(balls.spin, j);
  const auto memory = reinterpret_cast<double(*)[3]>(task.displacement);
  touch.displacement = gather(memory, [&](int lane) { return found[lane].entry; });

  const auto result = contact::ball_force(touch, law, task.terms, task.dt, task.advance);
  for (int lane = 0; lane < count; ++lane) {
    double* kept = memory[found[lane].entry];
    kept[0] = result.displacement.x[lane];
    kept[1] = result.displacement.y[lane];
    kept[2] = result.displacement.z[lane];
    add(task.force[i(lane)], result.force, lane);
    add(task.torque[i(lane)], result.torque_i, lane);
    if (j(lane) < balls.owned) {
      subtract(task.force[j(lane)], result.force, lane);
      add(task.torque[j(lane)], result.torque_j, lane);
    }
  }
}

inline bool touch_each_other(const Balls& balls, int i, int j)
{
  const double *a = balls.position[i], *b = balls.position[j];
  const double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
  const double radii = balls.radius[i] + balls.radius[j];
  return x * x + y * y + z * z < radii * radii;
}

}  // namespace

void evaluate(const Task& task)
{
  constexpr int block = 16 * width;
  Found found[block + width];
  int count = 0;
  const bool one_law = task.only_type > 0;
  contact::BallLaw<Numbers> law =
      same_law(task.law[(task.only_type - 1) * one_law * (task.types + 1)]);
  const auto pack = [&](const Found* contacts, int n) {
    if (!one_law) law = gather_law(task, contacts);
    evaluate_pack(task, contacts, n, law);
  };
  for (int i = 0; i < task.balls.owned; ++i) {
    for (int entry = task.first[i]; entry < task.first[i + 1]; ++entry) {
      const int j = task.other[entry];
      const bool touching = touch_each_other(task.balls, i, j);
      if (task.touching[entry] & !touching & task.forget_apart) {
        for (int d = 0; d < 3; ++d) task.displacement[3 * entry + d] = 0.0;
        task.touching[entry] = 0;
      }
      task.touching[entry] |= touching;
      found[count] = {i, j, entry};  // kept only if it counts: no branch to mispredict
      count += touching;
      if (count == block) {
        for (int k = 0; k < block; k += width) pack(found + k, width);
        count = 0;
      }
    }
  }
  int k = 0;
  for (; k + width <= count; k += width) pack(found + k, width);
  if (k < count) {
    for (int lane = count; lane < k + width; ++lane) found[lane] = found[k];
    pack(found + k, count - k);
  }
}

}  // namespace millscale::pairs::MILLSCALE_LEVEL
