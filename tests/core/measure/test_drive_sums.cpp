#include <gtest/gtest.h>

#include <cmath>

#include "core/measure/drive_sums.h"

namespace {

using millscale::charge::DriveSums;

TEST(DriveSums, EqualTheChangeOfAngularMomentumUnderVelocityVerlet)
{
  // A flywheel under a torque that depends on its angle and alternates from step to step.
  const double dt = 1e-3, inertia = 0.7, omega = 2.0;
  const auto torque = [](double angle, int step) { return std::sin(angle) + 0.4 * (step % 2); };
  double angle = 0.3, spin = 1.1;
  const double spin_before = spin;
  double now = torque(angle, 0);
  DriveSums sums;
  sums.wait_for(now, now * omega, dt);
  for (int step = 1; step <= 1000; ++step) {
    spin += 0.5 * dt * now / inertia;
    angle += dt * spin;
    now = torque(angle, step);
    spin += 0.5 * dt * now / inertia;
    sums.add(now, now * omega, dt, step);
    ASSERT_NEAR(sums.impulse(), inertia * (spin - spin_before), 1e-13);
  }
  EXPECT_NEAR(sums.work(), omega * sums.impulse(), 1e-13);
}

TEST(DriveSums, TellTheAlternatingPartOfATorque)
{
  for (const int steps : {1, 2, 7, 30, 31})
    for (const int last : {100, 101}) {
      DriveSums sums;
      sums.add(50.0, 0.0, 1.0, last - steps);  // of the previous interval
      sums.begin_interval();
      for (int step = last - steps + 1; step <= last; ++step)
        sums.add(5.0 + (step % 2 == 0 ? 0.25 : -0.25), 0.0, 1.0, step);
      EXPECT_NEAR(sums.alternating(last, steps), steps > 1 ? 0.25 : 0.0, 1e-14) << steps;
    }
}

TEST(DriveSums, OfTwoRanksAddUp)
{
  DriveSums all, one, other;
  for (int step = 0; step < 20; ++step) {
    all.add(3.0 + step, 2.0 * step, 0.1, step);
    one.add(1.0, 0.5 * step, 0.1, step);
    other.add(2.0 + step, 1.5 * step, 0.1, step);
  }
  EXPECT_NEAR(all.impulse(), one.impulse() + other.impulse(), 1e-13);
  EXPECT_NEAR(all.work(), one.work() + other.work(), 1e-13);
  EXPECT_NEAR(all.alternating(19, 20), one.alternating(19, 20) + other.alternating(19, 20), 1e-13);
  one += other;
  EXPECT_NEAR(all.impulse(), one.impulse(), 1e-13);
  EXPECT_NEAR(all.work(), one.work(), 1e-13);
  EXPECT_NEAR(all.alternating(19, 20), one.alternating(19, 20), 1e-13);
  for (DriveSums* sums : {&all, &one}) sums->add(0.0, 0.0, 0.1, 20);
  EXPECT_NEAR(all.impulse(), one.impulse(), 1e-13);
}

}  // namespace
