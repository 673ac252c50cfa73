#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <string>

#include "core/liner/nearest.h"
#include "core/liner/offset.h"
#include "core/liner/paper_liners.h"
#include "core/liner/polygon.h"
#include "core/similarity/law.h"

namespace {

using namespace millscale::liner;
using namespace millscale::test;

constexpr double ball_radius = 0.02;

void expect_equal(const Lifters& a, const Lifters& b, double tolerance)
{
  EXPECT_NEAR(a.radius(), b.radius(), tolerance);
  EXPECT_NEAR(a.lifter_top_radius(), b.lifter_top_radius(), tolerance);
  EXPECT_NEAR(a.lifter_top_width(), b.lifter_top_width(), tolerance);
  EXPECT_NEAR(a.groove_width(), b.groove_width(), tolerance);
  EXPECT_NEAR(a.face_angle(), b.face_angle(), 1e-12);
  EXPECT_EQ(a.lifters(), b.lifters());
  EXPECT_EQ(a.phase(), b.phase());
}

TEST(Offset, EveryFaceMovesByTheDistance)
{
  for (const Lifters& liner : various_liners()) {
    const Polygon moved = polygon(offset(liner, ball_radius), 1e-9 * liner.radius());
    for (std::size_t i = 0; i < moved.nodes.size(); ++i) {
      // Middles of the edges: at the mitred corners the distance to the liner is larger.
      const Point a = moved.nodes[i], b = moved.nodes[(i + 1) % moved.nodes.size()];
      const Nearest found = nearest(liner, {0.5 * (a.x + b.x), 0.5 * (a.z + b.z)});
      EXPECT_NEAR(found.distance, ball_radius, 1e-8 * liner.radius());
      EXPECT_EQ(found.face, moved.faces[i]);
    }
  }
}

TEST(Offset, BackAndForthIsTheSameLiner)
{
  for (const Lifters& liner : various_liners())
    expect_equal(offset(offset(liner, ball_radius), -ball_radius), liner, 1e-13);
}

TEST(Offset, RefusesToLoseALifterOrTheDrum)
{
  const Lifters liner = trapezoid_mill();
  EXPECT_THROW(offset(liner, 3.9), std::invalid_argument);
  try {
    offset(liner, -0.2);
    FAIL() << "the lifter is only 0.25 m wide";
  } catch (const std::invalid_argument& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("lifter vanishes"), std::string::npos);
    const double limit = std::stod(text.substr(text.find("offsets > ") + 10));
    EXPECT_NO_THROW(offset(liner, limit + 1e-6));
    EXPECT_THROW(offset(liner, limit - 1e-6), std::invalid_argument);
  }
}

TEST(OffsetLiner, CentrePathScalesExactly)
{
  for (const Lifters& physical : {trapezoid_mill(), parallel_mill()})
    for (const double S : {1.0, 1.083, 2.6, 5.0}) {
      const Lifters model = offset_scaled(physical, S, ball_radius);
      expect_equal(offset(model, ball_radius), scaled(offset(physical, ball_radius), S), 1e-13);
      EXPECT_NEAR(model.face_angle(), physical.face_angle(), 1e-12);
    }
}

TEST(OffsetLiner, DistanceFieldsOfTheCentrePathsAreSimilar)
{
  const double S = 2.6;
  const Lifters physical = trapezoid_mill(), model = offset_scaled(physical, S, ball_radius);
  // Where the ball's centre runs along a flat or an arc, its distance from contact scales by S.
  int compared = 0;
  for (double x = -3.8; x <= 3.8; x += 0.0713)
    for (double z = -3.8; z <= 3.8; z += 0.0713) {
      const Nearest full = nearest(physical, {x, z});
      const Nearest small = nearest(model, {x / S, z / S});
      const bool on_edge =
          std::abs(
              std::abs(Frame(physical.lifter_angle(full.sector)).local(full.point).tangential) -
              physical.corner().tangential) < 0.03 &&
          full.face != Face::groove;
      if (full.distance < ball_radius || on_edge || full.face != small.face) continue;
      EXPECT_NEAR(small.distance - ball_radius, (full.distance - ball_radius) / S, 1e-13);
      ++compared;
    }
  EXPECT_GT(compared, 1000);
}

TEST(OffsetLiner, WithoutScalingOrBallItIsPlainScaling)
{
  const Lifters physical = trapezoid_mill();
  expect_equal(offset_scaled(physical, 1.0, ball_radius), physical, 1e-13);
  expect_equal(offset_scaled(physical, 2.6, 0.0), scaled(physical, 2.6), 1e-13);
}

TEST(OffsetLiner, HasTheRadiusOfTheSimilarityLaw)
{
  using namespace millscale::similarity;
  const ScaledMill law = scale({3.9, ball_radius, 9.81, 1.0},
                               {2.6, Scheme::constant_gravity, Policy::offset_liner, 0.0, false});
  EXPECT_NEAR(offset_scaled(trapezoid_mill(), 2.6, ball_radius).radius(), law.mill.radius, 1e-14);
}

TEST(OffsetLiner, ErrorsTellTheScaleAndTheBall)
{
  try {
    offset_scaled(trapezoid_mill(), 10.0, 0.05);
    FAIL() << "the lifters of so small a mill vanish";
  } catch (const std::invalid_argument& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("S = 10"), std::string::npos);
    EXPECT_NE(text.find("0.05"), std::string::npos);
  }
  EXPECT_THROW(offset_scaled(trapezoid_mill(), 2.6, -0.02), std::invalid_argument);
  EXPECT_THROW(offset_scaled(trapezoid_mill(), 2.6, NAN), std::invalid_argument);
}

TEST(OffsetLiner, OfAPlainDrumIsADrum)
{
  const Lifters drum(Widths{3.9, 0.0, 0.0, 0.0, 0, 0.0});
  EXPECT_NEAR(offset_scaled(drum, 2.6, ball_radius).radius(), 3.88 / 2.6 + ball_radius, 1e-14);
}

}  // namespace
