#include <gtest/gtest.h>

#include <random>

#include "core/liner/paper_liners.h"
#include "core/measure/monitoring_box.h"

namespace {

using millscale::charge::MonitoringBox;
using namespace millscale::liner;

/// Return whether a point is inside a quadrilateral: left of all four sides or right of all.
bool inside(const std::array<Point, 4>& corner, Point p)
{
  int left = 0;
  for (int i = 0; i < 4; ++i) {
    const Point side = corner[(i + 1) % 4] - corner[i], to = p - corner[i];
    left += side.x * to.z - side.z * to.x > 0.0;
  }
  return left == 0 || left == 4;
}

TEST(MonitoringBox, HoldsWhatLiesBetweenTheCornersOfTheGroove)
{
  std::mt19937 random(5);
  for (const Lifters& liner : millscale::test::various_liners()) {
    if (liner.lifters() == 0) continue;
    const MonitoringBox box(liner);
    const auto corner = groove_box(liner);
    const Frame middle(liner.groove_angle(0));
    std::uniform_real_distribution<double> anywhere(-1.1 * liner.radius(), 1.1 * liner.radius());
    int within = 0;
    for (int i = 0; i < 20000; ++i) {
      const Point p{anywhere(random), anywhere(random)};
      within += inside(corner, p);
      EXPECT_EQ(box.holds(middle.local(p)), inside(corner, p)) << p.x << ' ' << p.z;
    }
    EXPECT_GT(within, 10);
  }
}

TEST(MonitoringBox, HoldsNothingCloserToTheAxisThanItsInnerLine)
{
  const MonitoringBox box(millscale::test::trapezoid_mill());
  EXPECT_TRUE(box.holds({box.inner(), 0.0}));
  EXPECT_FALSE(box.holds({std::nextafter(box.inner(), 0.0), 0.0}));
  EXPECT_LT(box.inner(), 3.61);
}

TEST(MonitoringBox, NeedsAGroove)
{
  EXPECT_THROW(MonitoringBox(Lifters(Widths{2.0})), std::invalid_argument);
}

}  // namespace
