#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <random>

#include "core/measure/detachment.h"

namespace {

using namespace millscale::detachment;
using millscale::rotated;
using millscale::Vector;

const double pi = std::acos(-1.0);
constexpr double ball_radius = 0.02;

Mill mill()
{
  Mill frame;
  frame.radius = 1.0;
  frame.grooves.sectors = 25;
  return frame;
}

/// Position at polar angle `psi` from the bottom, in the direction of rotation.
Vector at(double radius, double psi)
{
  return {-radius * std::sin(psi), 0.3, -radius * std::cos(psi)};
}

Observation on_liner(double psi, double mill_angle)
{
  return {true, true, true, at(1.0 - ball_radius, psi), {}, ball_radius, mill_angle, mill_angle};
}

Observation free_at(double radius, double psi, double mill_angle)
{
  return {false, false, false, at(radius, psi), {1, 2, 3}, ball_radius, mill_angle, mill_angle};
}

TEST(Polar, MeasuresFromTheBottomInTheDirectionOfRotation)
{
  for (double psi : {-3.0, -1.0, 0.0, 0.5, 2.0, 3.1}) {
    EXPECT_NEAR(polar(mill(), at(0.7, psi)).psi, psi, 1e-14);
    EXPECT_NEAR(polar(mill(), at(0.7, psi)).radius, 0.7, 1e-15);
  }
}

TEST(Polar, TurningAPointWithTheMillAddsTheMillAngle)
{
  const Vector turned = rotated(at(0.7, 0.4), mill().frame.axis(), 1.3);
  EXPECT_NEAR(polar(mill(), turned).psi, 1.7, 1e-14);
}

TEST(Angle, IsFromTheTopAndPositiveOnTheRisingSide)
{
  EXPECT_NEAR(angle_from_vertical(2.0), pi - 2.0, 1e-15);   // rising
  EXPECT_NEAR(angle_from_vertical(-2.0), 2.0 - pi, 1e-15);  // falling
  EXPECT_NEAR(angle_from_vertical(0.0), pi, 1e-15);         // bottom
}

TEST(Groove, FollowsTheMillAndMatchesABruteForceSearch)
{
  std::mt19937 random(1);
  std::uniform_real_distribution<double> angle(-pi, pi), turns(0.0, 50.0);
  const Mill frame = mill();
  const double pitch = 2.0 * pi / frame.grooves.sectors;
  for (int i = 0; i < 1000; ++i) {
    const double psi = angle(random), mill_angle = turns(random);
    int nearest = 0;
    double best = 1e9;
    for (int k = 0; k < frame.grooves.sectors; ++k) {
      const double apart = std::abs(std::remainder(psi - mill_angle - k * pitch, 2.0 * pi));
      if (apart < best) best = apart, nearest = k;
    }
    EXPECT_EQ(groove(frame, psi, mill_angle), nearest);
  }
}

TEST(Groove, OfAPlainDrumIsZero)
{
  Mill drum = mill();
  drum.grooves.sectors = 1;
  EXPECT_EQ(groove(drum, 2.0, 17.0), 0);
}

TEST(Observe, RecordsTheFlightAtTheStepContactWasLost)
{
  Record ball;
  observe(ball, mill(), on_liner(2.0, 0.1), 1.0);
  observe(ball, mill(), free_at(0.979, 2.01, 0.11), 1.0);
  EXPECT_EQ(ball.flight.count, 0.0);  // not away by a ball radius yet
  const Confirmed event = observe(ball, mill(), free_at(0.90, 2.1, 0.15), 1.0);
  EXPECT_TRUE(event.flight);
  EXPECT_TRUE(event.liner_off);
  EXPECT_EQ(ball.flight.count, 1.0);
  EXPECT_NEAR(ball.flight.angle, pi - 2.01, 1e-14);
  EXPECT_EQ(ball.flight.mill_angle, 0.11);
  EXPECT_EQ(ball.flight.velocity[2], 3.0);
  EXPECT_EQ(ball.outermost, 1.0);
}

TEST(Observe, IgnoresARattleBelowTheGap)
{
  Record ball;
  observe(ball, mill(), on_liner(2.0, 0.1), 1.0);
  observe(ball, mill(), free_at(0.975, 2.0, 0.1), 1.0);
  observe(ball, mill(), on_liner(2.0, 0.1), 1.0);
  const Confirmed event = observe(ball, mill(), on_liner(2.0, 0.1), 1.0);
  EXPECT_FALSE(event.flight || event.liner_off);
  EXPECT_EQ(ball.flight.count + ball.liner_off.count, 0.0);
}

TEST(Observe, TellsLinerContactLostFromFreeFlight)
{
  Record ball;
  observe(ball, mill(), on_liner(2.0, 0.1), 1.0);
  Observation on_lifter = free_at(0.95, 2.1, 0.2);  // on the lifter's face
  on_lifter.wall_contact = on_lifter.contact_force = true;
  EXPECT_TRUE(observe(ball, mill(), on_lifter, 1.0).liner_off);
  EXPECT_EQ(ball.flight.count, 0.0);
  EXPECT_EQ(ball.state, 1.0);

  observe(ball, mill(), free_at(0.90, 2.4, 0.5), 1.0);
  EXPECT_TRUE(observe(ball, mill(), free_at(0.80, 2.5, 0.6), 1.0).flight);
  EXPECT_NEAR(ball.liner_off.angle, pi - 2.1, 1e-14);
  EXPECT_NEAR(ball.flight.angle, pi - 2.4, 1e-14);
  EXPECT_EQ(ball.state, 3.0);
}

TEST(Observe, ABallCarriedByTheMillIsNotInFlight)
{
  Record ball;
  observe(ball, mill(), on_liner(0.0, 0.0), 1.0);
  // No contact force for a distance of many radii, but the ball moves with the mill.
  for (int i = 1; i < 20; ++i) observe(ball, mill(), free_at(0.98, 0.1 * i, 0.1 * i), 1.0);
  EXPECT_EQ(ball.flight.count, 0.0);
}

TEST(Observe, AFlightFromTheBedIsNotOfTheOutermostLayer)
{
  Record ball;
  Observation in_bed = free_at(0.7, 1.0, 0.1);
  in_bed.contact_force = true;
  observe(ball, mill(), in_bed, 1.0);
  EXPECT_EQ(ball.state, 2.0);
  observe(ball, mill(), free_at(0.69, 1.0, 0.1), 1.0);
  observe(ball, mill(), free_at(0.6, 1.0, 0.1), 1.0);
  EXPECT_EQ(ball.flight.count, 1.0);
  EXPECT_EQ(ball.outermost, 0.0);
}

TEST(Observe, ScalesWithTheBallRadius)
{
  for (double scale : {0.1, 1.0, 7.0}) {
    Mill frame = mill();
    frame.radius *= scale;
    Record ball;
    Observation start = on_liner(2.0, 0.1), lost = free_at(0.979, 2.0, 0.1),
                away = free_at(0.959, 2.0, 0.1);
    for (Observation* o : {&start, &lost, &away}) {
      for (double& x : o->position) x *= scale;
      o->ball_radius *= scale;
    }
    observe(ball, frame, start, 1.0);
    observe(ball, frame, lost, 1.0);
    EXPECT_FALSE(observe(ball, frame, away, 1.1).flight) << scale;
    EXPECT_TRUE(observe(ball, frame, away, 0.9).flight) << scale;
  }
}

constexpr Drive drive{1.6, 9.81};

/// Observation in contact with balls at polar angle psi, moving with the mill except for a radial
/// speed.
Observation among_balls(double radius, double psi, double mill_angle, double apart)
{
  Observation now = free_at(radius, psi, mill_angle);
  now.contact_force = true;
  now.velocity = millscale::cross({0.0, drive.speed, 0.0}, now.position);
  for (int d = 0; d < 3; d += 2) now.velocity[d] += apart * now.position[d] / radius;
  return now;
}

TEST(Observe, WhatMayNotConfirmChangesNothing)
{
  // A ball that moves near the groove, with occasional contacts with the groove or other balls.
  std::mt19937 random(3);
  std::uniform_int_distribution<int> choice(0, 9);
  std::normal_distribution<double> step(0.0, 0.004);
  double radius = 1.0 - ball_radius, angle = 0.0;
  int touches = 3, skipped = 0, waiting = 0, waiting_in_flight = 0, waiting_for_both = 0;
  Record always, sometimes;
  int last = -1;
  int confirmed = 0;
  for (int k = 0; k < 20000; ++k) {
    if (choice(random) == 0) touches = choice(random) % 3;
    angle += 1e-3;
    radius = std::clamp(radius + step(random), 0.9, 1.0 - ball_radius);
    Observation now = free_at(radius, 0.5, angle);
    now.liner_contact = now.wall_contact = touches == 2;
    now.contact_force = touches > 0;
    const Confirmed event = observe(always, mill(), now, 1.0);
    confirmed += event.liner_off + event.flight;
    const Pending before = pending(sometimes);
    waiting += before == Pending::liner;
    waiting_in_flight += before == Pending::flight;
    waiting_for_both += before == Pending::both;
    if (touches == last && !may_confirm(before, mill(), now.position, millscale::Turn(-angle),
                                        sometimes.flight_place, ball_radius, 1.0)) {
      ++skipped;
      EXPECT_FALSE(event.liner_off || event.flight);
    } else {
      observe(sometimes, mill(), now, 1.0);
    }
    last = touches;
    ASSERT_EQ(std::memcmp(&always, &sometimes, sizeof always), 0) << k;
  }
  EXPECT_GT(skipped, 5000);
  EXPECT_GT(waiting, 1000);
  EXPECT_GT(waiting_in_flight, 100);
  EXPECT_GT(waiting_for_both, 100);
  EXPECT_GT(confirmed, 100);
}

TEST(Carrier, IsTheLifterOfTheGrooveABallRestsIn)
{
  const double pitch = 2 * pi / 25;
  for (int k = 0; k < 25; ++k) {
    Record ball;
    follow_carrier(ball.carrier, mill(), drive, among_balls(0.9, 0.3 + k * pitch, 0.3, 0.0), 1.0);
    EXPECT_EQ(ball.carrier, k);
  }
}

TEST(Carrier, IsTheGrooveOfTheArctangentAlsoAtTheBorders)
{
  std::mt19937 random(9);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (const auto& grooves : std::vector<millscale::liner::Grooves>{{1, 0.0},
                                                                    {2, 0.3},
                                                                    {3, 0.0},
                                                                    {25, 0.1},
                                                                    {1, 0.2, {-1.0}},
                                                                    {8, 0.1, {-0.3, -0.1, 0.25}}}) {
    Mill turned = mill();
    turned.grooves = grooves;
    for (int k = 0; k < 20000; ++k) {
      const double mill_angle = 40.0 * unit(random);
      const TurnedGrooves now(turned, mill_angle);
      const double close = k % 2 ? 1e-14 * unit(random) : pi * unit(random);
      const double psi = mill_angle + grooves.lifter_angle(k % grooves.count()) + close;
      Vector position = turned.frame.vector({0.9 * std::sin(psi), 0.9 * std::cos(psi), 0.1});
      const int expected = groove(turned, polar(turned, position).psi, mill_angle);
      for (const int guess : {-1, expected, (expected + 1) % grooves.count(), grooves.count()})
        ASSERT_EQ(now.at(turned, position, guess), expected) << grooves.count() << " " << k;
    }
  }
}

TEST(Carrier, IsUnknownAtFirst)
{
  Record ball;
  follow_carrier(ball.carrier, mill(), drive, free_at(0.9, 1.0, 0.3), 1.0);
  EXPECT_EQ(ball.carrier, -1.0);
}

TEST(Carrier, StaysThatOfTheThrowThroughFlightAndCollisionInFlight)
{
  const double pitch = 2 * pi / 25;
  Record ball;
  follow_carrier(ball.carrier, mill(), drive, among_balls(0.9, 0.3 + 7 * pitch, 0.3, 0.0), 1.0);
  follow_carrier(ball.carrier, mill(), drive, free_at(0.8, 0.5 + 9 * pitch, 0.5), 1.0);
  follow_carrier(ball.carrier, mill(), drive, among_balls(0.6, 0.6 + 12 * pitch, 0.6, 2.0), 1.0);
  follow_carrier(ball.carrier, mill(), drive, free_at(0.5, 0.7 + 15 * pitch, 0.7), 1.0);
  EXPECT_EQ(ball.carrier, 7.0);
  Observation landed = free_at(0.98, 0.8 + 20 * pitch, 0.8);  // far from the mill's speed
  landed.wall_contact = landed.contact_force = true;
  follow_carrier(ball.carrier, mill(), drive, landed, 1.0);
  EXPECT_EQ(ball.carrier, 20.0);
}

TEST(Carrier, IsLostAtTheSpeedOfAFallThroughTheGap)
{
  for (double gap : {0.5, 1.0, 3.0}) {
    const double speed = std::sqrt(2.0 * drive.gravity * gap * ball_radius);
    EXPECT_TRUE(carried(mill(), drive, among_balls(0.9, 1.0, 0.3, 0.999 * speed), gap));
    EXPECT_FALSE(carried(mill(), drive, among_balls(0.9, 1.0, 0.3, 1.001 * speed), gap));
    EXPECT_FALSE(carried(mill(), drive, among_balls(0.9, 1.0, 0.3, -1.001 * speed), gap));
  }
}

TEST(Statistics, MergedEqualTheNaiveDefinition)
{
  std::mt19937 random(2);
  std::normal_distribution<double> angle(1.1, 0.2);
  AngleStatistics parts[3], merged;
  std::vector<double> all;
  for (int i = 0; i < 300; ++i) {
    all.push_back(angle(random));
    parts[i % 7 % 3].add(all.back());
  }
  for (const auto& part : parts) merged.merge(part);
  double mean = 0.0, squares = 0.0;
  for (double a : all) mean += a / all.size();
  for (double a : all) squares += (a - mean) * (a - mean);
  EXPECT_EQ(merged.count, 300.0);
  EXPECT_NEAR(merged.mean, mean, 1e-14);
  EXPECT_NEAR(merged.standard_deviation(), std::sqrt(squares / 299.0), 1e-14);
}

}  // namespace
