#include <gtest/gtest.h>

#include "contact/written_out.h"
#include "pairs/cloud.h"
#include "pairs/kernel.h"

namespace {

using namespace millscale::pairs;
namespace contact = millscale::contact;

constexpr double dt = 1e-5;

/// Materials of two types, each pair of types unlike the others.
const std::vector<written_out::Law> materials{{3.3e7, 7.0e6, 0.59, 0.5, 0.010},
                                              {2.1e7, 9.0e6, 0.46, 0.3, 0.020},
                                              {2.1e7, 9.0e6, 0.46, 0.3, 0.020},
                                              {1.2e8, 4.0e7, 0.22, 0.7, 0.005}};

/// A cloud, its list and what a step leaves.
struct Step {
  Cloud cloud;
  HalfList list;
  std::vector<std::array<double, 3>> force, torque;
  contact::BallTerms terms;
  bool advance = true, forget_apart = true;

  explicit Step(const Cloud& c, double gap = 0.005) : cloud(c)
  {
    CellGrid grid;
    build(list, grid, cloud.view(), gap, best_kernel().list_partners);
    std::mt19937 random(11);
    std::normal_distribution<double> normal;
    for (int i = 0; i < list.owned(); ++i)
      for (int entry = list.first[i]; entry < list.first[i] + list.partners[i]; ++entry) {
        list.touching[entry] = 1;
        for (int d = 0; d < 3; ++d) list.displacement[3 * entry + d] = 3e-5 * normal(random);
      }
    clear();
  }

  void clear()
  {
    force.assign(cloud.all(), {});
    torque.assign(cloud.all(), {});
  }

  int only_type() const
  {
    const auto& type = cloud.type;
    const bool one = std::all_of(type.begin(), type.end(), [&](int t) { return t == type[0]; });
    return one && !type.empty() ? type[0] : 0;
  }

  void with(const Kernel& kernel)
  {
    std::vector<contact::BallLaw<double>> laws;
    for (const auto& m : materials)
      laws.push_back(
          contact::ball_law(m.youngs_modulus, m.shear_modulus, m.damping, m.sliding, m.rolling));
    kernel.evaluate({cloud.view(), list.first.data(), list.partners.data(), list.other.data(),
                     list.touching.data(), list.displacement.data(), laws.data(), 2, only_type(),
                     terms, dt, advance, forget_apart, reinterpret_cast<double(*)[3]>(force.data()),
                     reinterpret_cast<double(*)[3]>(torque.data())});
  }

  double apart_square(int i, int j) const
  {
    double square = 0.0;
    for (int d = 0; d < 3; ++d) {
      const double apart = cloud.position[i][d] - cloud.position[j][d];
      square += apart * apart;
    }
    return square;
  }

  /// One pair after the other, by the written-out law.
  void naively()
  {
    for (int i = 0; i < cloud.owned(); ++i)
      for (int entry = list.first[i]; entry < list.first[i] + list.partners[i]; ++entry)
        naive_pair(i, list.other[entry], entry);
  }

  void naive_pair(int i, int j, int entry)
  {
    using written_out::sum;
    double* memory = &list.displacement[3 * entry];
    const double radii = cloud.radius[i] + cloud.radius[j], square = apart_square(i, j);
    if (!(square < radii * radii)) {
      if (!forget_apart) return;
      list.touching[entry] = 0;
      std::fill_n(memory, 3, 0.0);
      return;
    }
    const auto triple = [](const millscale::Vector& a) {
      return contact::Triple<double>{a[0], a[1], a[2]};
    };
    const auto got = written_out::ball_force(
        {triple(sum(cloud.position[i], -1.0, cloud.position[j])),
         square,
         cloud.radius[i],
         cloud.radius[j],
         cloud.mass[i],
         cloud.mass[j],
         triple(sum(cloud.velocity[i], -1.0, cloud.velocity[j])),
         triple(cloud.spin[i]),
         triple(cloud.spin[j]),
         {memory[0], memory[1], memory[2]}},
        materials[(cloud.type[i] - 1) * 2 + cloud.type[j] - 1], terms, dt, advance);
    list.touching[entry] = 1;
    std::copy_n(got.displacement.begin(), 3, memory);
    force[i] = sum(force[i], 1.0, got.force);
    torque[i] = sum(torque[i], 1.0, got.torque_i);
    if (j >= cloud.owned()) return;
    force[j] = sum(force[j], -1.0, got.force);
    torque[j] = sum(torque[j], 1.0, got.torque_j);
  }
};

double largest(const std::vector<std::array<double, 3>>& field)
{
  double size = 0.0;
  for (const auto& row : field)
    for (const double value : row) size = std::fmax(size, std::abs(value));
  return size;
}

void expect_close(const std::vector<std::array<double, 3>>& got,
                  const std::vector<std::array<double, 3>>& expected, double tolerance)
{
  ASSERT_EQ(got.size(), expected.size());
  const double accepted = tolerance * largest(expected);
  for (std::size_t i = 0; i < got.size(); ++i)
    for (int d = 0; d < 3; ++d)
      ASSERT_LE(std::abs(got[i][d] - expected[i][d]), accepted) << "ball " << i << " " << d;
}

/// The kernel leaves what the naive loop leaves. A force is known to the rounding of its overlap,
/// 1e-16 of the distance; the tolerance, of the largest force, holds for overlaps that are not
/// much below a hundredth of a radius where the force counts.
void expect_as_naive(const Step& start, const Kernel& kernel, double tolerance = 1e-13)
{
  Step step = start, naive = start;
  step.with(kernel);
  naive.naively();
  SCOPED_TRACE(kernel.level);
  expect_close(step.force, naive.force, tolerance);
  expect_close(step.torque, naive.torque, tolerance);
  EXPECT_EQ(step.list.touching, naive.list.touching);
  for (std::size_t k = 0; k < step.list.displacement.size(); ++k)
    ASSERT_NEAR(step.list.displacement[k], naive.list.displacement[k], tolerance * 1e-4);
}

int touching(const Step& step)
{
  int count = 0;
  for (int i = 0; i < step.cloud.owned(); ++i)
    for (int entry = step.list.first[i]; entry < step.list.first[i] + step.list.partners[i];
         ++entry) {
      const int j = step.list.other[entry];
      count += std::sqrt(step.apart_square(i, j)) < step.cloud.radius[i] + step.cloud.radius[j];
    }
  return count;
}

/// `count` pairs of balls that overlap, and as many that are near, every pair by itself.
Cloud separate_pairs(int count, unsigned seed)
{
  Cloud cloud = random_cloud({4 * count, 0.0, 0.015, 0.025, 2}, seed);
  for (int i = 0; i < cloud.all(); ++i) {
    const int pair = i / 2;
    const double radii = cloud.radius[2 * pair] + cloud.radius[2 * pair + 1];
    cloud.position[i][0] = 0.2 * pair;
    cloud.position[i][1] = i % 2 * radii * (pair % 2 ? 1.01 : 0.97);
  }
  return cloud;
}

TEST(Kernel, OfLevelTwoRunsOnAnyMachine)
{
  EXPECT_TRUE(runs(2));
  EXPECT_FALSE(runs(1));
  EXPECT_FALSE(runs(5));
  EXPECT_STREQ(best_kernel().level, kernels().back().level);
}

TEST(Kernel, OfEveryLevelIsTheNaiveLoop)
{
  for (const Kernel& kernel : kernels()) {
    expect_as_naive(Step(random_cloud({300, 0.3, 0.01, 0.03, 2}, 1)), kernel);
    expect_as_naive(Step(random_cloud({300, 0.25}, 2)), kernel);  // one type: one law for all
    Cloud second = random_cloud({300, 0.25}, 3);
    std::fill(second.type.begin(), second.type.end(), 2);
    expect_as_naive(Step(second), kernel);
  }
}

TEST(Kernel, TakesAnyNumberOfContacts)
{
  // Past twice the widest block of 128 too.
  for (const Kernel& kernel : kernels())
    for (int count : {0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 12,  13,  14,  15, 16,
                      17, 23, 24, 25, 31, 32, 33, 39, 40, 63, 64, 65, 127, 128, 129, 300}) {
      const Step start(separate_pairs(count, 100 + count));
      ASSERT_EQ(touching(start), count);
      SCOPED_TRACE(count);
      expect_as_naive(start, kernel);
    }
}

TEST(Kernel, HasEveryChoiceOfTerms)
{
  for (const Kernel& kernel : kernels())
    for (unsigned choice = 0; choice < 8; ++choice) {
      Step start(random_cloud({150, 0.2, 0.01, 0.03, 2}, 4));
      start.terms = {bool(choice & 1), bool(choice & 2), bool(choice & 4)};
      SCOPED_TRACE(choice);
      expect_as_naive(start, kernel);
    }
}

TEST(Kernel, GivesGhostsNoForceAndTheirPartnersAllOfIt)
{
  const Cloud cloud = random_cloud({300, 0.25, 0.01, 0.03, 2, 120}, 5);
  for (const Kernel& kernel : kernels()) {
    const Step start(cloud);
    expect_as_naive(start, kernel);
    Step step = start;
    step.with(kernel);
    for (int j = cloud.owned(); j < cloud.all(); ++j)
      for (int d = 0; d < 3; ++d) {
        EXPECT_EQ(step.force[j][d], 0.0);
        EXPECT_EQ(step.torque[j][d], 0.0);
      }
  }
}

TEST(Kernel, AddsToWhatIsThere)
{
  for (const Kernel& kernel : kernels()) {
    Step once(random_cloud({100, 0.2}, 6));
    once.advance = false;
    Step twice = once;
    once.with(kernel);
    twice.with(kernel);
    twice.with(kernel);
    for (auto* field : {&once.force, &once.torque})
      for (auto& row : *field)
        for (double& value : row) value *= 2.0;
    expect_close(twice.force, once.force, 1e-13);
    expect_close(twice.torque, once.torque, 1e-13);
  }
}

TEST(Kernel, StartsFromBallsAtRest)
{
  Cloud cloud = random_cloud({100, 0.2}, 7);
  for (int i = 0; i < cloud.all(); ++i) cloud.velocity[i] = cloud.spin[i] = {};
  for (const Kernel& kernel : kernels()) {
    Step start(cloud);
    std::fill(start.list.displacement.begin(), start.list.displacement.end(), 0.0);
    expect_as_naive(start, kernel);
    start.with(kernel);
    EXPECT_GT(largest(start.force), 1.0);
    EXPECT_EQ(largest(start.torque), 0.0);
  }
}

TEST(Kernel, ForgetsAContactThatPartedOnlyIfAsked)
{
  for (const Kernel& kernel : kernels())
    for (const bool forget : {true, false}) {
      Step step(separate_pairs(20, 8));
      step.forget_apart = forget;
      expect_as_naive(step, kernel);
      const std::vector<double> before = step.list.displacement;
      step.with(kernel);
      int parted = 0;
      for (int pair = 1; pair < 40; pair += 2) {  // every second pair is apart
        const int entry = step.list.first[2 * pair];
        ASSERT_EQ(step.list.other[entry], 2 * pair + 1);
        EXPECT_EQ(step.list.touching[entry], forget ? 0 : 1);
        for (int d = 0; d < 3; ++d)
          EXPECT_EQ(step.list.displacement[3 * entry + d], forget ? 0.0 : before[3 * entry + d]);
        ++parted;
      }
      EXPECT_EQ(parted, 20);
    }
}

TEST(Kernel, AtSetUpUsesMemoriesAndKeepsThem)
{
  for (const Kernel& kernel : kernels()) {
    Step step(random_cloud({200, 0.25, 0.01, 0.03, 2}, 9));
    step.advance = step.forget_apart = false;
    expect_as_naive(step, kernel);
    const std::vector<double> before = step.list.displacement;
    step.with(kernel);
    EXPECT_EQ(step.list.displacement, before);
  }
}

TEST(Kernel, ConservesMomentumToRoundOff)
{
  // The sum of forces is a rounding error of its terms, 1e-16 times the root of their number.
  for (const Kernel& kernel : kernels()) {
    Step step(random_cloud({500, 0.25, 0.01, 0.03, 2}, 10));
    step.with(kernel);
    millscale::Vector total{}, moment{};
    double sizes = 0.0, moments = 0.0;
    for (int i = 0; i < step.cloud.all(); ++i) {
      const millscale::Vector lever = millscale::cross(step.cloud.position[i], step.force[i]);
      total = written_out::sum(total, 1.0, step.force[i]);
      moment = written_out::sum(written_out::sum(moment, 1.0, lever), 1.0, step.torque[i]);
      sizes += written_out::size(step.force[i]);
      moments += written_out::size(lever);
    }
    EXPECT_LT(written_out::size(total), 1e-15 * sizes) << kernel.level;
    EXPECT_LT(written_out::size(moment), 1e-15 * moments) << kernel.level;
  }
}

TEST(Kernel, GivesBallsThatBarelyTouchAFiniteForce)
{
  // At a distance of the radii, give or take a few rounding errors, all kernels must agree with
  // themselves whether the balls touch: an overlap below 0 has no square root.
  Cloud cloud;
  std::mt19937 random(12);
  std::normal_distribution<double> normal;
  for (int pair = 0; pair < 20000; ++pair) {
    std::array<double, 3> n{normal(random), normal(random), normal(random)};
    const double length = std::hypot(n[0], n[1], n[2]), radii = 0.04 + 1e-4 * (pair % 7);
    std::array<double, 3> here{0.2 * (pair % 30), 0.2 * (pair / 30 % 30), 0.2 * (pair / 900)};
    cloud.add(here, 0.5 * radii);
    for (int d = 0; d < 3; ++d) here[d] += radii * n[d] / length;
    cloud.add(here, radii - 0.5 * radii);
  }
  for (const Kernel& kernel : kernels()) {
    Step step(cloud, 1e-4);
    ASSERT_EQ(step.list.pairs(), 20000u);
    step.with(kernel);
    for (const auto& row : step.force)
      for (const double value : row) ASSERT_TRUE(std::isfinite(value)) << kernel.level;
    for (const double value : step.list.displacement)
      ASSERT_TRUE(std::isfinite(value)) << kernel.level;
    EXPECT_LT(largest(step.force), 1e-9);
  }
}

}  // namespace
