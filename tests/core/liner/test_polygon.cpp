#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>

#include "core/liner/area.h"
#include "core/liner/nearest.h"
#include "core/liner/paper_liners.h"
#include "core/liner/polygon.h"

namespace {

using namespace millscale::liner;
using millscale::pi;
using namespace millscale::test;

double enclosed(const Polygon& p)
{
  double twice = 0.0;
  for (std::size_t i = 0; i < p.nodes.size(); ++i) {
    const Point a = p.nodes[i], b = p.nodes[(i + 1) % p.nodes.size()];
    twice += a.z * b.x - a.x * b.z;
  }
  return 0.5 * twice;
}

Point rotated(Point p, double angle)
{
  // Rotation that takes polar angle psi to psi + angle.
  const double c = std::cos(angle), s = std::sin(angle);
  return {p.x * c + p.z * s, -p.x * s + p.z * c};
}

TEST(Area, IsTheLimitOfThePolygons)
{
  for (const Lifters& liner : various_liners()) {
    const double exact = area(liner), R = liner.radius();
    for (const double chord_error : {1e-3, 1e-4, 1e-6}) {
      // A chord cuts off two thirds of chord times sagitta: at most 2/3 2 pi R chord_error in all.
      const double missing = exact - enclosed(polygon(liner, chord_error * R));
      EXPECT_GE(missing, -1e-12 * exact);
      EXPECT_LE(missing, 4.2 * R * chord_error * R);
    }
  }
}

TEST(Area, AgreesWithCountingRandomPoints)
{
  const Lifters liner = trapezoid_mill();
  std::mt19937 random(1);
  std::uniform_real_distribution<double> coordinate(-3.9, 3.9);
  const int tries = 400000;
  int hits = 0;
  for (int i = 0; i < tries; ++i)
    hits += inside(liner, {coordinate(random), coordinate(random)}) ? 1 : 0;
  const double share = static_cast<double>(hits) / tries;
  const double deviation = std::sqrt(share * (1.0 - share) / tries) * 7.8 * 7.8;
  EXPECT_NEAR(share * 7.8 * 7.8, area(liner), 4.0 * deviation);
}

TEST(Area, OfAPlainDrumIsTheCircle)
{
  EXPECT_DOUBLE_EQ(area(Lifters(Widths{2.0, 0.0, 0.0, 0.0, 0, 0.0})), 4.0 * pi);
}

TEST(Polygon, TurnsInTheDirectionOfRotationOnce)
{
  for (const Lifters& liner : various_liners()) {
    const Polygon p = polygon(liner, 1e-3);
    ASSERT_EQ(p.nodes.size(), p.faces.size());
    double turned = 0.0;
    for (std::size_t i = 0; i < p.nodes.size(); ++i) {
      const double step = std::remainder(
          polar_angle(p.nodes[(i + 1) % p.nodes.size()]) - polar_angle(p.nodes[i]), 2.0 * pi);
      // Steep faces lead back a little from corner to foot.
      if (p.faces[i] == Face::groove || p.faces[i] == Face::top) {
        EXPECT_GT(step, 0.0);
      }
      turned += step;
    }
    EXPECT_NEAR(turned, 2.0 * pi, 1e-12);
  }
}

TEST(Polygon, IsPeriodicFromSectorToSector)
{
  for (const Lifters& liner : various_liners()) {
    if (liner.lifters() == 0) continue;
    const Polygon p = polygon(liner, 1e-3);
    const std::size_t sector = p.nodes.size() / liner.lifters();
    ASSERT_EQ(sector * liner.lifters(), p.nodes.size());
    for (std::size_t i = 0; i < p.nodes.size(); ++i) {
      const std::size_t next = (i + sector) % p.nodes.size();
      const Point turned = rotated(p.nodes[i], liner.pitch());
      EXPECT_NEAR(length(turned - p.nodes[next]), 0.0, 1e-14 * liner.radius());
      EXPECT_EQ(p.faces[i], p.faces[next]);
    }
  }
}

TEST(Polygon, EdgesBelongToTheirFaces)
{
  for (const Lifters& liner : various_liners()) {
    const double chord_error = 1e-3 * liner.radius();
    const Polygon p = polygon(liner, chord_error);
    for (std::size_t i = 0; i < p.nodes.size(); ++i) {
      const Point a = p.nodes[i], b = p.nodes[(i + 1) % p.nodes.size()];
      const Point middle{0.5 * (a.x + b.x), 0.5 * (a.z + b.z)};
      const Nearest found = nearest(liner, middle);
      EXPECT_NEAR(nearest(liner, a).distance, 0.0, 1e-14 * liner.radius());
      EXPECT_EQ(found.face, p.faces[i]);
      EXPECT_LE(std::abs(found.distance), chord_error * (1.0 + 1e-9));
      if (p.faces[i] != Face::groove) {
        EXPECT_NEAR(found.distance, 0.0, 1e-14 * liner.radius());
      }
    }
  }
}

TEST(Polygon, TakesNoMoreChordsThanTheErrorAsksFor)
{
  const double R = 3.9, half_angle = 0.08;
  for (const double chord_error : {1e-3, 5e-4, 1e-5}) {
    const auto sagitta = [&](int count) { return R * (1.0 - std::cos(half_angle / count)); };
    const int count = chords(R, half_angle, chord_error);
    EXPECT_LE(sagitta(count), chord_error);
    if (count > 1) {
      EXPECT_GT(sagitta(count - 1), chord_error);
    }
  }
}

TEST(Polygon, RefusesAChordErrorOutsideItsRange)
{
  for (const double bad : {0.0, -1e-3, 3.9, HUGE_VAL, std::nan("")})
    EXPECT_THROW(polygon(trapezoid_mill(), bad), std::invalid_argument);
}

}  // namespace
