#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "core/liner/paper_liners.h"
#include "core/measure/charge_sums.h"

namespace {

using namespace millscale::charge;
using millscale::pi;
using millscale::liner::Frame;
using millscale::liner::Lifters;
using millscale::liner::Point;

constexpr double ball_radius = 0.02, ball_mass = 0.09;

ChargeSums sums(double box_angle = 0.0)
{
  return ChargeSums({millscale::test::trapezoid_mill(), ball_radius, 9.81, box_angle});
}

Ball at(Point centre)
{
  return {centre, ball_mass, ball_radius, 0.0, 0.0, 0.0, 0.0};
}

/// A point at a distance from the axis and an angle from the top, positive on the rising side.
Point from_top(double distance, double angle)
{
  return {-distance * std::sin(angle), distance * std::cos(angle)};
}

TEST(ChargeSums, AddUpEnergiesAndCentreOfMass)
{
  ChargeSums sum = sums();
  sum.start(0.0);
  sum.add({{1.0, -2.0}, 2.0, 0.1, 9.0, 16.0, 5.5, -0.5});
  sum.add({{-3.0, 0.5}, 1.0, 0.2, 4.0, 25.0, -8.0, 1.0});
  const Summary s = sum.summary();
  EXPECT_DOUBLE_EQ(s.balls, 2.0);
  EXPECT_DOUBLE_EQ(s.mass, 3.0);
  EXPECT_DOUBLE_EQ(s.kinetic_translation, 0.5 * 2.0 * 9.0 + 0.5 * 1.0 * 4.0);
  EXPECT_DOUBLE_EQ(s.kinetic_rotation, 0.2 * 2.0 * 0.01 * 16.0 + 0.2 * 1.0 * 0.04 * 25.0);
  EXPECT_DOUBLE_EQ(s.potential, 9.81 * (2.0 * -2.0 + 1.0 * 0.5));
  EXPECT_DOUBLE_EQ(s.centre_x, -1.0 / 3.0);
  EXPECT_DOUBLE_EQ(s.centre_z, -3.5 / 3.0);
  EXPECT_DOUBLE_EQ(s.largest_speed, 3.0);
  EXPECT_DOUBLE_EQ(s.angular_momentum, -2.0);
}

TEST(ChargeSums, HoldTheMassOfTheBoxThatStaysAndOfTheBoxThatTurns)
{
  const double angle = 0.7, turned = 1.3;
  ChargeSums sum = sums(angle);
  const Frame fixed(angle), rotating(angle + turned);
  sum.start(turned);
  for (int i = 0; i < 3; ++i) sum.add(at(fixed.point({3.8, 0.1 * i - 0.1})));
  sum.add(at(rotating.point({3.7, 0.0})));
  for (int i = 0; i < 4; ++i) sum.add(at({0.1 * i, 0.0}));  // in neither region
  const Summary s = sum.summary();
  EXPECT_NEAR(s.box_fixed, 3.0 / 8.0, 1e-15);
  EXPECT_NEAR(s.box_rotating, 1.0 / 8.0, 1e-15);
}

TEST(ChargeSums, FindToeAndShoulderOfABedWithFlyingBalls)
{
  // A layer along the wall from the shoulder, through the bottom, to the toe; the other balls are
  // in flight.
  std::mt19937 random(1);
  for (const auto& [shoulder, toe] : {std::pair{1.0, 4.1}, {-0.3, 2.0}, {2.9, 3.4}}) {
    ChargeSums sum = sums();
    sum.start(0.4);
    std::uniform_real_distribution<double> bed(shoulder, toe), all(-pi, pi), radius(3.571, 3.609);
    for (int i = 0; i < static_cast<int>(4000 * (toe - shoulder)); ++i)
      sum.add(at(from_top(radius(random), bed(random))));
    for (int i = 0; i < 2000; ++i) sum.add(at(from_top(radius(random), all(random))));
    const Summary s = sum.summary();
    // 22 balls a bin in the bed, 1.8 outside: the ends are found within a bin.
    EXPECT_NEAR(s.shoulder, shoulder, sum.resolution()) << shoulder;
    EXPECT_NEAR(s.toe, toe, sum.resolution()) << toe;
  }
  EXPECT_NEAR(sums().resolution(), ball_radius / 3.59, 1e-5);  // a whole number of bins
}

TEST(ChargeSums, TellNoToeWithoutABed)
{
  ChargeSums sum = sums();
  sum.start(0.0);
  sum.add(at({0.0, -1.0}));
  EXPECT_TRUE(std::isnan(sum.summary().toe));
  EXPECT_TRUE(std::isnan(sum.summary().shoulder));
}

TEST(ChargeSums, TakeTheLargestOverlapWithTheTurnedLiner)
{
  const double turned = 0.9;
  ChargeSums sum = sums();
  sum.start(turned);
  const Frame groove(turned);
  sum.add(at(groove.point({3.9 - ball_radius + 0.003, 0.0})));
  EXPECT_NEAR(sum.summary().overlap_with_wall, 0.003, 1e-12);
  const Frame lifter(turned + pi / 25);
  sum.add(at(lifter.point({3.61 - ball_radius + 0.005, 0.0})));
  EXPECT_NEAR(sum.summary().overlap_with_wall, 0.005, 1e-12);
  sum.add_overlap(0.001);
  sum.add_overlap(0.0005);
  EXPECT_EQ(sum.summary().overlap_with_ball, 0.001);
}

TEST(ChargeSums, OnlyCountABallOutsideTheLinerOrNowhere)
{
  ChargeSums sum = sums();
  sum.start(0.0);
  sum.add(at({0.0, -3.9}));
  sum.add(at({0.0, std::nextafter(-3.9, -4.0)}));
  sum.add(at({std::nan(""), 0.0}));
  const Summary s = sum.summary();
  EXPECT_EQ(s.balls, 3.0);
  EXPECT_EQ(s.outside, 2.0);
  EXPECT_EQ(s.centre_z, -3.9);
}

TEST(ChargeSums, OfTwoRanksEqualThoseOfOne)
{
  std::mt19937 random(2);
  std::uniform_real_distribution<double> angle(0.5, 4.0), radius(3.0, 3.9), speed(0.0, 30.0);
  ChargeSums one = sums(), half = sums(), other = sums();
  for (ChargeSums* s : {&one, &half, &other}) s->start(0.2);
  for (int i = 0; i < 3000; ++i) {
    const Ball ball{from_top(radius(random), angle(random)),
                    ball_mass,
                    ball_radius,
                    speed(random),
                    speed(random),
                    speed(random),
                    speed(random)};
    one.add(ball);
    (i % 3 == 0 ? half : other).add(ball);
  }
  half.add_overlap(0.2);
  one.add_overlap(0.2);
  ChargeSums::merge(half.numbers().data(), other.numbers().data(), other.numbers().size());
  const Summary a = one.summary(), b = other.summary();
  // The same 3,000 balls are added in another order.
  EXPECT_NEAR(a.kinetic_translation, b.kinetic_translation, 1e-12 * a.kinetic_translation);
  EXPECT_NEAR(a.centre_z, b.centre_z, 1e-12);
  EXPECT_NEAR(a.angular_momentum, b.angular_momentum, 1e-12 * a.angular_momentum);
  EXPECT_NEAR(a.layer_speed, b.layer_speed, 1e-12 * std::abs(a.layer_speed));
  EXPECT_NEAR(a.box_fixed, b.box_fixed, 1e-14);
  EXPECT_NEAR(a.box_rotating, b.box_rotating, 1e-14);
  EXPECT_EQ(a.toe, b.toe);
  EXPECT_EQ(a.shoulder, b.shoulder);
  EXPECT_EQ(a.largest_speed, b.largest_speed);
  EXPECT_EQ(a.overlap_with_ball, b.overlap_with_ball);
  EXPECT_EQ(a.overlap_with_wall, b.overlap_with_wall);
}

TEST(ChargeSums, HoldTheSlipOfTheBallsOnTheLiner)
{
  const double omega = 0.8, on_liner = 3.9 - ball_radius + 1e-4, beside_it = on_liner - 3e-4;
  const auto moving = [&](double distance, double angle, double mass, double speed) {
    const double spin_momentum = 7.0 * mass;  // not of the path
    return Ball{from_top(distance, angle), mass,         ball_radius, speed * speed, 0.0,
                distance * speed * mass,   spin_momentum};
  };
  const double groove = pi;  // its middle is at the bottom
  ChargeSums sum = sums();
  sum.start(0.0);
  EXPECT_TRUE(std::isnan(sum.summary().liner_slip(omega)));
  sum.add(moving(beside_it, groove, 1.0, 0.3));
  EXPECT_TRUE(std::isnan(sum.summary().liner_slip(omega)));
  sum.add(moving(on_liner, groove, 1.0, omega * on_liner));
  EXPECT_NEAR(sum.summary().liner_slip(omega), 0.0, 1e-15);
  sum.add(moving(on_liner, groove, 3.0, 0.0));
  EXPECT_NEAR(sum.summary().liner_slip(omega), 0.75, 1e-15);
  sum.add(moving(on_liner, groove, 4.0, -omega * on_liner));
  EXPECT_NEAR(sum.summary().liner_slip(omega), 1.0 - (1.0 - 4.0) / 8.0, 1e-15);
  EXPECT_TRUE(std::isnan(sum.summary().liner_slip(0.0)));
}

TEST(ChargeSums, OfAPlainDrumHaveNoBox)
{
  ChargeSums sum({Lifters(millscale::liner::Widths{1.5}), ball_radius, 9.81, 0.0});
  sum.start(0.0);
  sum.add(at({0.0, -1.49}));
  EXPECT_TRUE(std::isnan(sum.summary().box_fixed));
  EXPECT_NEAR(sum.summary().overlap_with_wall, 0.01, 1e-12);
}

}  // namespace
