#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "core/liner/nearest.h"
#include "core/liner/paper_liners.h"
#include "core/liner/polygon.h"

namespace {

using namespace millscale::liner;
using namespace millscale::test;

std::vector<Point> random_points(const Lifters& liner, int count)
{
  std::mt19937 random(7);
  std::uniform_real_distribution<double> coordinate(-1.1 * liner.radius(), 1.1 * liner.radius());
  std::vector<Point> points;
  for (int i = 0; i < count; ++i) {
    const double x = coordinate(random);
    points.push_back({x, coordinate(random)});
  }
  return points;
}

double distance_to_segment(Point p, Point a, Point b)
{
  const Point ab = b - a, ap = p - a;
  const double share = (ap.x * ab.x + ap.z * ab.z) / (ab.x * ab.x + ab.z * ab.z);
  const double clamped = share < 0.0 ? 0.0 : share > 1.0 ? 1.0 : share;
  return length(ap - Point{clamped * ab.x, clamped * ab.z});
}

/// Distance, and whether the point is inside, by checking every edge of a polygon.
double brute_force_distance(const Polygon& p, Point q)
{
  double best = INFINITY;
  bool within = false;
  for (std::size_t i = 0; i < p.nodes.size(); ++i) {
    const Point a = p.nodes[i], b = p.nodes[(i + 1) % p.nodes.size()];
    best = std::fmin(best, distance_to_segment(q, a, b));
    if ((a.z > q.z) != (b.z > q.z) && q.x < a.x + (q.z - a.z) / (b.z - a.z) * (b.x - a.x))
      within = !within;
  }
  return within ? best : -best;
}

TEST(Nearest, DistanceAgreesWithBruteForceOverAFinePolygon)
{
  for (const Lifters& liner : various_liners()) {
    const double chord_error = 1e-6 * liner.radius();
    const Polygon fine = polygon(liner, chord_error);
    for (const Point q : random_points(liner, 1000)) {
      const double expected = brute_force_distance(fine, q);
      const Nearest found = nearest(liner, q);
      // A chord lies inside the arc by up to chord_error, which may also flip a point's side.
      EXPECT_NEAR(found.distance, expected, 1.01 * chord_error);
      if (std::abs(expected) > chord_error) {
        EXPECT_EQ(inside(liner, q), expected > 0.0);
      }
    }
  }
}

TEST(Nearest, PointAndNormalLeadBackToTheQuery)
{
  for (const Lifters& liner : various_liners())
    for (const Point q : random_points(liner, 1000)) {
      const Nearest found = nearest(liner, q);
      const double rounding = 1e-13 * liner.radius();
      EXPECT_NEAR(length(found.normal), 1.0, 1e-12);
      EXPECT_NEAR(found.point.x + found.distance * found.normal.x, q.x, rounding);
      EXPECT_NEAR(found.point.z + found.distance * found.normal.z, q.z, rounding);
      EXPECT_NEAR(nearest(liner, found.point).distance, 0.0, rounding);
      EXPECT_EQ(found.distance > 0.0, inside(liner, q));
    }
}

TEST(Nearest, TurnsWithTheSectors)
{
  for (const Lifters& liner : various_liners()) {
    const int n = std::max(liner.lifters(), 1);
    for (const Point q : random_points(liner, 200)) {
      const Nearest here = nearest(liner, q);
      const Local polar{length(q), 0.0};
      for (int k = 1; k < n; k += 3) {
        const double angle = k * liner.pitch();
        const Nearest there = nearest(liner, Frame(polar_angle(q) + angle).point(polar));
        EXPECT_NEAR(there.distance, here.distance, 1e-13 * liner.radius());
        EXPECT_EQ(there.face, here.face);
        EXPECT_EQ(there.sector, (here.sector + k) % n);
      }
    }
  }
}

TEST(Nearest, MirrorsInTheGroovesCentreLine)
{
  const auto mirrored = [](Face face) {
    if (face == Face::leading) return Face::trailing;
    return face == Face::trailing ? Face::leading : face;
  };
  for (const Lifters& liner : various_liners()) {
    const int n = std::max(liner.lifters(), 1);
    for (const Point q : random_points(liner, 200)) {
      const double from_centre = polar_angle(q) - liner.groove_angle(0);
      const Point image = Frame(liner.groove_angle(0) - from_centre).point({length(q), 0.0});
      const Nearest here = nearest(liner, q), there = nearest(liner, image);
      EXPECT_NEAR(there.distance, here.distance, 1e-13 * liner.radius());
      EXPECT_EQ(there.face, mirrored(here.face));
      const int expected = here.face == Face::groove ? -here.sector : 1 - here.sector;
      EXPECT_EQ(there.sector, ((expected % n) + n) % n);
    }
  }
}

TEST(Nearest, KnowsTheFacesOfALifter)
{
  const Lifters liner = trapezoid_mill();
  const Frame lifter(liner.lifter_angle(3));
  const Local corner = liner.corner(), foot = liner.foot();
  const Local middle{0.5 * (corner.radial + foot.radial),
                     0.5 * (corner.tangential + foot.tangential)};
  const Local off{-std::sin(liner.face_angle()) * 0.01, std::cos(liner.face_angle()) * 0.01};

  const Nearest leading = nearest(
      liner, lifter.point({middle.radial + off.radial, middle.tangential + off.tangential}));
  EXPECT_EQ(leading.face, Face::leading);
  EXPECT_EQ(leading.sector, 3);
  EXPECT_NEAR(leading.distance, 0.01, 1e-14);

  const Nearest trailing = nearest(
      liner, lifter.point({middle.radial + off.radial, -middle.tangential - off.tangential}));
  EXPECT_EQ(trailing.face, Face::trailing);
  EXPECT_EQ(trailing.sector, 3);

  const Nearest top = nearest(liner, lifter.point({3.6, 0.0}));
  EXPECT_EQ(top.face, Face::top);
  EXPECT_EQ(top.sector, 3);
  EXPECT_NEAR(top.distance, 0.01, 1e-14);

  const Nearest in_lifter = nearest(liner, lifter.point({3.65, 0.0}));
  EXPECT_NEAR(in_lifter.distance, -0.04, 1e-14);
  EXPECT_EQ(in_lifter.face, Face::top);

  const Nearest groove = nearest(liner, Frame(liner.groove_angle(24)).point({3.88, 0.0}));
  EXPECT_EQ(groove.face, Face::groove);
  EXPECT_EQ(groove.sector, 24);
  EXPECT_NEAR(groove.distance, 0.02, 1e-14);
}

TEST(Nearest, AConvexEdgeIsRoundedByTheDistance)
{
  const Lifters liner = trapezoid_mill();
  const Frame lifter(liner.lifter_angle(0));
  const Local corner = liner.corner();
  // Between the normals of the top and of the face, at any angle, the corner is nearest.
  for (const double angle : {0.1, 0.7, 1.3}) {
    const Nearest found =
        nearest(liner, lifter.point({corner.radial - 0.02 * std::cos(angle),
                                     corner.tangential + 0.02 * std::sin(angle)}));
    EXPECT_NEAR(found.distance, 0.02, 1e-14);
    EXPECT_NEAR(length(found.point - lifter.point(corner)), 0.0, 1e-14);
  }
}

TEST(Nearest, TiesAreResolvedTheSameWayEveryTime)
{
  const Lifters liner = trapezoid_mill();
  // High above groove 0 the corners of both lifters are equally near. The corner ahead is returned,
  // and of its two faces the side.
  const Nearest middle = nearest(liner, {0.0, -3.4});
  EXPECT_EQ(middle.face, Face::trailing);
  EXPECT_EQ(middle.sector, 1);
  EXPECT_LT(middle.point.x, 0.0);
  // At a foot, where groove and face join, the groove is returned.
  EXPECT_EQ(nearest(liner, Frame(liner.lifter_angle(0)).point(liner.foot())).face, Face::groove);
  const Nearest axis = nearest(liner, {0.0, 0.0});
  EXPECT_NEAR(axis.distance, 3.61, 1e-14);
  EXPECT_EQ(axis.sector, 1);
  EXPECT_EQ(nearest(liner, {-0.0, -0.0}).sector, 1);
}

}  // namespace
