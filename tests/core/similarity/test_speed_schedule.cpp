#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <vector>

#include "core/similarity/rotation.h"
#include "core/similarity/speed_schedule.h"

namespace {

using millscale::similarity::Rotation;
using millscale::similarity::SpeedChange;
using millscale::similarity::SpeedSchedule;

constexpr double quarter = 1.5707963267948966;
// A ramp over a quarter turn, then slower at once, then faster over half a radian.
const std::vector<SpeedChange> all{{0.0, quarter, 1.0}, {4.0, 0.0, 0.7}, {7.0, 0.5, 1.3}};

TEST(SpeedSchedule, WithoutChangesTheAngleIsThePhaseBitByBit)
{
  const SpeedSchedule constant;
  for (const double phase : {0.0, 0.1, 3.3, 1e7 / 3.0}) {
    EXPECT_EQ(constant.angle(phase), phase);
    EXPECT_EQ(constant.phase(phase), phase);
    EXPECT_EQ(constant.speed(phase), 1.0);
  }
  EXPECT_EQ(constant.steady_from(), 0.0);
}

TEST(SpeedSchedule, ARampIsThatOfConstantAcceleration)
{
  const SpeedSchedule ramp({{0.0, quarter, 1.0}});
  // angle = phase^2 / (2 T), with T = 2 * quarter, from rest to full speed.
  for (const double phase : {0.0, 0.3, 1.7, 3.1}) {
    EXPECT_DOUBLE_EQ(ramp.angle(phase), phase * phase / (4.0 * quarter));
    EXPECT_DOUBLE_EQ(ramp.speed(phase), phase / (2.0 * quarter));
  }
  EXPECT_DOUBLE_EQ(ramp.angle(2.0 * quarter), quarter);
  EXPECT_DOUBLE_EQ(ramp.angle(10.0), 10.0 - quarter);
  EXPECT_EQ(ramp.speed(10.0), 1.0);
  EXPECT_EQ(ramp.steady_from(), quarter);
}

TEST(SpeedSchedule, TheSpeedIsTheDerivativeOfTheAngleAndPhaseItsInverse)
{
  const SpeedSchedule speed(all);
  const double h = 1e-6;
  for (double phase = 0.01; phase < 15.0; phase += 0.0937) {
    // The quotient is wrong by a jump only within h of it.
    EXPECT_NEAR((speed.angle(phase + h) - speed.angle(phase - h)) / (2.0 * h), speed.speed(phase),
                1e-8);
    EXPECT_NEAR(speed.phase(speed.angle(phase)), phase, 1e-14 * 15.0);
  }
  EXPECT_EQ(speed.fastest(), 1.3);
  EXPECT_EQ(speed.last_ratio(), 1.3);
  EXPECT_EQ(speed.steady_from(), 7.5);
  EXPECT_NEAR(speed.speed(speed.phase(5.0)), 0.7, 1e-15);
}

TEST(SpeedSchedule, TheRestOfAScheduleContinuesIt)
{
  const SpeedSchedule whole(all);
  for (const double angle : {0.0, 0.4, quarter, 3.0, 4.0, 7.2, 9.0}) {
    const SpeedSchedule rest = whole.after(angle);
    for (double more = 0.0; more < 6.0; more += 0.31) {
      const double phase = whole.phase(angle) + more;
      EXPECT_NEAR(angle + rest.angle(more), whole.angle(phase), 1e-13) << angle << " " << more;
      EXPECT_NEAR(rest.speed(more + 1e-9), whole.speed(phase + 1e-9), 1e-8);
    }
  }
}

TEST(SpeedSchedule, RefusesWhatIsNoSchedule)
{
  using Changes = std::vector<SpeedChange>;
  for (const Changes& wrong :
       {Changes{{0.0, 1.0, 0.0}}, Changes{{-1.0, 1.0, 1.0}}, Changes{{0.0, -1.0, 1.0}},
        Changes{{2.0, 1.0, 0.5}, {2.5, 0.0, 1.0}}, Changes{{0.0, NAN, 1.0}}})
    EXPECT_THROW(SpeedSchedule{wrong}, std::invalid_argument);
}

Rotation turning(double omega)
{
  Rotation mill;
  mill.omega = omega;
  mill.start = 0.5;
  mill.dt = 1e-5;
  mill.schedule = SpeedSchedule(all);
  return mill;
}

TEST(RotationWithChanges, StartsFromRestAndSpeedIsThatOfThePhase)
{
  const Rotation mill = turning(1.1);
  EXPECT_EQ(mill.angle(50000), 0.0);
  EXPECT_EQ(mill.speed(50000), 0.0);
  EXPECT_NEAR(mill.angle(150000), SpeedSchedule(all).angle(1.1), 1e-14);
  EXPECT_NEAR(mill.speed(2'000'000), 1.1 * 1.3, 1e-15);
}

TEST(RotationWithChanges, StepAtIsTheStepNearestToAnAngle)
{
  const Rotation mill = turning(1.1);
  for (double angle = 0.05; angle < 12.0; angle += 0.21) {
    const auto step = static_cast<std::int64_t>(mill.step_at(angle));
    const double off = std::abs(mill.angle(step) - angle);
    EXPECT_LE(off, std::abs(mill.angle(step - 1) - angle) * (1.0 + 1e-4)) << angle;
    EXPECT_LE(off, std::abs(mill.angle(step + 1) - angle) * (1.0 + 1e-4)) << angle;
  }
  // Half steps are rounded down, whatever rounding makes of them.
  EXPECT_EQ(Rotation::nearest_step(62.5), 62.0);
  EXPECT_EQ(Rotation::nearest_step(62.5 + 1e-9), 62.0);
  EXPECT_EQ(Rotation::nearest_step(62.51), 63.0);
}

TEST(RotationWithChanges, AnotherSpeedKeepsAngleAndSchedule)
{
  Rotation mill = turning(1.1);
  const std::int64_t step = 100000;  // in the ramp
  const double angle = mill.angle(step), ratio = mill.speed(step) / 1.1;
  mill.set_speed(step, 2.2, SpeedSchedule(all));
  EXPECT_DOUBLE_EQ(mill.angle(step), angle);
  EXPECT_NEAR(mill.speed(step + 1), 2.2 * ratio, 1e-3);
  // The changes are at the same mill angles as before.
  EXPECT_NEAR(mill.speed(static_cast<std::int64_t>(mill.step_at(5.0))), 2.2 * 0.7, 1e-14);
  EXPECT_NEAR(mill.angle(static_cast<std::int64_t>(mill.step_at(5.0))), 5.0, 2.2 * 1e-5);
}

}  // namespace
