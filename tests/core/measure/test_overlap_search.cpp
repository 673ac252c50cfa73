#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "core/measure/overlap_search.h"

namespace {

using millscale::charge::OverlapSearch;
using millscale::charge::Sphere;

double of_all_pairs(const std::vector<Sphere>& s)
{
  double largest = 0.0;
  for (std::size_t i = 0; i < s.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      largest =
          std::max(largest, s[i].radius + s[j].radius -
                                std::hypot(s[i].x - s[j].x, s[i].y - s[j].y, s[i].z - s[j].z));
  return largest;
}

double searched(OverlapSearch& search, const std::vector<Sphere>& spheres)
{
  search.clear();
  for (const Sphere& s : spheres) search.add(s);
  return search.largest();
}

TEST(OverlapSearch, EqualsAllPairsInRandomChargesOfAllShapes)
{
  std::mt19937 random(3);
  OverlapSearch search;  // reused: earlier trials must not affect it
  for (int trial = 0; trial < 300; ++trial) {
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    const double size[3] = {0.1 + unit(random), 0.1 + unit(random), 0.1 + unit(random)};
    const double smallest = trial % 3 == 0 ? 0.2 : 1.0;  // a size ratio of five in every third
    std::vector<Sphere> spheres(2 + random() % 60);
    for (Sphere& s : spheres)
      s = {size[0] * unit(random) - 5.0, size[1] * unit(random), size[2] * unit(random) + 2.0,
           0.03 * (smallest + (1.0 - smallest) * unit(random))};
    // The same arithmetic except for the order of two additions.
    EXPECT_NEAR(searched(search, spheres), of_all_pairs(spheres), 1e-15);
  }
}

TEST(OverlapSearch, FindsAPairAcrossEveryBorderOfACell)
{
  OverlapSearch search;
  for (int dx = -1; dx <= 1; ++dx)
    for (int dy = -1; dy <= 1; ++dy)
      for (int dz = -1; dz <= 1; ++dz) {
        if (dx == 0 && dy == 0 && dz == 0) continue;
        const double apart = 1.9 / std::sqrt(dx * dx + dy * dy + dz * dz);
        // Cells are 2 wide and begin at the corner sphere; the pair lies around the corner (4, 4,
        // 4) of cells.
        const std::vector<Sphere> spheres{
            {0, 0, 0, 1},
            {10, 10, 10, 1},
            {4 - 0.5 * apart * dx, 4 - 0.5 * apart * dy, 4 - 0.5 * apart * dz, 1},
            {4 + 0.5 * apart * dx, 4 + 0.5 * apart * dy, 4 + 0.5 * apart * dz, 1}};
        EXPECT_NEAR(searched(search, spheres), 0.1, 1e-14);
      }
}

TEST(OverlapSearch, IsZeroWhereNothingTouches)
{
  OverlapSearch search;
  EXPECT_EQ(searched(search, {}), 0.0);
  EXPECT_EQ(searched(search, {{0, 0, 0, 1}}), 0.0);
  EXPECT_EQ(searched(search, {{0, 0, 0, 1}, {2.0, 0, 0, 1}}), 0.0);
}

TEST(OverlapSearch, LeavesOutPairsOfTwoGhosts)
{
  OverlapSearch search;
  const Sphere local{0, 0, 0, 1}, ghost{1.5, 0, 0, 1, true}, image{1.5, 1.2, 0, 1, true};
  EXPECT_EQ(searched(search, {local, ghost, image}), 0.5);
  EXPECT_EQ(searched(search, {ghost, image}), 0.0);
}

TEST(OverlapSearch, FindsTheLargerOfTwoOverlapsThatDifferByRounding)
{
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  OverlapSearch search;
  for (int trial = 0; trial < 2000; ++trial) {
    // A pair of large spheres, and one of small spheres whose overlap is known more exactly.
    const double large = 0.05 + 0.005 * unit(random);
    double small = 0.02 - (0.06 - large);
    for (int k = trial % 5; k > 0; --k) small = std::nextafter(small, 1.0);
    const double larger = std::max(0.06 - large, 0.02 - small);
    for (const double y : {-1.0, 1.0})  // of the small pair: it is found first or last
      EXPECT_EQ(
          searched(search,
                   {{0, 0, 0, 0.03}, {large, 0, 0, 0.03}, {0, y, 0, 0.01}, {small, y, 0, 0.01}}),
          larger);
  }
}

TEST(OverlapSearch, SurvivesABallFarAway)
{
  OverlapSearch search;
  EXPECT_NEAR(searched(search, {{0, 0, 0, 1}, {1.5, 0, 0, 1}, {1e7, -1e7, 1e7, 1}}), 0.5, 1e-15);
}

}  // namespace
