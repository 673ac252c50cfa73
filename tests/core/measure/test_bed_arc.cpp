#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <vector>

#include "core/measure/bed_arc.h"

namespace {

using millscale::charge::Arc;
using millscale::charge::bed_arc;

std::vector<double> step(std::size_t bins, Arc arc, double inside, double outside)
{
  std::vector<double> value(bins, outside);
  for (std::size_t i = 0; i < arc.count; ++i) value[(arc.first + i) % bins] = inside;
  return value;
}

/// Sum of squared residuals of the step with its best levels, by definition.
double misfit(const std::vector<double>& value, Arc arc)
{
  std::vector<double> in, out;
  for (std::size_t i = 0; i < value.size(); ++i) {
    const std::size_t from_first = (i + value.size() - arc.first) % value.size();
    (from_first < arc.count ? in : out).push_back(value[i]);
  }
  double sum = 0.0;
  for (const auto& part : {in, out}) {
    const double mean =
        std::accumulate(part.begin(), part.end(), 0.0) / static_cast<double>(part.size());
    for (double v : part) sum += (v - mean) * (v - mean);
  }
  return sum;
}

TEST(BedArc, FindsEveryStepExactly)
{
  for (std::size_t first = 0; first < 12; ++first)
    for (std::size_t count = 1; count < 12; ++count) {
      const auto arc = bed_arc(step(12, {first, count}, 5.0, 1.0));
      ASSERT_TRUE(arc);
      EXPECT_EQ(arc->first, first);
      EXPECT_EQ(arc->count, count);
    }
}

TEST(BedArc, IsNoneWhereAllIsEqual)
{
  EXPECT_FALSE(bed_arc(std::vector<double>(20, 0.0)));
  EXPECT_FALSE(bed_arc(std::vector<double>(20, 3.5)));
}

TEST(BedArc, IsNotSplitByAHoleNorDrawnOutByAStrayPeak)
{
  std::vector<double> value = step(100, {80, 40}, 6.0, 0.0);
  value[95] = 0.0;
  value[50] = 6.0;
  const auto arc = bed_arc(value);
  ASSERT_TRUE(arc);
  EXPECT_EQ(arc->first, 80u);
  EXPECT_EQ(arc->count, 40u);
}

TEST(BedArc, IsTheLeastSquaresStepOfANoisyCharge)
{
  // Counts of balls: the bed holds 6 a bin, the flying balls 1, both with the noise of counting.
  std::mt19937 random(7);
  std::poisson_distribution<int> bed(6.0), flying(1.0);
  for (int trial = 0; trial < 20; ++trial) {
    const Arc truth{static_cast<std::size_t>(random() % 60), 22};
    std::vector<double> value(60);
    for (double& v : value) v = flying(random);
    for (std::size_t i = 0; i < truth.count; ++i) value[(truth.first + i) % 60] = bed(random);
    double least = 1e300;
    for (std::size_t first = 0; first < 60; ++first)
      for (std::size_t count = 1; count < 60; ++count)
        least = std::min(least, misfit(value, {first, count}));
    const auto arc = bed_arc(value);
    ASSERT_TRUE(arc);
    EXPECT_NEAR(misfit(value, *arc), least, 1e-9 * least);  // another arc may fit equally well
  }
}

}  // namespace
