#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "core/liner/paper_liners.h"
#include "core/measure/guard.h"

namespace {

using namespace millscale;
using charge::WallGuard;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinite = std::numeric_limits<double>::infinity();

TEST(Guard, NoBallOfTheMillIsFasterThanAThrowAndAFall)
{
  // Energy of a ball thrown from the top: once at mill speed 0, once without gravity.
  EXPECT_NEAR(charge::plausible_speed({2.0, 0.02, 9.81, 0.0}), 2.0 * std::sqrt(2.0 * 9.81 * 4.0),
              1e-12);
  EXPECT_NEAR(charge::plausible_speed({2.0, 0.02, 0.0, 3.0}), 2.0 * 2.0 * 6.0, 1e-12);
}

/// The definition, evaluated ball by ball.
std::size_t naive_first_beyond(const std::vector<double>& v, double limit)
{
  for (std::size_t i = 0; i < v.size() / 3; ++i)
    if (!(std::hypot(v[3 * i], v[3 * i + 1], v[3 * i + 2]) <= limit)) return i;
  return v.size() / 3;
}

TEST(Guard, FindsTheFirstThatIsTooLongOrNoNumberAmongAnyCount)
{
  std::mt19937 random(7);
  std::uniform_real_distribution<double> within(-0.5, 0.5);
  for (const std::size_t count : {0u, 1u, 63u, 64u, 65u, 1000u})
    for (const double bad : {2.0, -2.0, nan, infinite, -infinite})
      for (int trial = 0; trial < 20; ++trial) {
        std::vector<double> v(3 * count);
        for (double& x : v) x = within(random);
        for (int k = 0; k < trial % 3 && count > 0; ++k) v[random() % v.size()] = bad;
        EXPECT_EQ(charge::first_beyond(v.data(), count, 1.0), naive_first_beyond(v, 1.0));
      }
}

TEST(Guard, ABallIsAtFaultWhereItsCentreIsInTheWallOrItsOverlapIsOverTheLimit)
{
  std::mt19937 random(3);
  for (const liner::Lifters& liner : test::various_liners()) {
    const double radius = 0.01 * liner.radius(), limit = 0.3;
    const WallGuard guard(liner, radius, limit);
    std::uniform_real_distribution<double> anywhere(-1.05 * liner.radius(), 1.05 * liner.radius());
    int beyond = 0, deep = 0, fine = 0;
    for (int i = 0; i < 20000; ++i) {
      const liner::Point p{anywhere(random), anywhere(random)};
      // Evaluated another way: by the nearest point, not by faces.
      const double distance = liner::nearest(liner, p).distance;
      const auto fault = guard.fault(p, radius);
      if (std::abs(distance) < 1e-9 || std::abs(distance - (1.0 - limit) * radius) < 1e-9) continue;
      const bool expected = distance < (1.0 - limit) * radius;
      ASSERT_EQ(fault.has_value(), expected) << p.x << ' ' << p.z << ' ' << distance;
      if (!expected) {
        ++fine;
        continue;
      }
      const bool outside = distance < 0.0;
      ++(outside ? beyond : deep);
      const char* words = outside ? "is outside the mill, its centre " : "overlaps ";
      EXPECT_EQ(fault->rfind(words, 0), 0u) << *fault;
    }
    EXPECT_GT(beyond, 100);
    EXPECT_GT(deep, 10);
    EXPECT_GT(fine, 1000);
  }
}

TEST(Guard, APlaceThatIsNoNumberIsAFault)
{
  const WallGuard guard(test::various_liners().front(), 0.02, 0.5);
  EXPECT_EQ(*guard.fault({nan, 0.0}, 0.02), "has no finite position");
  EXPECT_EQ(guard.where({nan, 0.0}), "an unknown wall");
}

TEST(Guard, NothingTouchesAtAPlaceThatIsNoNumber)
{
  for (const liner::Lifters& liner : test::various_liners()) {
    const double radius = 0.01 * liner.radius();
    EXPECT_EQ(liner::ContactFinder(liner, radius).contacts({nan, 0.1}, radius).count, 0);
  }
}

TEST(Guard, TheReportNamesBallStepPlaceAndCauses)
{
  const std::string said = charge::report({17, {1.0, 2.0, 3.0}, {3.0, 4.0, 0.0}, {0.0, 6.0, 8.0}},
                                          "is green", 1200, "groove 3", {"paint", "moss"});
  EXPECT_EQ(said,
            "fix mill/guard: ball 17 is green; step 1200, position (1, 2, 3) m, speed 5 m/s, "
            "force 10 N, nearest wall groove 3; likeliest first: paint; moss; see "
            "docs/results/hard-cases.md");
}

TEST(Guard, CausesBeginWithWhatIsMissing)
{
  charge::Circumstances c;
  c.step = 0.05;
  c.bed_overlap = 0.01;
  ASSERT_EQ(charge::causes(c).size(), 1u);
  EXPECT_EQ(charge::causes(c)[0],
            "the time step, 0.05 Rayleigh times, usual is up to 0.2 (a shorter timestep)");
  c.walls = c.compared = false;
  c.past_open_end = c.hole = true;
  c.wobble = 0.03;
  c.bed_overlap = 0.1;
  const std::vector<std::string> found = charge::causes(c);
  ASSERT_EQ(found.size(), 7u);
  const char* const begin[] = {"no wall holds the balls",
                               "no wall closes this end",
                               "a hole in the mesh",
                               "a mesh of another radius",
                               "a mesh that wobbles by 0.03 of the radius",
                               "a soft material, in whose bed balls sink 0.1 radii",
                               "the time step, 0.05 Rayleigh times"};
  for (std::size_t i = 0; i < found.size(); ++i) EXPECT_EQ(found[i].rfind(begin[i], 0), 0u);
}

TEST(Guard, OfMaterialAndStepTheOneFartherFromItsUsualMeasureComesFirst)
{
  for (const double step : {0.1, 0.3, 0.6}) {
    charge::Circumstances c;
    c.step = step;
    c.bed_overlap = 0.1;  // twice the usual; 0.6 is three times the usual
    EXPECT_EQ(charge::causes(c)[0].rfind("the time step", 0) == 0, step > 0.5);
  }
  EXPECT_EQ(charge::causes({})[0], "the time step (a shorter timestep)");  // none known
}

TEST(Guard, NoCauseNamesAnotherFault)
{
  // millscale.workflow.failures classifies the message by these words.
  charge::Circumstances c;
  c.walls = c.compared = false;
  c.past_open_end = c.hole = true;
  c.wobble = 0.03;
  c.bed_overlap = 0.1;
  c.step = 0.05;
  for (const std::string& cause : charge::causes(c))
    for (const char* word : {"overlap", "outside", "faster", "left", "lost", "finite", "nan"})
      EXPECT_EQ(cause.find(word), std::string::npos) << cause;
}

}  // namespace
