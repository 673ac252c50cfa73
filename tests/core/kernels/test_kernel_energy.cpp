#include <gtest/gtest.h>

#include <cstring>

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
    PairList& list = step.list;
    list.records_work = true;
    list.reserve(list.other.size());
    std::mt19937 random(3);
    std::normal_distribution<float> normal;
    for_each_contact(list, [&](int entry, int number) {
      ContactWork work;
      for (auto* vector : {&work.force, &work.torque})
        for (float& load : *vector) load = normal(random);
      work.dissipated = normal(random);
      list.work.columns().set(number, work);
      list.available[entry] = std::abs(normal(random));
    });
    record = {list.work.columns(), list.next_work.columns(), list.available.data(), ended.data(),
              0.5 * dt};
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
  const double total = std::abs(expected.record.total());
  EXPECT_NEAR(got.record.total(), expected.record.total(), tolerance * (total + energy));
  // What is kept is rounded to single precision, and may be rounded to either side.
  const double kept = std::fmax(tolerance, 1.2e-7);
  int contacts = 0;
  for_each_contact(got.step.list, [&](int entry, int number) {
    ++contacts;
    const ContactWork a = got.step.list.next_work.get(number);
    const ContactWork b = expected.step.list.next_work.get(number);
    for (int d = 0; d < 3; ++d) {
      EXPECT_NEAR(a.force[d], b.force[d], kept * force);
      EXPECT_NEAR(a.torque[d], b.torque[d], kept * torque);
    }
    EXPECT_NEAR(a.dissipated, b.dissipated, tolerance * (std::abs(b.dissipated) + energy));
    const double available = expected.step.list.available[entry];
    EXPECT_NEAR(got.step.list.available[entry], available, 1e-12 * available);
  });
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

/// The implementations of both packs give the same bits, sums included.
TEST(WorkRecord, HasTheSameBitsInPacksOfAnyWidth)
{
  const Implementation* narrow = find_implementation("x86-64-v3");
  const Implementation* wide = find_implementation("x86-64-v4");
  if (!narrow || !wide) GTEST_SKIP() << "this machine has packs of one width";
  for (const bool single : {false, true}) {
    Evaluation start(random_cloud({300, 0.3, 0.01, 0.03, 2, 60}, 17));
    Recorded a(start), b(start);
    for (auto [got, kernel] : {std::pair(&a, *narrow), std::pair(&b, *wide)}) {
      if (single) {
        kernel.evaluate = kernel.evaluate_mixed;
        kernel.evaluate_rows = kernel.evaluate_rows_mixed;
      }
      got->with(kernel, true);
    }
    EXPECT_EQ(a.record.total(), b.record.total());
    for_each_contact(a.step.list, [&](int, int number) {
      const ContactWork of_a = a.step.list.next_work.get(number);
      const ContactWork of_b = b.step.list.next_work.get(number);
      EXPECT_EQ(std::memcmp(&of_a, &of_b, sizeof of_a), 0);
    });
  }
}

/// Two halves of the work of loads, of a step and of the next one, are that of the budget, which
/// sums loads by ball, at the velocities before and after.
TEST(WorkRecord, IsTheWorkOfTheLoadsOfTheBudget)
{
  Evaluation start = mixed(0);
  for (int entry = 0; entry < start.list.entries; ++entry)  // none ends
    start.list.touching[entry] &=
        overlap(start.cloud.view(), start.list.own[entry], start.list.other[entry]);
  Recorded got(start);
  PairList& list = got.step.list;
  for_each_contact(list, [&](int, int number) { list.work.columns().set(number, {}); });
  got.step.record = &got.record;
  PairSums sums;
  got.step.with(implementations()[0], &sums);
  Cloud& balls = got.step.cloud;
  const auto work = [&] {
    double power = 0.0;
    for (int i = 0; i < balls.nlocal(); ++i)
      for (const int kind : {contact::normal_dashpot, contact::tangential_spring,
                             contact::tangential_dashpot, contact::rolling})
        power += contact::power(sums.loads[i][kind], balls.velocity[i], balls.spin[i]);
    return -0.5 * dt * power;
  };
  const double before = work();
  ASSERT_NE(before, 0.0);
  // The velocities that the balls gain, and the places that they reach.
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0.0, 0.1);
  for (int i = 0; i < balls.nlocal(); ++i)
    for (int d = 0; d < 3; ++d) {
      balls.velocity[i][d] += normal(random);
      balls.spin[i][d] += normal(random);
    }
  const double after = work();
  for (int i = 0; i < balls.nlocal(); ++i)
    for (int d = 0; d < 3; ++d) balls.position[i][d] += dt * balls.velocity[i][d];
  // Only what is kept: a step in which all contacts end.
  WorkRecord next{list.next_work.columns(), list.work.columns(), list.available.data(),
                  got.ended.data(), 0.5 * dt};
  for_each_contact(list, [&](int entry, int number) {
    const int i = list.own[entry], j = list.other[entry];
    using millscale::vector3;
    contact::BallPair<double> pair{};
    pair.separation = vector3(balls.position[i]) - vector3(balls.position[j]);
    pair.r2 = dot(pair.separation, pair.separation);
    pair.radius_i = balls.radius[i];
    pair.radius_j = balls.radius[j];
    pair.velocity = vector3(balls.velocity[i]) - vector3(balls.velocity[j]);
    pair.spin_i = vector3(balls.spin[i]);
    pair.spin_j = vector3(balls.spin[j]);
    next.end(entry, number, i, j, 1.0, pair);
  });
  // The rounding of the loads meets only the change of the velocity.
  const double scale = std::abs(before), change = std::abs(after - before);
  EXPECT_NEAR(got.record.total() + next.total(), before + after, 1e-7 * change + 1e-11 * scale);
  EXPECT_GT(change, 1e-3 * scale);
}

}  // namespace
