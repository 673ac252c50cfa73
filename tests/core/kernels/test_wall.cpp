#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <numeric>
#include <random>
#include <vector>

#include "core/kernels/kernel.h"
#include "core/kernels/wall_contact.h"

namespace {

using namespace millscale::kernels;
using millscale::Vector3;
namespace contact = millscale::contact;
namespace liner = millscale::liner;

constexpr int balls = 300;

/// The bits of a contact's results.
using Bits = std::array<std::uint64_t, 15>;

std::uint64_t bits_of(double number)
{
  std::uint64_t bits;
  std::memcpy(&bits, &number, sizeof bits);
  return number == 0.0 ? 0 : bits;  // zeros of either sign are equal
}

/// Balls that touch, or just do not touch, planes and circles of a turning wall. Every third ball
/// has two contacts.
class Scene {
 public:
  explicit Scene(unsigned seed) : random_(seed)
  {
    frame = {{0.1, -0.2, 0.3}, {0.6, 0.0, 0.8}, {-0.8, 0.0, 0.6}, {0.0, 1.0, 0.0}, {0.2, 1.7, 0.1}};
    for (const auto& m : std::vector<contact::EffectiveMaterial>{{3.3e7, 7.0e6, 0.59, 0.5, 0.010},
                                                                 {1.2e8, 4.0e7, 0.22, 0.7, 0.005}})
      laws.push_back(contact::contact_law(m));
    for (int i = 0; i < balls; ++i) {
      radius.push_back(0.02 * (1.0 + 0.5 * uniform()));
      mass.push_back(0.09 * (1.0 + 0.5 * uniform()));
      damping.push_back(50.0 * (1.0 + uniform()));
      for (int d = 0; d < 3; ++d) {
        position.push_back(uniform());
        velocity.push_back(uniform());
        spin.push_back(20.0 * uniform());
      }
      for (int k = 0; k < (i % 3 == 0 ? 2 : 1); ++k) add_contact(i);
    }
  }

  double uniform() { return std::uniform_real_distribution<double>(-1.0, 1.0)(random_); }

  WallTask task() const
  {
    WallTask t{};
    t.balls = {{position.data(), 3}, {radius.data(), 1}, {velocity.data(), 3},
               {mass.data(), 1},     {spin.data(), 3},   BallSums(damping.data(), 1)};
    t.frame = frame;
    t.patches = patches.data();
    t.laws = laws.data();
    t.only_law = -1;
    t.damping_of_balls = true;
    t.dt = 1e-5;
    return t;
  }

  WallFrame frame;
  std::vector<double> position, velocity, spin, radius, mass, damping;
  std::vector<liner::Patch> patches;
  std::vector<contact::ContactLaw<double>> laws;
  std::vector<int> ball;  ///< of the contacts; each has the patch of its number
  std::vector<Vector3<double>> displacement;

 private:
  void add_contact(int i)
  {
    const auto arm = millscale::vector3(&position[3 * i]) - frame.origin;
    const double x = dot(arm, frame.x), z = dot(arm, frame.z), along = dot(arm, frame.axis);
    const double distance = radius[i] * (1.0 - 4e-3 * uniform());  // some do not touch
    const double angle = 3.14 * uniform(), c = std::cos(angle), s = std::sin(angle);
    const double curvature = 1.5 * (1.0 + 0.3 * uniform());
    const int kind = static_cast<int>(patches.size()) % 4;
    const double turns = kind == 3 ? 0.0 : 1.0;
    if (kind == 0)
      patches.push_back({x - distance * c, z - distance * s, c, s, 0.0, 0.0, 0.0, turns});
    else if (kind == 1)
      patches.push_back({x - (curvature - distance) * c, z - (curvature - distance) * s, 0.0, 0.0,
                         0.0, curvature, 1.0, turns});
    else if (kind == 2)
      patches.push_back({x - distance * c, z - distance * s, 0.0, 0.0, 0.0, 0.0, -1.0, turns});
    else
      patches.push_back({0.0, 0.0, 0.0, 0.0, 1.0, distance - along, 0.0, turns});
    ball.push_back(i);
    displacement.push_back({1e-5 * uniform(), 1e-5 * uniform(), 1e-5 * uniform()});
  }

  std::mt19937 random_;
};

int law_of(int ball)
{
  return ball % 2;
}

/// Evaluate a contact of a ball by itself. share: of the ball.
Bits by_itself(const Scene& scene, const WallTask& task, int c, double share)
{
  const int i = scene.ball[c];
  const BallMotion<double> ball{scene.radius[i], scene.mass[i],
                                millscale::vector3(&scene.velocity[3 * i]),
                                millscale::vector3(&scene.spin[3 * i])};
  const auto touch = on_patch(scene.frame, scene.patches[c],
                              millscale::vector3(&scene.position[3 * i]), ball.radius);
  const auto result = contact::contact_force(
      contact_of(scene.frame, touch, scene.patches[c].turns, ball, scene.displacement[c], share),
      scene.laws[law_of(i)], task.terms, task.dt, true);
  const auto moment = cross(touch.arm, result.force) + result.torque_i;
  const std::array<double, 15> numbers{touch.overlap,
                                       share,
                                       result.displacement.x,
                                       result.displacement.y,
                                       result.displacement.z,
                                       result.force.x,
                                       result.force.y,
                                       result.force.z,
                                       result.torque_i.x,
                                       result.torque_i.y,
                                       result.torque_i.z,
                                       moment.x,
                                       moment.y,
                                       moment.z,
                                       result.damping};
  Bits bits;
  std::transform(numbers.begin(), numbers.end(), bits.begin(), bits_of);
  return bits;
}

/// Return the share of each ball, from coefficients of its contacts one by one.
std::vector<double> shares(const Scene& scene, const WallTask& task)
{
  std::vector<double> sum = scene.damping;
  for (std::size_t c = 0; c < scene.ball.size(); ++c) {
    const int i = scene.ball[c];
    const auto touch = on_patch(scene.frame, scene.patches[c],
                                millscale::vector3(&scene.position[3 * i]), scene.radius[i]);
    const double a = contact::contact_radius(scene.radius[i], touch.overlap);
    sum[i] += scene.laws[law_of(i)].tangential_damping * contact::damping_scale(a, scene.mass[i]);
  }
  for (int i = 0; i < balls; ++i)
    sum[i] =
        task.terms.limited_damping ? contact::damping_share(sum[i], scene.mass[i], task.dt) : 0.0;
  return sum;
}

/// Evaluate all contacts in batches of up to `size`, ball by ball in the given order.
std::vector<Bits> in_batches(const Scene& scene, const WallTask& task, const WallKernels& kernels,
                             const std::vector<int>& order, int size)
{
  std::vector<Bits> all(scene.ball.size());
  WallBatch batch;
  std::vector<int> number;
  const auto evaluate = [&] {
    kernels.evaluate(task, batch);
    for (int k = 0; k < batch.count; ++k) {
      std::array<double, 15> numbers{batch.overlap[k], batch.damping_share[k]};
      for (int d = 0; d < 3; ++d) {
        numbers[2 + d] = batch.stretch[d][k];
        numbers[5 + d] = batch.force[d][k];
        numbers[8 + d] = batch.torque[d][k];
        numbers[11 + d] = batch.moment[d][k];
      }
      numbers[14] = batch.damping[k];
      std::transform(numbers.begin(), numbers.end(), all[number[k]].begin(), bits_of);
    }
    batch.count = 0;
    number.clear();
  };
  for (const int i : order) {
    if (batch.count + 2 > size && batch.count > 0) evaluate();
    for (std::size_t c = 0; c < scene.ball.size(); ++c) {
      if (scene.ball[c] != i) continue;
      const int k = batch.count++;
      batch.ball[k] = i;
      batch.patch[k] = static_cast<int>(c);
      batch.law[k] = law_of(i);
      batch.displacement[0][k] = scene.displacement[c].x;
      batch.displacement[1][k] = scene.displacement[c].y;
      batch.displacement[2][k] = scene.displacement[c].z;
      number.push_back(static_cast<int>(c));
    }
  }
  if (batch.count > 0) evaluate();
  return all;
}

template <class Check>
void for_each_supported(const Check& check)
{
  for (const Implementation& each : implementations()) {
    SCOPED_TRACE(each.name);
    if (each.supported()) check(*each.wall);
  }
}

TEST(Wall, AContactHasTheSameBitsInAnyPlaceOfAnyBatchOnAnyMachine)
{
  const Scene scene(3);
  std::vector<int> order(balls);
  std::iota(order.begin(), order.end(), 0);
  std::mt19937 random(4);
  for (const bool limited : {false, true})
    for (const bool rolling : {false, true}) {
      WallTask task = scene.task();
      task.terms.limited_damping = limited;
      task.terms.rolling = rolling;
      const std::vector<double> share = shares(scene, task);
      std::vector<Bits> expected;
      int touching = 0;
      for (std::size_t c = 0; c < scene.ball.size(); ++c) {
        expected.push_back(by_itself(scene, task, static_cast<int>(c), share[scene.ball[c]]));
        touching += expected.back()[0] != 0;
      }
      ASSERT_GT(touching, balls / 2);
      ASSERT_LT(touching, static_cast<int>(scene.ball.size()) - balls / 4);
      for_each_supported([&](const WallKernels& kernels) {
        for (const int size : {2, 3, 7, 8, 33, 64}) {
          std::shuffle(order.begin(), order.end(), random);
          ASSERT_EQ(in_batches(scene, task, kernels, order, size), expected) << size;
        }
      });
    }
}

TEST(Wall, OneLawForAllIsThatLaw)
{
  Scene scene(5);
  scene.laws[1] = scene.laws[0];
  std::vector<int> order(balls);
  std::iota(order.begin(), order.end(), 0);
  for_each_supported([&](const WallKernels& kernels) {
    WallTask task = scene.task();
    const auto expected = in_batches(scene, task, kernels, order, 64);
    task.only_law = 0;
    EXPECT_EQ(in_batches(scene, task, kernels, order, 64), expected);
  });
}

TEST(Wall, MovedAreTheBallsBeyondTheirWay)
{
  Scene scene(6);
  const WallTask task = scene.task();
  std::vector<int> ball;
  std::vector<double> x, z, along, clear2;
  std::vector<bool> moved;
  for (int i = 0; i < balls; i += 1 + i % 2) {
    const auto arm = millscale::vector3(&scene.position[3 * i]) - scene.frame.origin;
    const double way = 0.1 * (1.0 + scene.uniform()), angle = 3.0 * scene.uniform();
    ball.push_back(i);
    x.push_back(dot(arm, scene.frame.x) + way * std::cos(angle));
    z.push_back(dot(arm, scene.frame.z));
    along.push_back(dot(arm, scene.frame.axis) + way * std::sin(angle));
    moved.push_back(i % 5 < 3);
    clear2.push_back(moved.back() ? way * way * 0.999 : way * way * 1.001);
    if (i % 10 == 0) clear2.back() = 0.0;
  }
  scene.position[3 * ball[7]] = std::nan("");
  moved[7] = true;
  const int count = static_cast<int>(ball.size());
  for (auto* numbers : {&x, &z, &along, &clear2}) numbers->resize(count + 64);
  ball.resize(count + 64);
  const NearBalls near{ball.data(), x.data(), z.data(), along.data(), clear2.data(), count};
  for_each_supported([&](const WallKernels& kernels) {
    for (int first = 0; first < count; first += 64) {
      const std::uint64_t bits = kernels.moved(task, near, first);
      for (int k = 0; k < 64; ++k)
        EXPECT_EQ((bits >> k & 1) != 0, first + k < count && moved[first + k]) << first + k;
    }
  });
}

TEST(Wall, SumsAreReadInBothPrecisions)
{
  const double doubles[] = {0.5, 9.0, 1.5};
  const float singles[] = {0.25f, 9.0f, 9.0f, 0.75f};
  EXPECT_EQ(BallSums(doubles, 2)[1], 1.5);
  EXPECT_EQ(BallSums(singles, 3)[1], 0.75);
  EXPECT_EQ(BallSums()[1], 0.0);
}

}  // namespace
