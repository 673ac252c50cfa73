#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/math/constants.h"
#include "core/math/mill_frame.h"

namespace {

using namespace millscale;

/// A frame of no special direction, and a position [m].
const MillFrame frame({2.0 / 7.0, 6.0 / 7.0, -3.0 / 7.0}, {6.0 / 7.0, -3.0 / 7.0, -2.0 / 7.0},
                      {0.3, -0.2, 0.1});
const Vector position{0.7, 1.1, -0.4};

void expect_near(const Vector& got, const Vector& expected)
{
  for (int d = 0; d < 3; ++d) EXPECT_NEAR(got[d], expected[d], 1e-15);
}

TEST(MillFrame, ComponentsGiveTheVectorBack)
{
  const Vector arm = frame.arm(position);
  expect_near(frame.vector(frame.components(arm)), arm);
}

TEST(MillFrame, TheDefaultAxisIsYAndTheBottomMovesToMinusX)
{
  const double bottom[] = {0.0, 0.0, -1.0}, onward[] = {-1.0, 0.0, 0.0};
  const MillFrame plain;
  EXPECT_EQ(plain.point(bottom).below, 1.0);
  EXPECT_EQ(plain.point(onward).ahead, 1.0);
}

TEST(MillFrame, APointThatTurnsWithTheMillRestsInTheTurningFrame)
{
  // Rodrigues' formula turns the point in space; both ways give the same point at rest.
  const MillPoint rest = frame.point(position.data());
  for (const double angle : {0.3, -2.0, 4.0}) {
    const Vector turned = rotated(frame.arm(position), frame.axis(), angle);
    const MillPoint back = frame.components(turned).in_turning_frame(Turn(angle));
    EXPECT_NEAR(back.ahead, rest.ahead, 1e-15);
    EXPECT_NEAR(back.below, rest.below, 1e-15);
    EXPECT_NEAR(back.along, rest.along, 1e-15);
    expect_near(frame.vector(rest.in_space(Turn(angle))), turned);
  }
}

}  // namespace
