#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>

#include "core/liner/groove_box.h"
#include "core/liner/nearest.h"
#include "core/liner/offset.h"
#include "core/liner/paper_liners.h"
#include "core/paper_table.h"

namespace {

using namespace millscale::liner;
using millscale::pi;
using namespace millscale::test;

constexpr double degree = pi / 180.0;

std::string error_of(const std::function<void()>& construct)
{
  try {
    construct();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

std::string error_of(const Widths& w)
{
  return error_of([&w] { Lifters{w}; });
}

std::string error_of(const Slopes& s)
{
  return error_of([&s] { Lifters{s}; });
}

TEST(Dimensions, Table4FollowsFromThePhysicalMillToTheMillimetre)
{
  const auto rows = paper_table("table4_geometry.csv");
  ASSERT_EQ(rows.size(), 6u);
  const double half_millimetre = 0.5 + 1e-9;
  for (const auto& row : rows) {
    const double R = number(row, "R_mm");
    const Lifters mill = scaled(trapezoid_mill(), 3900.0 / R);
    EXPECT_NEAR(1e3 * mill.radius(), R, 1e-9);
    EXPECT_NEAR(1e3 * mill.lifter_top_radius(), number(row, "r_mm"), half_millimetre);
    EXPECT_NEAR(1e3 * mill.lifter_top_width(), number(row, "D1_mm"), half_millimetre);
    EXPECT_NEAR(1e3 * mill.groove_width(), number(row, "D2_mm"), half_millimetre);
    EXPECT_NEAR(mill.face_angle(), trapezoid_mill().face_angle(), 1e-12);
  }
}

TEST(Dimensions, TrapezoidReadingOfThePaperLeansItsFacesByNineDegrees)
{
  EXPECT_NEAR(trapezoid_mill().face_angle(), 9.36 * degree, 0.005 * degree);
}

TEST(Dimensions, FeetAreAGrooveWidthApart)
{
  for (const Lifters& liner : various_liners()) {
    if (liner.lifters() == 0) continue;
    const Point a = Frame(liner.lifter_angle(0)).point(liner.foot());
    const Local foot = liner.foot();
    const Point b = Frame(liner.lifter_angle(1)).point({foot.radial, -foot.tangential});
    EXPECT_NEAR(length(b - a), liner.groove_width(), 1e-14 * liner.radius());
    EXPECT_NEAR(length(a), liner.radius(), 1e-14 * liner.radius());
  }
}

TEST(Dimensions, BothReadingsDescribeTheSameLiner)
{
  for (const Lifters& liner : various_liners()) {
    const Lifters by_widths(Widths{liner.radius(), liner.lifter_top_radius(),
                                   liner.lifter_top_width(), liner.groove_width(), liner.lifters(),
                                   liner.phase()});
    const Lifters by_slopes(Slopes{liner.radius(), liner.lifter_top_radius(),
                                   liner.lifter_top_width(), liner.face_angle(), liner.lifters(),
                                   liner.phase()});
    EXPECT_NEAR(by_widths.face_angle(), liner.face_angle(), 1e-12);
    EXPECT_NEAR(by_slopes.groove_width(), liner.groove_width(), 1e-13);
  }
}

TEST(Dimensions, ParallelFacesAreTheTopWidthApartAtTheFoot)
{
  const Lifters liner = parallel_mill();
  EXPECT_NEAR(2.0 * liner.foot().tangential, liner.lifter_top_width(), 1e-14);
}

TEST(Dimensions, LifterTrailsItsGroove)
{
  const Lifters liner = trapezoid_mill(0.2);
  EXPECT_DOUBLE_EQ(liner.groove_angle(0), 0.2);
  EXPECT_DOUBLE_EQ(liner.lifter_angle(0), 0.2 - 0.5 * liner.pitch());
}

TEST(Dimensions, GrooveBoxHoldsTheGrooveAndNothingBeyondItsFaces)
{
  const Lifters liner = trapezoid_mill();
  const auto box = groove_box(liner);
  for (const Point corner : {box[2], box[3]}) {
    EXPECT_NEAR(length(corner), length(liner.corner()), 1e-14);
    EXPECT_NEAR(nearest(liner, corner).distance, 0.0, 1e-14);
  }
  EXPECT_NEAR(box[0].z, -liner.radius(), 1e-14);
  EXPECT_NEAR(box[0].x, -box[1].x, 1e-14);
  // The outer corners lie on the planes of the faces, a little behind the feet.
  const Point foot = Frame(liner.lifter_angle(0)).point(liner.foot());
  const Point along = box[0] - box[3], to_foot = foot - box[3];
  EXPECT_NEAR(along.x * to_foot.z - along.z * to_foot.x, 0.0, 1e-14);
  EXPECT_THROW(groove_box(Lifters(Widths{1.0, 0.0, 0.0, 0.0, 0, 0.0})), std::invalid_argument);
}

TEST(DimensionErrors, NameTheValueAndTheAcceptedRange)
{
  const Widths good{3.9, 3.61, 0.25, 0.635, 25, 0.0};
  const auto with = [&good](double Widths::*member, double value) {
    Widths changed = good;
    changed.*member = value;
    return error_of(changed);
  };
  EXPECT_EQ(error_of(good), "");
  EXPECT_NE(with(&Widths::radius, 0.0).find("liner radius: must be > 0 m, got 0"),
            std::string::npos);
  EXPECT_NE(with(&Widths::lifter_top_radius, 3.9).find("> 0 and < 3.9 m"), std::string::npos);
  EXPECT_NE(with(&Widths::lifter_top_radius, -1.0).find("got -1"), std::string::npos);
  EXPECT_NE(with(&Widths::lifter_top_width, 0.0).find("lifter top width"), std::string::npos);
  EXPECT_NE(with(&Widths::lifter_top_width, 0.92).find("< 0.912"), std::string::npos);
  EXPECT_NE(with(&Widths::groove_width, 0.0).find("overlap at the foot"), std::string::npos);
  EXPECT_NE(with(&Widths::groove_width, 0.98).find("2 R sin(pi / n) = 0.977599"),
            std::string::npos);
  EXPECT_NE(with(&Widths::groove_width, 0.74).find("undercut"), std::string::npos);
  const Widths sunken{1.0, 0.995, 0.01, 0.02, 25, 0.0};
  EXPECT_NE(error_of(sunken).find("below the chord of its foot"), std::string::npos);
}

TEST(DimensionErrors, FaceAngleKeepsLiftersApartAndFacesFromLeaningOver)
{
  const Slopes good{3.9, 3.61, 0.25, 0.2, 25, 0.0};
  const auto with_angle = [&good](double angle) {
    Slopes changed = good;
    changed.face_angle = angle;
    return error_of(changed);
  };
  EXPECT_EQ(with_angle(0.2), "");
  EXPECT_NE(with_angle(-0.01).find("undercut"), std::string::npos);
  EXPECT_NE(with_angle(0.5 * pi).find("pi/2"), std::string::npos);
  const std::string overlapping = with_angle(1.3);
  EXPECT_NE(overlapping.find("overlap at the foot"), std::string::npos);
  // The reported limit is exact: a slightly smaller value is accepted, a slightly larger value is
  // not.
  const double limit = std::stod(overlapping.substr(overlapping.find("< ") + 2));
  EXPECT_EQ(with_angle(limit - 1e-6), "");
  EXPECT_NE(with_angle(limit + 1e-6), "");
}

TEST(DimensionErrors, WidthLimitsAreSharp)
{
  Widths w{3.9, 3.61, 0.25, 0.74, 25, 0.0};
  const std::string undercut = error_of(w);
  const double widest = std::stod(undercut.substr(undercut.find("<= ") + 3));
  w.groove_width = widest - 1e-8;
  EXPECT_EQ(error_of(w), "");
  w.groove_width = widest + 1e-8;
  EXPECT_NE(error_of(w), "");
}

TEST(DimensionErrors, NotANumberAndInfinityAreRefusedEverywhere)
{
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double bad : {std::nan(""), infinity, -infinity}) {
    for (double Widths::*member :
         {&Widths::radius, &Widths::lifter_top_radius, &Widths::lifter_top_width,
          &Widths::groove_width, &Widths::phase}) {
      Widths w{3.9, 3.61, 0.25, 0.635, 25, 0.0};
      w.*member = bad;
      EXPECT_NE(error_of(w), "");
    }
    EXPECT_NE(error_of(Slopes{3.9, 3.61, 0.25, bad, 25, 0.0}), "");
    EXPECT_NE(error_of([bad] { scaled(trapezoid_mill(), bad); }), "");
    EXPECT_NE(error_of([bad] { offset(trapezoid_mill(), bad); }), "");
  }
}

TEST(DimensionErrors, PlainDrumTakesNoLifterDimensions)
{
  EXPECT_EQ(error_of(Widths{3.9, 0.0, 0.0, 0.0, 0, 0.0}), "");
  EXPECT_NE(error_of(Widths{3.9, 0.0, 0.0, 0.635, 0, 0.0}).find("plain drum"), std::string::npos);
  EXPECT_NE(error_of(Slopes{3.9, 0.0, 0.0, 0.1, 0, 0.0}).find("plain drum"), std::string::npos);
  EXPECT_NE(error_of(Widths{3.9, 3.61, 0.25, 0.635, 1, 0.0}).find("2 to 10000"), std::string::npos);
  EXPECT_NE(error_of(Widths{3.9, 3.61, 1e-4, 1e-4, 10001, 0.0}).find("2 to 10000, got 10001"),
            std::string::npos);
  EXPECT_NE(error_of(Widths{3.9, 3.61, 0.25, 0.635, -2, 0.0}).find("got -2"), std::string::npos);
}

}  // namespace
