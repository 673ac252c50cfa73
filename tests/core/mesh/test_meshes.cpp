#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "core/mesh/curvature_range.h"
#include "core/mesh/triangle.h"
#include "core/mesh/wall_around.h"

namespace {

using millscale::dot;
using millscale::Vector;
using namespace millscale::mesh;

constexpr double pi = 3.14159265358979323846;
using Mesh = std::vector<Triangle>;

/// A wall with these radii at equal angles around y, from y = 0 to 1, in random order and sense.
Mesh wall(const std::vector<double>& radii, double x = 0.0, double z = 0.0)
{
  const auto node = [&](std::size_t k, double y) {
    const double angle = 2.0 * pi * static_cast<double>(k) / static_cast<double>(radii.size());
    const double r = radii[k % radii.size()];
    return Vector{x + r * std::cos(angle), y, z + r * std::sin(angle)};
  };
  Mesh mesh;
  for (std::size_t k = 0; k < radii.size(); ++k)
    for (const double y : {0.0, 0.5}) {
      const std::size_t next = (k + 1) % radii.size();
      mesh.push_back({node(k, y), node(next, y), node(k, y + 0.5)});
      mesh.push_back({node(next, y), node(next, y + 0.5), node(k, y + 0.5)});
    }
  std::mt19937 random(5);
  std::shuffle(mesh.begin(), mesh.end(), random);
  for (Triangle& t : mesh)
    if (random() % 2) std::swap(t[0], t[1]);
  return mesh;
}

const Axis y_axis{{0, 1, 0}, {0, 0, 0}};

WallAround around(const Mesh& mesh, const Axis& axis = y_axis, double low = 0.0, double high = 1.0)
{
  WallAround seen(axis, low, high);
  for (const Triangle& t : mesh) seen.add(t);
  return seen;
}

TEST(Meshes, APolygonHasValleysOnly)
{
  for (const int sides : {7, 40, 360}) {
    const CurvatureRange range = curvature_range(wall(std::vector<double>(sides, 2.0)), y_axis);
    EXPECT_NEAR(range.low, 2.0 * pi / sides, 1e-12);
    EXPECT_TRUE(std::isinf(range.high));
  }
}

TEST(Meshes, SeenFromOutsideValleysAreRidges)
{
  const Axis outside{{0, 1, 0}, {5, 0, 0}};
  const Mesh part = wall(std::vector<double>(40, 2.0));
  EXPECT_NEAR(curvature_range(part, outside).high, 2.0 * pi / 40, 1e-12);
}

TEST(Meshes, AWaveHasTheFoldsOfItsSection)
{
  std::vector<double> radii;
  for (int k = 0; k < 96; ++k) radii.push_back(1.22 + 0.03 * std::cos(16.0 * pi * k / 96.0));
  const CurvatureRange range = curvature_range(wall(radii), y_axis);
  // Evaluated another way: by the turn of the section's direction, which is positive in a valley.
  const auto node = [&](int k) {
    const double angle = 2.0 * pi * k / 96.0, r = radii[static_cast<std::size_t>((k + 96) % 96)];
    return std::pair{r * std::cos(angle), r * std::sin(angle)};
  };
  double ridge = pi, valley = 0.0;
  std::vector<double> turns;
  for (int k = 0; k < 96; ++k) {
    const auto [xa, ya] = node(k - 1);
    const auto [xb, yb] = node(k);
    const auto [xc, yc] = node(k + 1);
    turns.push_back(
        std::remainder(std::atan2(yc - yb, xc - xb) - std::atan2(yb - ya, xb - xa), 2.0 * pi));
    if (turns.back() < 0.0) ridge = std::min(ridge, -turns.back());
  }
  for (const double turn : turns)
    if (turn > 0.0 && turn < ridge) valley = std::max(valley, turn);
  EXPECT_GT(valley, 0.0);
  EXPECT_NEAR(range.high, ridge, 1e-9);
  EXPECT_NEAR(range.low, valley, 1e-9);
}

TEST(Meshes, RoundingOfAFlatFaceIsNoFold)
{
  Mesh mesh = wall({1.0, 1.0, 1.0, 1.0});
  for (Triangle& t : mesh)
    for (Vector& p : t)
      for (double& x : p) x = std::round(x * 1e6) / 1e6 + (p[1] == 0.5 ? 1e-5 : 0.0);
  const CurvatureRange range = curvature_range(mesh, y_axis);
  EXPECT_NEAR(range.low, pi / 2.0, 1e-3);
  EXPECT_TRUE(std::isinf(range.high));
}

TEST(Meshes, TheWallAroundAnAxisIsAsFarAsItIs)
{
  // Tilted axis, off the origin: the mesh is built around y and then moved.
  const double c = std::cos(0.4), s = std::sin(0.4);
  Mesh mesh = wall(std::vector<double>(200, 0.3));
  for (Triangle& t : mesh)
    for (Vector& p : t) p = {p[0] + 7.0, c * p[1] - s * p[2], s * p[1] + c * p[2]};
  const WallAround seen = around(mesh, {{0, c, s}, {7.0, 0, 0}});
  EXPECT_NEAR(seen.radius(), 0.3, 1e-4);
  EXPECT_EQ(seen.open(), 0.0);
}

TEST(Meshes, LiftersOuterSkinsAndEndPlatesDoNotChangeTheRadius)
{
  std::vector<double> radii;
  for (int k = 0; k < 200; ++k) radii.push_back(k % 20 < 12 ? 0.27 : 0.3);
  Mesh mesh = wall(radii);
  for (const Triangle& t : wall(std::vector<double>(8, 0.5))) mesh.push_back(t);
  for (const double y : {0.0, 1.0}) mesh.push_back({{{-3, y, -3}, {3, y, -3}, {0, y, 5}}});
  const WallAround seen = around(mesh);
  EXPECT_NEAR(seen.radius(), 0.3, 1e-3);
  EXPECT_EQ(seen.open(), 0.0);
}

TEST(Meshes, AHoleIsAsLargeAsItIs)
{
  Mesh mesh = wall(std::vector<double>(36, 0.3));
  ASSERT_EQ(mesh.size(), 144u);
  mesh.pop_back();
  EXPECT_NEAR(around(mesh).open(), 1.0 / 144.0, 0.001);
  EXPECT_EQ(around({}).open(), 1.0);
  EXPECT_EQ(around({}).radius(), 0.0);
}

TEST(Meshes, ADirectionHasAWallIfTheRayMeetsATriangle)
{
  const Mesh mesh = wall(std::vector<double>(36, 0.3));
  std::mt19937 random(11);
  std::uniform_real_distribution<double> angle(-pi, pi), height(0.01, 0.99), distance(0.01, 0.9);
  for (int k = 0; k < 500; ++k) {
    const double a = angle(random), r = distance(random);
    const Vector p{r * std::cos(a), height(random), r * std::sin(a)};
    const auto hit = [&](const Triangle& t) { return in_direction(t, y_axis, p); };
    EXPECT_GE(std::count_if(mesh.begin(), mesh.end(), hit), 1);
    EXPECT_LE(std::count_if(mesh.begin(), mesh.end(), hit), 2);  // on an edge
    const Vector past{p[0], 1.5, p[2]}, other_side{-p[0], p[1], -p[2]};
    for (const Triangle& t : mesh) {
      EXPECT_FALSE(in_direction(t, y_axis, past));
      EXPECT_FALSE(hit(t) && in_direction(t, y_axis, other_side));
    }
  }
}

TEST(Meshes, TheCentreOfTheAreaDoesNotDependOnTheTriangles)
{
  Mesh mesh = wall(std::vector<double>(24, 0.3), 0.5, 0.2);
  AreaSums coarse, fine;
  for (const Triangle& t : mesh) coarse.add(t);
  // Half of the mesh is divided.
  for (const Triangle& t : mesh) {
    if (t[0][0] < 0.5) {
      fine.add(t);
      continue;
    }
    Vector middle;
    for (int d = 0; d < 3; ++d) middle[d] = (t[0][d] + t[1][d] + t[2][d]) / 3.0;
    for (int i = 0; i < 3; ++i) fine.add({t[i], t[(i + 1) % 3], middle});
  }
  EXPECT_NEAR(coarse.area, fine.area, 1e-14);
  for (const AreaSums& sums : {coarse, fine}) {
    EXPECT_NEAR(sums.centre()[0], 0.5, 1e-14);
    EXPECT_NEAR(sums.centre()[1], 0.5, 1e-14);
    EXPECT_NEAR(sums.centre()[2], 0.2, 1e-14);
  }
}

TEST(Meshes, AFactorIsKnownByWhatItLooksLike)
{
  const auto says = [](double factor, double S) { return advice_on_factor(factor, S, "0.3"); };
  EXPECT_EQ(says(0.5, 1.0), "was a diameter given as radius? Then give `radius 0.3`");
  EXPECT_EQ(says(998.0, 1.0),
            "is the mesh in mm? Then multiply `scale` of fix mesh/surface by 0.001");
  EXPECT_EQ(says(39.4, 1.0).rfind("is the mesh in inches?", 0), 0u);
  EXPECT_EQ(says(2.6, 2.6).rfind("is the mesh that of the physical mill?", 0), 0u);
  EXPECT_EQ(says(1.0 / 2.6, 2.6).rfind("was the mesh scaled by 1 / S twice?", 0), 0u);
  EXPECT_EQ(says(1.2, 2.6), "give `radius 0.3`, or multiply `scale` of fix mesh/surface by 0.833");
}

}  // namespace
