#include <gtest/gtest.h>

#include "core/neighbor/adaptive_skin.h"
#include "core/neighbor/cloud.h"
#include "core/neighbor/list_check.h"

namespace {

using namespace millscale::pairs;
using millscale::Vector;

constexpr double most = 0.01;

/// Turns about an axis of no special direction through a place that is not the origin.
TurningFrame mill()
{
  return {{0.3, -0.2, 0.1}, {2.0 / 7.0, 6.0 / 7.0, -3.0 / 7.0}, 2.5};
}

/// Every ball moves with the frame.
Cloud carried_along(const TurningFrame& frame)
{
  Cloud cloud = random_cloud({800, 0.45, 0.01, 0.02}, 21);
  for (int i = 0; i < cloud.all(); ++i) {
    Vector arm;
    for (int d = 0; d < 3; ++d) arm[d] = cloud.position[i][d] - frame.origin[d];
    const Vector direction = millscale::cross(frame.axis, arm);
    for (int d = 0; d < 3; ++d) cloud.velocity[i][d] = frame.rate * direction[d];
  }
  return cloud;
}

void turn(Cloud& cloud, const TurningFrame& frame, double time)
{
  for (auto& x : cloud.position) {
    Vector arm;
    for (int d = 0; d < 3; ++d) arm[d] = x[d] - frame.origin[d];
    arm = millscale::rotated(arm, frame.axis, frame.rate * time);
    for (int d = 0; d < 3; ++d) x[d] = frame.origin[d] + arm[d];
  }
}

Margins margins_of(const Cloud& cloud, const TurningFrame& frame, double time)
{
  CellGrid grid;
  grid.sort(cloud.view(), most);
  Margins margins;
  margins.set_by_speed(cloud.view(), grid, frame, most, time);
  return margins;
}

bool outrun(const Margins& margins, const Cloud& cloud, double time)
{
  return margins.outrun(cloud.view().position, cloud.owned(), time);
}

double apart(const Cloud& cloud, int i, int j)
{
  return std::hypot(cloud.position[i][0] - cloud.position[j][0],
                    cloud.position[i][1] - cloud.position[j][1],
                    cloud.position[i][2] - cloud.position[j][2]);
}

TEST(Margins, OfBallsThatTheMillCarriesAreTheLeast)
{
  const TurningFrame frame = mill();
  const Cloud cloud = carried_along(frame);
  const Margins margins = margins_of(cloud, frame, 1.0);
  for (int i = 0; i < cloud.all(); ++i)
    EXPECT_NEAR(margins.of_balls()[i], Margins::least_share * cloud.radius[i], 1e-12);
}

TEST(Margins, AreNotLeftByBallsThatTurnWithTheMill)
{
  const TurningFrame frame = mill();
  Cloud cloud = carried_along(frame);
  const Margins margins = margins_of(cloud, frame, 1.0);
  const double time = 0.4;  // a radian: tens of centimetres
  const Cloud before = cloud;
  turn(cloud, frame, time);
  EXPECT_GT(std::abs(cloud.position[5][0] - before.position[5][0]), 0.05);
  EXPECT_FALSE(outrun(margins, cloud, time));
  EXPECT_TRUE(outrun(margins, before, time)) << "at rest in space is not at rest in the mill";
}

TEST(Margins, AreLeftByOneBallThatGoesTooFar)
{
  const TurningFrame frame = mill();
  const double time = 0.2;
  for (const double share : {0.999, 1.001}) {
    Cloud cloud = carried_along(frame);
    const Margins margins = margins_of(cloud, frame, 1.0);
    turn(cloud, frame, time);
    const int last = cloud.all() - 1;
    cloud.position[last][1] += share * margins.of_balls()[last];
    EXPECT_EQ(outrun(margins, cloud, time), share > 1.0) << share;
  }
}

TEST(Margins, AreLeftByABallThatIsNowhere)
{
  const TurningFrame frame = mill();
  Cloud cloud = carried_along(frame);
  const Margins margins = margins_of(cloud, frame, 1.0);
  cloud.position[17][2] = std::nan("");
  EXPECT_TRUE(outrun(margins, cloud, 0.0));
}

TEST(Margins, AreLeftWhenThereAreOtherBalls)
{
  const Cloud cloud = carried_along(mill());
  const Margins margins = margins_of(cloud, mill(), 1.0);
  EXPECT_TRUE(margins.outrun(cloud.view().position, cloud.owned() - 1, 0.0));
}

TEST(Margins, AreThoseOfTheFastestBallThatMayHitThem)
{
  Cloud cloud = carried_along(TurningFrame{});  // at rest
  constexpr int fast = 11;
  constexpr double speed = 3.0, time = 1e-3;
  cloud.velocity[fast][0] = speed;
  const Margins margins = margins_of(cloud, TurningFrame{}, time);
  const double cell = 2.0 * (0.02 + most);
  int near = 0, far = 0;
  for (int i = 0; i < cloud.all(); ++i) {
    const double least = Margins::least_share * cloud.radius[i];
    const double margin = margins.of_balls()[i];
    if (apart(cloud, i, fast) <= cell * 0.98) {  // in the cells around, wherever they begin
      EXPECT_NEAR(margin, least + time * speed, 1e-15);
      ++near;
    } else if (apart(cloud, i, fast) > 2.0 * std::sqrt(3.0) * cell * 1.3) {
      EXPECT_EQ(margin, least);
      ++far;
    }
  }
  EXPECT_GT(near, 5);
  EXPECT_GT(far, 20);
}

TEST(Margins, AreNoLargerThanTheMost)
{
  const Cloud cloud = random_cloud({400, 0.4}, 23);
  const Margins margins = margins_of(cloud, TurningFrame{}, 1.0);
  for (int i = 0; i < cloud.all(); ++i) EXPECT_EQ(margins.of_balls()[i], most);
}

TEST(Margins, ThatAreTheSameForAllAreTheEnginesToWatch)
{
  Cloud cloud = random_cloud({50, 0.4}, 24);
  Margins margins = margins_of(cloud, TurningFrame{}, 1e-4);
  margins.set_same(cloud.view(), most);
  for (int i = 0; i < cloud.all(); ++i) EXPECT_EQ(margins.of_balls()[i], most);
  for (auto& x : cloud.position) x[0] += 1.0;
  EXPECT_FALSE(outrun(margins, cloud, 1.0));
}

/// The list of a cloud with margins by speed; then every ball goes anywhere within its own.
TEST(Margins, OfAListMissNoContactUntilABallHasLeftItsOwn)
{
  const TurningFrame frame = mill();
  int met = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    Cloud cloud = carried_along(frame);
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    for (int i = 0; i < cloud.all(); i += 9)
      for (int d = 0; d < 3; ++d) cloud.velocity[i][d] += 2.0 * normal(random);
    CellGrid grid;
    grid.sort(cloud.view(), most);
    Margins margins;
    margins.set_by_speed(cloud.view(), grid, frame, most, 2e-3);
    HalfList list;
    build(list, grid, cloud.view(), margins.of_balls(), best_kernel().list_partners);
    for (int i = 0; i < cloud.all(); ++i) {
      const Vector to{normal(random), normal(random), normal(random)};
      const double length = std::sqrt(millscale::dot(to, to));
      for (int d = 0; d < 3; ++d)
        cloud.position[i][d] += (1.0 - 1e-9) * margins.of_balls()[i] * to[d] / length;
    }
    turn(cloud, frame, 0.3);
    ASSERT_FALSE(outrun(margins, cloud, 0.3));
    std::fill(list.touching.begin(), list.touching.end(), 1);  // only what is listed is asked
    const auto missed = missed_contact(list, cloud.view());
    EXPECT_FALSE(missed) << missed->i << ' ' << missed->j << ' ' << missed->overlap;
    for (int i = 0; i < list.owned(); ++i)
      for (int k = 0; k < list.partners[i]; ++k) {
        const int j = list.other[list.first[i] + k];
        met += apart(cloud, i, j) < cloud.radius[i] + cloud.radius[j];
      }
  }
  EXPECT_GT(met, 2000);
}

TEST(Margins, KeepAListShortWhereBallsDoNotGoFar)
{
  const TurningFrame frame = mill();
  const Cloud cloud = carried_along(frame);
  HalfList all, needed;
  build_within(all, cloud, 2.0 * most, best_kernel().list_partners);
  CellGrid grid;
  grid.sort(cloud.view(), most);
  const Margins margins = margins_of(cloud, frame, 2e-3);
  build(needed, grid, cloud.view(), margins.of_balls(), best_kernel().list_partners);
  EXPECT_LT(needed.entries, 0.6 * all.entries);
}

}  // namespace
