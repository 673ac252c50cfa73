#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/similarity/rotation.h"

namespace {

using millscale::similarity::Rotation;

Rotation turning_since(double start)
{
  Rotation mill;
  mill.omega = 1.1;
  mill.start = start;
  mill.dt = 1e-5;
  return mill;
}

TEST(Rotation, StandsStillUntilItsStart)
{
  const Rotation mill = turning_since(0.5);
  EXPECT_EQ(mill.angle(50000), 0.0);
  EXPECT_EQ(mill.speed(50000), 0.0);
  EXPECT_GT(mill.angle(50001), 0.0);
  EXPECT_EQ(mill.speed(50001), 1.1);
}

TEST(Rotation, AngleAfterTenMillionStepsIsExactToRoundOff)
{
  const Rotation mill = turning_since(0.0);
  const double expected = 1.1 * (10'000'000 * 1e-5);
  // Three roundings (two products and a sum), each with a relative error of 2^-53.
  EXPECT_NEAR(mill.angle(10'000'000), expected, 3.0 * std::ldexp(expected, -53));

  double summed = 0.0;  // result of accumulated increments
  for (int step = 0; step < 10'000'000; ++step) summed += 1.1 * 1e-5;
  EXPECT_GT(std::abs(summed - expected), 1e3 * std::ldexp(expected, -53));
}

TEST(Rotation, ChangingTheStepSizeKeepsTimeAndAngle)
{
  Rotation mill = turning_since(0.1);
  const double angle = mill.angle(20000), time = mill.time(20000);
  mill.set_step_size(20000, 2e-5);
  EXPECT_DOUBLE_EQ(mill.angle(20000), angle);
  EXPECT_DOUBLE_EQ(mill.time(20000), time);
  EXPECT_NEAR(mill.angle(30000), angle + 1.1 * 10000 * 2e-5, 1e-13);
}

TEST(Rotation, RenumberingTheStepsKeepsTimeAndAngle)
{
  Rotation mill = turning_since(0.1);
  const double angle = mill.angle(20000), time = mill.time(20000);
  mill.renumber(20000, 0);
  EXPECT_DOUBLE_EQ(mill.time(0), time);
  EXPECT_DOUBLE_EQ(mill.angle(0), angle);
}

TEST(Rotation, ChangingTheSpeedKeepsTheAngle)
{
  Rotation mill = turning_since(0.1);
  const double angle = mill.angle(20000);
  mill.set_speed(20000, 2.2);
  EXPECT_DOUBLE_EQ(mill.angle(20000), angle);
  EXPECT_NEAR(mill.angle(30000), angle + 2.2 * 10000 * 1e-5, 1e-13);

  Rotation waiting = turning_since(0.5);
  waiting.set_speed(20000, 2.2);
  EXPECT_EQ(waiting.angle(50000), 0.0);
}

TEST(Rotation, NeverStartsAtAnInfiniteTime)
{
  const Rotation mill = turning_since(std::numeric_limits<double>::infinity());
  EXPECT_EQ(mill.angle(1'000'000'000), 0.0);
  EXPECT_FALSE(mill.turning(1'000'000'000));
}

}  // namespace
