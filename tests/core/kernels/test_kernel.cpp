#include <gtest/gtest.h>

#include "core/kernels/evaluation.h"
#include "core/measure/overlap_search.h"

namespace {

using namespace kernel_test;

void expect_close(const std::vector<std::array<double, 3>>& got,
                  const std::vector<std::array<double, 3>>& expected, double tolerance)
{
  ASSERT_EQ(got.size(), expected.size());
  const double accepted = tolerance * largest(expected);
  for (std::size_t i = 0; i < got.size(); ++i)
    for (int d = 0; d < 3; ++d)
      ASSERT_LE(std::abs(got[i][d] - expected[i][d]), accepted) << "ball " << i << " " << d;
}

/// Expect the results of the naive loop. A force is known to the rounding of its overlap, 1e-16 of
/// the distance. The tolerance is relative to the largest force. It holds if the overlaps of large
/// forces are not much below a hundredth of a radius. A mixed kernel rounds each number to 6e-8,
/// with some twenty roundings in a force.
void expect_as_naive(const Evaluation& start, const Implementation& kernel)
{
  const double rounding = is_mixed(kernel) ? 1.2e-6 : 1e-12,
               tolerance = is_mixed(kernel) ? 1.2e-6 : 1e-13;
  Evaluation step = start, naive = start;
  step.with(kernel);
  naive.naively();
  SCOPED_TRACE(kernel.name);
  expect_close(step.force, naive.force, tolerance);
  expect_close(step.torque, naive.torque, tolerance);
  EXPECT_EQ(step.list.touching, naive.list.touching);
  for (int i = 0; i < step.cloud.all(); ++i)
    ASSERT_NEAR(step.damping[i], naive.damping[i], rounding * naive.damping[i] + 1e-15);
  for (std::size_t k = 0; k < step.list.displacement.size(); ++k)
    ASSERT_NEAR(step.list.displacement[k], naive.list.displacement[k], tolerance * 1e-4);
}

int touching(const Evaluation& step)
{
  int count = 0;
  for (int i = 0; i < step.cloud.nlocal(); ++i)
    for (int entry = step.list.first[i]; entry < step.list.first[i] + step.list.partners[i];
         ++entry) {
      const int j = step.list.other[entry];
      count +=
          std::sqrt(step.separation_squared(i, j)) < step.cloud.radius[i] + step.cloud.radius[j];
    }
  return count;
}

/// `count` pairs of balls that overlap, and as many pairs that are near without overlap, far from
/// all others.
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

TEST(Implementation, ThePlainestRunsOnAnyMachineAndTheBestHasPacksIfAnyHas)
{
  const auto& all = implementations();
  EXPECT_TRUE(all.front().supported());
  const Implementation& best = best_implementation();
  EXPECT_TRUE(best.supported());
  EXPECT_EQ(&best, &best_implementation()) << "measured once";
  for (const Implementation& each : all)
    EXPECT_LE(each.supported() && each.evaluate_rows, bool(best.evaluate_rows)) << each.name;
}

TEST(Implementation, IsFoundByItsNameIfTheMachineSupportsIt)
{
  for (const Implementation& each : implementations())
    EXPECT_EQ(find_implementation(each.name), each.supported() ? &each : nullptr);
  EXPECT_EQ(find_implementation("x86-64-v5"), nullptr);
}

TEST(Kernel, OfEveryImplementationIsTheNaiveLoop)
{
  for (const Implementation& kernel : kernels()) {
    expect_as_naive(Evaluation(random_cloud({300, 0.3, 0.01, 0.03, 2}, 1)), kernel);
    expect_as_naive(Evaluation(random_cloud({300, 0.25}, 2)), kernel);  // one type: one law for all
    Cloud second = random_cloud({300, 0.25}, 3);
    std::fill(second.type.begin(), second.type.end(), 2);
    expect_as_naive(Evaluation(second), kernel);
  }
}

TEST(Kernel, TakesAnyNumberOfContacts)
{
  // Also counts beyond twice the widest block of 128.
  for (const Implementation& kernel : kernels())
    for (int count : {0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 12,  13,  14,  15, 16,
                      17, 23, 24, 25, 31, 32, 33, 39, 40, 63, 64, 65, 127, 128, 129, 300}) {
      const Evaluation start(separate_pairs(count, 100 + count));
      ASSERT_EQ(touching(start), count);
      SCOPED_TRACE(count);
      expect_as_naive(start, kernel);
    }
}

TEST(Kernel, HasEveryChoiceOfTerms)
{
  for (const Implementation& kernel : kernels())
    for (unsigned choice = 0; choice < 16; ++choice) {
      Evaluation start(random_cloud({150, 0.2, 0.01, 0.03, 2}, 4));
      start.terms = {bool(choice & 1), bool(choice & 2), bool(choice & 8), bool(choice & 4)};
      SCOPED_TRACE(choice);
      expect_as_naive(start, kernel);
    }
}

TEST(Kernel, OfRowsGivesTheSameBits)
{
  for (const Implementation& kernel : kernels())
    for (unsigned choice = 0; kernel.evaluate_rows && choice < 64; ++choice) {
      Evaluation start(random_cloud({200, 0.2, 0.01, 0.03, 1 + int(choice & 1), 50}, 14));
      start.terms = {bool(choice & 2), bool(choice & 4), bool(choice & 8), bool(choice & 16)};
      start.advance = start.reset_on_separation = choice & 32;
      Evaluation of_rows = start;
      start.with(kernel);
      of_rows.with_rows(kernel);
      SCOPED_TRACE(kernel.name + (" " + std::to_string(choice)));
      EXPECT_GT(largest(start.force), 0.0);
      EXPECT_EQ(of_rows.force, start.force);
      EXPECT_EQ(of_rows.torque, start.torque);
      EXPECT_EQ(of_rows.damping, start.damping);
      EXPECT_EQ(of_rows.list.touching, start.list.touching);
      EXPECT_EQ(of_rows.list.displacement, start.list.displacement);
    }
}

/// Return the largest overlap by a search among all balls.
double searched_overlap(const Cloud& cloud)
{
  millscale::charge::OverlapSearch search;
  for (int i = 0; i < cloud.all(); ++i) {
    const auto& x = cloud.position[i];
    search.add({x[0], x[1], x[2], cloud.radius[i], i >= cloud.nlocal()});
  }
  return search.largest();
}

TEST(Kernel, NotesTheLargestOverlapWithTheBitsOfASearch)
{
  for (const Implementation& kernel : kernels())
    for (int balls = 2; balls < 200; balls += 3) {
      const double edge = 0.03 * std::cbrt(balls);  // some contacts for each ball
      const Cloud cloud =
          random_cloud({balls, edge, 0.01, balls % 2 ? 0.01 : 0.03, 1, balls / 4}, 20 + balls);
      const double expected = searched_overlap(cloud);
      SCOPED_TRACE(kernel.name + (" " + std::to_string(balls)));
      EXPECT_TRUE(expected > 0.0 || balls < 20);
      double noted = 0.0, of_rows = 0.0;
      Evaluation step(cloud);
      step.largest_overlap = &noted;
      step.with(kernel);
      EXPECT_EQ(noted, expected);
      if (!kernel.evaluate_rows) continue;
      step.largest_overlap = &of_rows;
      step.with_rows(kernel);
      EXPECT_EQ(of_rows, expected);
    }
}

TEST(Kernel, OfBothWidthsGivesTheSameBits)
{
  // The choice of the faster one at run time thus changes no result.
  const Implementation *four = find_implementation("x86-64-v3"),
                       *eight = find_implementation("x86-64-v4");
  if (!four || !eight) GTEST_SKIP() << "this machine has one width";
  for (const bool single : {false, true})
    for (unsigned choice = 0; choice < 64; ++choice) {
      Evaluation start(random_cloud({400, 0.25, 0.01, 0.03, 1 + int(choice & 1), 50}, 15));
      start.terms = {bool(choice & 2), bool(choice & 4), bool(choice & 8), bool(choice & 16)};
      start.advance = start.reset_on_separation = choice & 32;
      Evaluation wide = start;
      for (auto [step, kernel] : {std::pair{&start, *four}, std::pair{&wide, *eight}}) {
        if (single) kernel.evaluate = kernel.evaluate_mixed;
        step->with(kernel);
        step->with(kernel);
      }
      SCOPED_TRACE(choice);
      EXPECT_GT(largest(start.force), 0.0);
      EXPECT_EQ(wide.force, start.force);
      EXPECT_EQ(wide.torque, start.torque);
      EXPECT_EQ(wide.damping, start.damping);
      EXPECT_EQ(wide.list.touching, start.list.touching);
      EXPECT_EQ(wide.list.displacement, start.list.displacement);
    }
}

TEST(Kernel, OfEveryImplementationListsTheSamePartners)
{
  const Cloud cloud = random_cloud({3000, 0.5, 0.01, 0.03, 1, 500}, 16);
  PairList plain;
  build_within(plain, cloud, 0.01, implementations()[0].list_partners);
  ASSERT_GT(plain.entries, 10000);
  for (const Implementation& kernel : kernels()) {
    PairList list;
    build_within(list, cloud, 0.01, kernel.list_partners);
    EXPECT_EQ(list.other, plain.other) << kernel.name;
  }
}

TEST(RowStore, HoldsTheRowsOfAPrecisionAndVelocitiesOfBothIfAsked)
{
  RowStore store;
  const Rows both = store.resize(3, true, true);
  EXPECT_TRUE(both.velocity && both.single_velocity && both.single_force && !both.force);
  RowStore single;
  EXPECT_FALSE(single.resize(3, true).velocity);
}

TEST(Kernel, LimitsTheDampingByThatOfTheStepBefore)
{
  for (const Implementation& kernel : kernels()) {
    Evaluation free(random_cloud({150, 0.2}, 4));
    free.terms.rolling = false;
    Evaluation limited = free, again = free;
    limited.terms.limited_damping = again.terms.limited_damping = true;
    std::fill(limited.damping.begin(), limited.damping.end(), 0.0);
    for (Evaluation* step : {&free, &limited, &again}) step->with(kernel);
    EXPECT_EQ(limited.force, free.force) << "without damping before there is nothing to limit";
    EXPECT_NE(again.force, free.force);
    EXPECT_GT(*std::max_element(limited.damping.begin(), limited.damping.end()), 0.0);
  }
}

TEST(Kernel, GivesGhostsNoForceAndTheirPartnersAllOfIt)
{
  const Cloud cloud = random_cloud({300, 0.25, 0.01, 0.03, 2, 120}, 5);
  for (const Implementation& kernel : kernels()) {
    const Evaluation start(cloud);
    expect_as_naive(start, kernel);
    Evaluation step = start;
    step.with(kernel);
    for (int j = cloud.nlocal(); j < cloud.all(); ++j)
      for (int d = 0; d < 3; ++d) {
        EXPECT_EQ(step.force[j][d], 0.0);
        EXPECT_EQ(step.torque[j][d], 0.0);
      }
  }
}

TEST(Kernel, AddsToWhatIsThere)
{
  for (const Implementation& kernel : kernels()) {
    Evaluation once(random_cloud({100, 0.2}, 6));
    once.advance = false;
    Evaluation twice = once;
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
  for (const Implementation& kernel : kernels()) {
    Evaluation start(cloud);
    std::fill(start.list.displacement.begin(), start.list.displacement.end(), 0.0);
    expect_as_naive(start, kernel);
    start.with(kernel);
    EXPECT_GT(largest(start.force), 1.0);
    EXPECT_EQ(largest(start.torque), 0.0);
  }
}

TEST(Kernel, ResetsTheHistoryAtSeparationOnlyIfAsked)
{
  for (const Implementation& kernel : kernels())
    for (const bool reset : {true, false}) {
      Evaluation step(separate_pairs(20, 8));
      step.reset_on_separation = reset;
      std::fill(step.list.touching.begin(), step.list.touching.end(), 1);
      expect_as_naive(step, kernel);
      step.with(kernel);
      for (auto* field : {&step.cloud.velocity, &step.cloud.spin})
        std::fill(field->begin(), field->end(), std::array<double, 3>{});
      int separated = 0;
      for (int pair = 1; pair < 40; pair += 2) {  // every second pair is separated
        const int entry = step.list.first[2 * pair];
        ASSERT_EQ(step.list.other[entry], 2 * pair + 1);
        EXPECT_EQ(step.list.touching[entry], reset ? 0 : 1);
        step.cloud.position[2 * pair + 1][1] *= 0.97;  // in contact again
        ++separated;
      }
      EXPECT_EQ(separated, 20);
      expect_as_naive(step, kernel);
      step.with(kernel);
      for (int pair = 1; pair < 40; pair += 2) {
        const double* history = &step.list.displacement[3 * step.list.first[2 * pair]];
        EXPECT_EQ(history[0] == 0.0 && history[1] == 0.0 && history[2] == 0.0, reset);
      }
    }
}

TEST(Kernel, AtSetUpUsesHistoriesAndKeepsThem)
{
  for (const Implementation& kernel : kernels()) {
    Evaluation step(random_cloud({200, 0.25, 0.01, 0.03, 2}, 9));
    step.advance = step.reset_on_separation = false;
    expect_as_naive(step, kernel);
    std::fill(step.list.touching.begin(), step.list.touching.end(), 1);
    const std::vector<double> before = step.list.displacement;
    step.with(kernel);
    EXPECT_EQ(step.list.displacement, before);
  }
}

TEST(Kernel, GivesBallsThatBarelyTouchAFiniteForce)
{
  // The separation is the sum of the radii within a few rounding errors. Each kernel must decide
  // contact consistently: for an overlap below 0 the square root is not finite.
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
  for (const Implementation& kernel : kernels()) {
    Evaluation step(cloud, 1e-4);
    ASSERT_EQ(step.list.entries, 20000);
    step.with(kernel);
    for (const auto& row : step.force)
      for (const double value : row) ASSERT_TRUE(std::isfinite(value)) << kernel.name;
    for (const double value : step.list.displacement)
      ASSERT_TRUE(std::isfinite(value)) << kernel.name;
    EXPECT_LT(largest(step.force), 1e-9);
  }
}

}  // namespace
