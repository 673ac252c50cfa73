#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "core/similarity/operating_point.h"

namespace {

using namespace millscale::similarity;

TEST(OperatingPoint, DetachAngleBalancesGravityAndCentrifugalForce)
{
  const double froude = froude_number(3.9, 9.81, 1.0);
  const double angle = detach_angle(froude);
  EXPECT_NEAR(9.81 * std::cos(angle), 3.9, 1e-14);
  EXPECT_NEAR(angle * 180.0 / 3.14159265358979323846, 66.57, 0.01);
}

TEST(OperatingPoint, DetachAngleHasItsLimits)
{
  EXPECT_DOUBLE_EQ(detach_angle(1.0), 0.0);
  EXPECT_DOUBLE_EQ(detach_angle(0.0), std::acos(0.0));
  EXPECT_THROW(detach_angle(1.01), std::domain_error);
  EXPECT_THROW(detach_angle(-0.01), std::domain_error);
  EXPECT_THROW(detach_angle(NAN), std::domain_error);
}

TEST(OperatingPoint, AtCriticalSpeedTheCentrePathHasFroudeOne)
{
  const OperatingPoint mill{3.9, 0.02, 9.81, 1.0};
  EXPECT_NEAR(froude_number(3.88, 9.81, critical_speed(mill)), 1.0, 1e-14);
}

TEST(OperatingPoint, RegimeFollowsTheFroudeNumber)
{
  EXPECT_EQ(regime(0.05), Regime::slipping_or_cascading);
  EXPECT_EQ(regime(0.4), Regime::cataracting);
  EXPECT_EQ(regime(1.0), Regime::centrifuging);
  EXPECT_STREQ(name(regime(0.4)), "cataracting");
}

}  // namespace
