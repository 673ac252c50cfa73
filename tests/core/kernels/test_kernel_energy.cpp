#include <gtest/gtest.h>

#include "core/kernels/evaluation.h"

namespace {

using namespace kernel_test;
using millscale::energy::PairSums;

constexpr double mixed_edge = 0.16;

Evaluation mixed(int ghosts, unsigned seed = 7)
{
  return Evaluation(random_cloud({60, mixed_edge, 0.015, 0.025, 2, ghosts}, seed));
}

TEST(KernelBudget, ChangesNoForceAndNoHistory)
{
  for (const bool limited : {false, true}) {
    Evaluation plain = mixed(15), with_budget = mixed(15);
    plain.terms.limited_damping = with_budget.terms.limited_damping = limited;
    PairSums sums;
    plain.with(implementations()[0]);
    with_budget.with(implementations()[0], &sums);
    EXPECT_EQ(plain.force, with_budget.force);
    EXPECT_EQ(plain.torque, with_budget.torque);
    EXPECT_EQ(plain.damping, with_budget.damping);
    EXPECT_EQ(plain.list.displacement, with_budget.list.displacement);
    EXPECT_EQ(plain.list.touching, with_budget.list.touching);
  }
}

TEST(KernelBudget, LoadsOfABallAddUpToItsForceAndTorque)
{
  Evaluation step = mixed(15);
  PairSums sums;
  step.with(implementations()[0], &sums);
  const double force = largest(step.force), torque = largest(step.torque);
  ASSERT_GT(force, 0.0);
  for (int i = 0; i < step.cloud.nlocal(); ++i)
    for (int d = 0; d < 3; ++d) {
      double f = 0.0, t = 0.0;
      for (const auto& load : sums.loads[i]) {
        f += load[d];
        t += load[3 + d];
      }
      EXPECT_NEAR(f, step.force[i][d], 1e-13 * force);
      EXPECT_NEAR(t, step.torque[i][d], 1e-13 * torque);
    }
}

/// Two ranks that each own half of the balls, with the other half as ghosts, have the same sum as
/// one rank.
TEST(KernelBudget, OfTwoRanksIsThatOfOne)
{
  Cloud cloud = random_cloud({60, mixed_edge, 0.02, 0.02, 1}, 5);
  const auto of = [](Cloud balls, int ghosts) {
    balls.ghosts = ghosts;
    Evaluation step(balls);
    std::fill(step.list.displacement.begin(), step.list.displacement.end(), 2e-5);
    for (int k = 0; k < step.list.entries; ++k) {  // the same half of the pairs on any rank
      const double r2 = step.separation_squared(step.list.own[k], step.list.other[k]);
      step.list.touching[k] = static_cast<int>(1e7 * r2) % 2;
    }
    PairSums sums;
    step.with(implementations()[0], &sums);
    return sums;
  };
  Cloud other;  // the second half first
  for (int k = 0; k < 60; ++k) {
    const int i = (k + 30) % 60;
    other.add(cloud.position[i], cloud.radius[i]);
    other.velocity.back() = cloud.velocity[i];
    other.spin.back() = cloud.spin[i];
  }
  const PairSums one = of(cloud, 0), first = of(cloud, 30), second = of(other, 30);
  ASSERT_GT(one.impacts, 5.0);
  ASSERT_GT(one.slip, 0.0);
  EXPECT_DOUBLE_EQ(first.impacts + second.impacts, one.impacts);
  const double e = 1e-12;  // sums of some tens of positive numbers
  EXPECT_NEAR(first.impact_energy + second.impact_energy, one.impact_energy, e * one.impact_energy);
  EXPECT_NEAR(first.normal_energy + second.normal_energy, one.normal_energy, e * one.normal_energy);
}

TEST(KernelBudget, AtSetUpNothingSlidesAndNoContactBegins)
{
  Evaluation step = mixed(0);
  std::fill(step.list.touching.begin(), step.list.touching.end(), 0);
  step.advance = false;
  PairSums sums;
  step.with(implementations()[0], &sums);
  EXPECT_GT(sums.normal_energy, 0.0);
  EXPECT_EQ(sums.slip, 0.0);
  EXPECT_EQ(sums.impacts, 0.0);
}

}  // namespace
