#include <gtest/gtest.h>

#include <cmath>

#include "core/measure/occupancy_grid.h"

namespace {

using namespace millscale::charge;
using millscale::pi;

double ball(double a)
{
  return 4.0 / 3.0 * pi * a * a * a;
}

TEST(OccupancyGrid, PutsABallWhereItsCentreIs)
{
  // Cells of 0.5 m and a quarter turn: from the top down the rising side, which is -x.
  OccupancyGrid grid({3, 4, 1.5});
  grid.add({-0.6, 0.7}, 0.1);   // top left: sector 0, distance 0.92: ring 1
  grid.add({-0.1, -0.1}, 0.2);  // bottom left: sector 1, ring 0
  grid.add({1.0, -1.0}, 0.3);   // bottom right: sector 2, ring 2
  grid.add({1.3, 0.9}, 0.4);    // top right, 1.58 m: beyond the last ring, counted in it
  const auto& v = grid.volumes();
  for (std::size_t i = 0; i < v.size(); ++i) {
    const double expected = i == 4    ? ball(0.1)
                            : i == 1  ? ball(0.2)
                            : i == 10 ? ball(0.3)
                            : i == 11 ? ball(0.4)
                                      : 0.0;
    EXPECT_DOUBLE_EQ(v[i], expected) << i;
  }
}

TEST(OccupancyGrid, HoldsEveryPointOnce)
{
  OccupancyGrid grid({4, 6, 1.0});
  int balls = 0;
  for (double x = -1.0; x <= 1.0; x += 0.25)
    for (double z = -1.0; z <= 1.0; z += 0.25, ++balls) grid.add({x, z}, 0.1);
  double sum = 0.0;
  for (double v : grid.volumes()) sum += v;
  EXPECT_NEAR(sum, balls * ball(0.1), 1e-12 * sum);
}

TEST(OccupancyGrid, GivesTheFractionOfTheCellsVolumeOfAnAverageSample)
{
  OccupancyGrid grid({2, 8, 3.0});
  for (int i = 0; i < 6; ++i) grid.add({-0.1, 2.0}, 0.1);
  const OccupancyCell c = grid.cell(8, grid.volumes(), 2.0, 0.7);
  EXPECT_DOUBLE_EQ(c.radius_low, 0.5);
  EXPECT_DOUBLE_EQ(c.radius_high, 1.0);
  EXPECT_DOUBLE_EQ(c.angle_low, 0.0);
  EXPECT_DOUBLE_EQ(c.angle_high, pi / 4);
  EXPECT_NEAR(c.solid_fraction, 3.0 * ball(0.1) / (pi * (9.0 - 2.25) / 8.0 * 0.7), 1e-14);
}

TEST(OccupancyGrid, OfNoCellsIsRefused)
{
  EXPECT_THROW(OccupancyGrid({0, 8, 1.0}), std::invalid_argument);
  EXPECT_THROW(OccupancyGrid({8, 0, 1.0}), std::invalid_argument);
  EXPECT_THROW(OccupancyGrid({8, 8, 0.0}), std::invalid_argument);
}

}  // namespace
