#include <gtest/gtest.h>

#include "core/neighbor/adaptive_skin.h"
#include "core/neighbor/cloud.h"
#include "core/neighbor/list_check.h"
#include "core/neighbor/pair_list.h"

namespace {

using namespace millscale::kernels;
using namespace millscale::neighbor;
using millscale::Vector;

constexpr double most = 0.01;

/// Turns about a tilted axis through a point off the origin.
TurningFrame mill()
{
  return {{0.3, -0.2, 0.1}, {2.0 / 7.0, 6.0 / 7.0, -3.0 / 7.0}, 2.5};
}

/// Cloud in which every ball moves with the frame.
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

AdaptiveSkin skin_of(const Cloud& cloud, const TurningFrame& frame, double time)
{
  AdaptiveSkin skin;
  skin.set_by_speed(cloud.view(), frame, most, time);
  return skin;
}

bool exceeded(const AdaptiveSkin& skin, const Cloud& cloud, double time)
{
  return skin.exceeded(cloud.view().position, cloud.nlocal(), time);
}

double separation(const Cloud& cloud, int i, int j)
{
  return std::hypot(cloud.position[i][0] - cloud.position[j][0],
                    cloud.position[i][1] - cloud.position[j][1],
                    cloud.position[i][2] - cloud.position[j][2]);
}

TEST(AdaptiveSkin, IsSmallestForBallsThatTurnWithTheMill)
{
  const TurningFrame frame = mill();
  const Cloud cloud = carried_along(frame);
  const AdaptiveSkin skin = skin_of(cloud, frame, 1.0);
  for (int i = 0; i < cloud.all(); ++i)
    EXPECT_NEAR(skin.data()[i], AdaptiveSkin::min_share * cloud.radius[i], 1e-12);
}

TEST(AdaptiveSkin, IsNotExceededByBallsThatTurnWithTheMill)
{
  const TurningFrame frame = mill();
  Cloud cloud = carried_along(frame);
  const AdaptiveSkin skin = skin_of(cloud, frame, 1.0);
  const double time = 0.4;  // a radian: tens of centimetres
  const Cloud before = cloud;
  turn(cloud, frame, time);
  EXPECT_GT(std::abs(cloud.position[5][0] - before.position[5][0]), 0.05);
  EXPECT_FALSE(exceeded(skin, cloud, time));
  EXPECT_TRUE(exceeded(skin, before, time)) << "at rest in space is not at rest in the mill";
}

TEST(AdaptiveSkin, IsExceededByOneBallThatMovesTooFar)
{
  const TurningFrame frame = mill();
  const double time = 0.2;
  for (const double share : {0.999, 1.001}) {
    Cloud cloud = carried_along(frame);
    const AdaptiveSkin skin = skin_of(cloud, frame, 1.0);
    turn(cloud, frame, time);
    const int last = cloud.all() - 1;
    cloud.position[last][1] += share * skin.data()[last];
    EXPECT_EQ(exceeded(skin, cloud, time), share > 1.0) << share;
  }
}

TEST(AdaptiveSkin, IsExceededByANaNPosition)
{
  const TurningFrame frame = mill();
  Cloud cloud = carried_along(frame);
  const AdaptiveSkin skin = skin_of(cloud, frame, 1.0);
  cloud.position[17][2] = std::nan("");
  EXPECT_TRUE(exceeded(skin, cloud, 0.0));
}

TEST(AdaptiveSkin, IsExceededWhenTheNumberOfBallsChanges)
{
  const Cloud cloud = carried_along(mill());
  const AdaptiveSkin skin = skin_of(cloud, mill(), 1.0);
  EXPECT_TRUE(skin.exceeded(cloud.view().position, cloud.nlocal() - 1, 0.0));
}

TEST(AdaptiveSkin, IsThatOfTheFastestBallNearby)
{
  Cloud cloud = carried_along(TurningFrame{});  // at rest
  constexpr int fast = 11;
  constexpr double speed = 3.0, time = 1e-3;
  cloud.velocity[fast][0] = speed;
  const AdaptiveSkin skin = skin_of(cloud, TurningFrame{}, time);
  const double cell = 2.0 * (0.02 + most);
  int near = 0, far = 0;
  for (int i = 0; i < cloud.all(); ++i) {
    const double least = AdaptiveSkin::min_share * cloud.radius[i];
    const double of_ball = skin.data()[i];
    if (separation(cloud, i, fast) <= cell * 0.98) {  // in the nearby cells for any grid origin
      EXPECT_NEAR(of_ball, least + time * speed, 1e-15);
      ++near;
    } else if (separation(cloud, i, fast) > 2.0 * std::sqrt(3.0) * cell * 1.3) {
      EXPECT_EQ(of_ball, least);
      ++far;
    }
  }
  EXPECT_GT(near, 5);
  EXPECT_GT(far, 20);
}

TEST(AdaptiveSkin, IsAtMostTheLimit)
{
  const Cloud cloud = random_cloud({400, 0.4}, 23);
  const AdaptiveSkin skin = skin_of(cloud, TurningFrame{}, 1.0);
  for (int i = 0; i < cloud.all(); ++i) EXPECT_EQ(skin.data()[i], most);
}

TEST(AdaptiveSkin, UniformIsNeverExceeded)
{
  Cloud cloud = random_cloud({50, 0.4}, 24);
  AdaptiveSkin skin = skin_of(cloud, TurningFrame{}, 1e-4);
  skin.set_uniform(cloud.view(), most);
  for (int i = 0; i < cloud.all(); ++i) EXPECT_EQ(skin.data()[i], most);
  for (auto& x : cloud.position) x[0] += 1.0;
  EXPECT_FALSE(exceeded(skin, cloud, 1.0));
}

/// Builds the list of a cloud with adaptive skin, then moves every ball by up to its skin.
TEST(AdaptiveSkin, GivesAListThatMissesNoContactUntilItIsExceeded)
{
  const TurningFrame frame = mill();
  int in_contact = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    Cloud cloud = carried_along(frame);
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    for (int i = 0; i < cloud.all(); i += 9)
      for (int d = 0; d < 3; ++d) cloud.velocity[i][d] += 2.0 * normal(random);
    CellGrid grid;
    AdaptiveSkin skin;
    skin.set_by_speed(cloud.view(), frame, most, 2e-3);
    PairList list;
    build(list, grid, cloud.view(), skin.data(), best_implementation().list_partners);
    for (int i = 0; i < cloud.all(); ++i) {
      const Vector to{normal(random), normal(random), normal(random)};
      const double length = std::sqrt(millscale::dot(to, to));
      for (int d = 0; d < 3; ++d)
        cloud.position[i][d] += (1.0 - 1e-9) * skin.data()[i] * to[d] / length;
    }
    turn(cloud, frame, 0.3);
    ASSERT_FALSE(exceeded(skin, cloud, 0.3));
    std::fill(list.touching.begin(), list.touching.end(), 1);  // only listed pairs are checked
    const auto missed = missed_contact(list, cloud.view());
    EXPECT_FALSE(missed) << missed->i << ' ' << missed->j << ' ' << missed->overlap;
    for (int i = 0; i < list.nlocal(); ++i)
      for (int k = 0; k < list.partners[i]; ++k) {
        const int j = list.other[list.first[i] + k];
        in_contact += separation(cloud, i, j) < cloud.radius[i] + cloud.radius[j];
      }
  }
  EXPECT_GT(in_contact, 2000);
}

TEST(AdaptiveSkin, KeepAListShortWhereBallsDoNotGoFar)
{
  const TurningFrame frame = mill();
  const Cloud cloud = carried_along(frame);
  PairList all, needed;
  build_within(all, cloud, 2.0 * most, best_implementation().list_partners);
  CellGrid grid;
  const AdaptiveSkin skin = skin_of(cloud, frame, 2e-3);
  build(needed, grid, cloud.view(), skin.data(), best_implementation().list_partners);
  EXPECT_LT(needed.entries, 0.6 * all.entries);
}

}  // namespace
