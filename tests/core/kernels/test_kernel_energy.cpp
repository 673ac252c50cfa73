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

/// A step whose contacts have loads and works, and what a kernel recorded.
struct Recorded {
  Evaluation step;
  std::vector<EndedContact> ended;
  WorkRecord record{};

  explicit Recorded(const Evaluation& start) : step(start), ended(step.list.entries)
  {
    step.list.work.resize(step.list.other.size());
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    for (ContactWork& work : step.list.work) {
      for (auto* vector : {&work.force, &work.torque_i, &work.torque_j})
        for (double& number : *vector) number = normal(random);
      work.dissipated = normal(random);
      work.available = std::abs(normal(random));
      work.stored = 1.0;
    }
    record = {step.list.work.data(), ended.data(), 0, 0.5 * dt, 0.0};
  }
  void with(const Implementation& kernel, bool rows)
  {
    step.record = &record;
    rows ? step.with_rows(kernel) : step.with(kernel);
    ended.resize(record.count);
  }
};

void expect_same(const Recorded& got, const Recorded& expected, double tolerance)
{
  // A load is known to the rounding of the largest force, as in test_kernel.cpp.
  const double force = largest(expected.step.force), torque = largest(expected.step.torque);
  const double energy = dt * (force + torque) * 5.0;  // speeds of some m/s and rad/s
  ASSERT_EQ(got.ended.size(), expected.ended.size());
  for (std::size_t k = 0; k < got.ended.size(); ++k) {
    EXPECT_EQ(got.ended[k].i, expected.ended[k].i);
    EXPECT_EQ(got.ended[k].j, expected.ended[k].j);
    EXPECT_NEAR(got.ended[k].dissipated, expected.ended[k].dissipated, 1e-12);
    EXPECT_EQ(got.ended[k].available, expected.ended[k].available);
  }
  const double total = std::abs(expected.record.total);
  EXPECT_NEAR(got.record.total, expected.record.total, tolerance * (total + energy));
  int contacts = 0;
  for (int entry = 0; entry < got.step.list.entries; ++entry) {
    if (!got.step.list.touching[entry]) continue;
    ++contacts;
    const ContactWork &a = got.step.list.work[entry], &b = expected.step.list.work[entry];
    for (int d = 0; d < 3; ++d) {
      EXPECT_NEAR(a.force[d], b.force[d], tolerance * force);
      EXPECT_NEAR(a.torque_i[d], b.torque_i[d], tolerance * torque);
      EXPECT_NEAR(a.torque_j[d], b.torque_j[d], tolerance * torque);
    }
    EXPECT_NEAR(a.dissipated, b.dissipated, tolerance * (std::abs(b.dissipated) + energy));
    EXPECT_NEAR(a.available, b.available, tolerance * (b.available + 1.0));
    EXPECT_NEAR(a.stored, b.stored, tolerance * (b.stored + 1.0));
  }
  EXPECT_GT(contacts, 100);
  EXPECT_GT(expected.ended.size(), 10u);
}

TEST(WorkRecord, OfEveryImplementationIsThatOfThePlainest)
{
  for (const bool limited : {false, true})
    for (const int types : {1, 2}) {
      Evaluation start(random_cloud({300, 0.3, 0.01, 0.03, types, 60}, 17));
      start.terms.limited_damping = limited;
      Recorded plain(start);
      plain.with(implementations()[0], false);
      for (const Implementation& kernel : kernels())
        for (const bool rows : {false, true}) {
          if (rows && !kernel.evaluate_rows) continue;
          SCOPED_TRACE(std::string(kernel.name) + (rows ? " of rows" : ""));
          Recorded got(start);
          got.with(kernel, rows);
          expect_same(got, plain, is_mixed(kernel) ? 1.2e-6 : 1e-12);
        }
    }
}

TEST(WorkRecord, ChangesNoForceAndNoHistory)
{
  for (const Implementation& kernel : kernels()) {
    const Evaluation start = mixed(15);
    Evaluation without = start;
    without.with(kernel);
    Recorded got(start);
    got.with(kernel, false);
    EXPECT_EQ(got.step.force, without.force);
    EXPECT_EQ(got.step.torque, without.torque);
    EXPECT_EQ(got.step.list.displacement, without.list.displacement);
    EXPECT_EQ(got.step.list.touching, without.list.touching);
  }
}

/// The work is that of the loads of the budget, which are summed by ball.
TEST(WorkRecord, IsTheWorkOfTheLoadsOfTheBudget)
{
  Evaluation start = mixed(0);
  Recorded got(start);
  for (ContactWork& work : got.step.list.work) work = {};
  for (int entry = 0; entry < got.step.list.entries; ++entry)  // none ends
    got.step.list.touching[entry] &=
        overlap(got.step.cloud.view(), got.step.list.own[entry], got.step.list.other[entry]);
  got.step.record = &got.record;
  PairSums sums;
  got.step.with(implementations()[0], &sums);
  double power = 0.0;
  for (int i = 0; i < got.step.cloud.nlocal(); ++i)
    for (const int kind : {contact::normal_dashpot, contact::tangential_spring,
                           contact::tangential_dashpot, contact::rolling})
      power +=
          contact::power(sums.loads[i][kind], got.step.cloud.velocity[i], got.step.cloud.spin[i]);
  ASSERT_NE(power, 0.0);
  EXPECT_NEAR(got.record.total, -0.5 * dt * power, 1e-12 * std::abs(0.5 * dt * power));
}

}  // namespace
