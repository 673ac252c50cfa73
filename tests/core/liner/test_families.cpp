#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "core/liner/contacts.h"
#include "core/liner/liner_families.h"
#include "core/liner/nearest.h"
#include "core/liner/polygon.h"

namespace {

using namespace millscale::liner;
using namespace millscale::test;
using millscale::pi;

constexpr double radius = 0.012;  // of the balls [m]

Point operator+(Point a, Point b)
{
  return {a.x + b.x, a.z + b.z};
}
Point operator*(double s, Point a)
{
  return {s * a.x, s * a.z};
}
double inner(Point a, Point b)
{
  return a.x * b.x + a.z * b.z;
}

/// Hertz's force at an overlap, per its factor.
double hertz(double overlap)
{
  return overlap > 0.0 ? overlap * std::sqrt(overlap) : 0.0;
}

/// A ball above an edge of a polygon.
struct Touch {
  double distance;
  Point normal;  ///< unit vector to the centre
};

/// The fine triangle mesh of an outline, searched edge by edge. A local minimum of the distance is
/// a foot inside an edge that is no farther than its neighbours over shallow folds, or a node whose
/// edges are both nearest there. Minima with normals that differ by less than a corner are one
/// contact, the nearest.
class Mesh {
 public:
  Mesh(const Profile& profile, double chord_error) : polygon_(polygon(profile, chord_error)) {}

  std::vector<Touch> touches(Point p, double ball) const
  {
    const std::vector<Point>& nodes = polygon_.nodes;
    const std::size_t n = nodes.size();
    std::vector<Touch> minima;
    const auto add = [&](Point foot) {
      const double distance = length(p - foot);
      if (distance < ball) minima.push_back({distance, (1.0 / distance) * (p - foot)});
    };
    for (std::size_t i = 0; i < n; ++i) {
      if (length(nodes[i] - p) > 0.4) continue;  // no edge is so long
      const double here = share(i, p), before = share((i + n - 1) % n, p);
      if (here > 0.0 && here < 1.0 && !falls(i, (i + 1) % n, p) && !falls(i, (i + n - 1) % n, p))
        add(foot(i, p));
      if (here <= 0.0 && before >= 1.0) add(nodes[i]);
    }
    std::sort(minima.begin(), minima.end(),
              [](const Touch& a, const Touch& b) { return a.distance < b.distance; });
    std::vector<Touch> result;
    for (const Touch& m : minima)
      if (std::none_of(result.begin(), result.end(),
                       [&](const Touch& r) { return inner(r.normal, m.normal) > std::cos(0.25); }))
        result.push_back(m);
    return result;
  }

 private:
  Point along(std::size_t i) const
  {
    return polygon_.nodes[(i + 1) % polygon_.nodes.size()] - polygon_.nodes[i];
  }
  /// Where the foot of a point lies along edge i.
  double share(std::size_t i, Point p) const
  {
    return inner(p - polygon_.nodes[i], along(i)) / inner(along(i), along(i));
  }
  Point foot(std::size_t i, Point p) const
  {
    return polygon_.nodes[i] + std::clamp(share(i, p), 0.0, 1.0) * along(i);
  }
  /// Return whether the distance falls from an edge to the next one, over a shallow fold.
  bool falls(std::size_t i, std::size_t next, Point p) const
  {
    const double cosine = inner(along(i), along(next)) / (length(along(i)) * length(along(next)));
    return cosine > std::cos(0.25) && length(p - foot(next, p)) < length(p - foot(i, p));
  }

  Polygon polygon_;
};

/// A random point at a distance from a random piece of the profile.
class RandomTouch {
 public:
  explicit RandomTouch(const Profile& profile) : profile_(profile) {}

  Point at(double from, double to)
  {
    const std::vector<Piece>& pieces = profile_.pieces();
    const auto pick = [this](std::size_t count) {
      return std::uniform_int_distribution<std::size_t>(0, count - 1)(random_);
    };
    const Piece& piece = pieces[pick(pieces.size())];
    const double share = uniform(-0.1, 1.1);
    const double sweep = piece.half_angle * (2.0 * share - 1.0);
    const Local on = piece.is_arc() ? piece.centre + piece.arc_radius * turned(piece.middle, sweep)
                                    : piece.begin + share * (piece.end - piece.begin);
    const Local normal =
        left_of(piece.is_arc() ? (1.0 / piece.arc_radius) * left_of(on - piece.centre)
                               : piece.tangent_begin);
    const std::size_t sector = pick(static_cast<std::size_t>(profile_.sectors()));
    return Frame(profile_.sector_angle(static_cast<int>(sector)))
        .point(on + uniform(from, to) * normal);
  }

  double uniform(double low, double high)
  {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }

 private:
  const Profile& profile_;
  std::mt19937 random_{12};
};

constexpr double least_arc = 0.006;  // least radius of an arc of the families [m]

TEST(Families, ForcesOfRandomTouchesAreThoseOfAFineMesh)
{
  constexpr double chord_error = 1e-7;
  for (const Family& family : liner_families()) {
    SCOPED_TRACE(family.name);
    const Mesh mesh(family.profile, chord_error);
    const ContactFinder finder(family.profile, radius);
    RandomTouch random(family.profile);
    int count = 0, two = 0;
    while (count < 10'000) {
      const Point p = random.at(0.85 * radius, radius);
      if (nearest(family.profile, p).distance < 0.86 * radius) continue;
      const Contacts found = finder.contacts(p, radius);
      const std::vector<Touch> expected = mesh.touches(p, radius);
      Point force{0.0, 0.0}, of_mesh{0.0, 0.0};
      double error = 0.0;
      // A chord is up to its error nearer; its normal is off by half its angle at most.
      const auto add = [&](Point& sum, double overlap, Point normal) {
        sum = sum + hertz(overlap) * normal;
        error += 1.5 * std::sqrt(overlap + chord_error) * chord_error +
                 hertz(overlap) * std::sqrt(2.0 * chord_error / least_arc);
      };
      for (int c = 0; c < found.count; ++c)
        add(force, found.contact[c].overlap, found.contact[c].normal);
      for (const Touch& touch : expected) add(of_mesh, radius - touch.distance, touch.normal);
      ASSERT_LE(length(force - of_mesh), error) << found.count << ' ' << expected.size();
      count += found.count > 0;
      two += found.count > 1;
    }
    if (family.profile.surfaces_per_sector() > 0) {
      EXPECT_GT(two, 50);
    }
  }
}

TEST(Families, TheGridKnowsWhichPointsAreInside)
{
  for (const Family& family : liner_families()) {
    SCOPED_TRACE(family.name);
    std::mt19937 random(6);
    std::uniform_real_distribution<double> psi(-pi, pi), r(0.8, 1.1);
    for (const double reach : {0.2 * radius, radius, 4.0 * radius}) {
      const ContactFinder finder(family.profile, reach);
      int outside = 0;
      for (int i = 0; i < 5'000; ++i) {
        const Point p = Frame(psi(random)).point({r(random), 0.0});
        ASSERT_EQ(finder.inside(p), inside(family.profile, p)) << p.x << ' ' << p.z;
        outside += !finder.inside(p);
      }
      EXPECT_GT(outside, 1'000);
      EXPECT_LT(outside, 4'500);
    }
  }
}

TEST(Families, TheGridListsFewPiecesWhateverTheirNumber)
{
  const auto longest_list = [](const Profile& profile) {
    const PieceGrid grid(profile, 1.5 * radius, 0.5 * radius);
    std::mt19937 random(9);
    std::uniform_real_distribution<double> psi(-0.5 * profile.pitch(), 0.5 * profile.pitch()),
        r(profile.clear_radius() - radius, profile.radius());
    std::ptrdiff_t longest = 0;
    for (int i = 0; i < 5'000; ++i) {
      const double angle = psi(random), distance = r(random);
      const auto near = grid.near({distance * std::cos(angle), distance * std::sin(angle)});
      longest = std::max(longest, near.end() - near.begin());
    }
    return longest;
  };
  for (const Family& family : liner_families()) {
    if (family.profile.sectors() == 1) continue;
    SCOPED_TRACE(family.name);
    // Chords of half a ball radius or more, up to 40 in a sector.
    ASSERT_LE(longest_list(with_chords(family.profile, 1e-4)), 16);
    ASSERT_LE(longest_list(all_around(family.profile)), longest_list(family.profile) + 2);
  }
}

TEST(Families, ForcesOnLinesAreExact)
{
  for (const Family& family : liner_families()) {
    SCOPED_TRACE(family.name);
    const ContactFinder finder(family.profile, radius);
    RandomTouch random(family.profile);
    for (int k = 0; k < family.profile.sectors(); ++k) {
      const Frame frame(family.profile.sector_angle(k));
      for (const Piece& piece : family.profile.pieces()) {
        if (piece.is_arc()) continue;
        for (int i = 0; i < 20; ++i) {
          const double away = random.uniform(0.9, 0.999) * radius;
          const Local normal = left_of(piece.tangent_begin);
          const Local on = piece.begin + random.uniform(0.05, 0.95) * (piece.end - piece.begin);
          const Contacts found = finder.contacts(frame.point(on + away * normal), radius);
          const auto same = [&](const Contact& c) {
            return std::abs(c.overlap - (radius - away)) < 1e-13 &&
                   length(c.normal - frame.point(normal)) < 1e-12;
          };
          EXPECT_TRUE(
              std::any_of(found.contact.begin(), found.contact.begin() + found.count, same));
        }
      }
    }
  }
}

/// The joint where a piece begins, in space: the directions of the pieces to the left of which the
/// cavity is.
struct Joint {
  Point at, before, after;
  double turn;
  bool corner, in_fillet;  ///< in_fillet: at an arc that is too narrow for the ball
};

std::vector<Joint> joints(const Profile& profile)
{
  std::vector<Joint> result;
  for (int k = 0; k < profile.sectors(); k += std::max(1, profile.sectors() - 1)) {
    const Frame frame(profile.sector_angle(k));
    const Piece* last = &profile.pieces().back();
    const auto narrow = [](const Piece& p) { return p.arc_radius > 0.0 && p.arc_radius < radius; };
    for (const Piece& piece : profile.pieces()) {
      result.push_back({frame.point(piece.begin),
                        frame.point(turned(piece.tangent_begin, -piece.turn)),
                        frame.point(piece.tangent_begin), piece.turn, piece.corner,
                        narrow(piece) || narrow(*last)});
      last = &piece;
    }
  }
  return result;
}

TEST(Families, SmoothJointsAreOneContactWithoutAJump)
{
  int joints_seen = 0;
  for (const Family& family : liner_families()) {
    SCOPED_TRACE(family.name);
    const ContactFinder finder(family.profile, radius);
    for (const Joint& joint : joints(family.profile)) {
      if (joint.turn != 0.0 || joint.in_fillet) continue;
      ++joints_seen;
      // Along the tangent at 0.9 radii, where no other piece is in reach.
      const Point normal{joint.after.z, -joint.after.x};
      const Point inward = nearest(family.profile, joint.at + 0.5 * radius * normal).distance > 0.0
                               ? normal
                               : -1.0 * normal;
      const double step = 1e-4 * radius;
      double before = -1.0;
      int surface = -1;
      for (int i = -100; i <= 100; ++i) {
        const Point p = joint.at + 0.9 * radius * inward + (i * step) * joint.after;
        const Contacts found = finder.contacts(p, radius);
        ASSERT_EQ(found.count, 1);
        if (before >= 0.0) {
          // The distance to an arc changes by the sine of the angle to its normal.
          const double sine = (std::abs(i) + 1) * step / least_arc;
          ASSERT_LE(std::abs(found.contact[0].overlap - before), step * sine + 1e-14);
          ASSERT_EQ(found.contact[0].surface, surface);
        }
        before = found.contact[0].overlap;
        surface = found.contact[0].surface;
      }
    }
  }
  EXPECT_GT(joints_seen, 20);
}

TEST(Families, CornersAreTwoContactsAndEdgesOneAtTheNearestPoint)
{
  int corners = 0, edges = 0;
  for (const Family& family : liner_families()) {
    SCOPED_TRACE(family.name);
    const ContactFinder finder(family.profile, radius);
    for (const Joint& joint : joints(family.profile)) {
      if (joint.turn == 0.0) continue;
      // The unit vector into the cavity, half way between the normals.
      const Point mean = joint.before + joint.after;
      const auto inward = (1.0 / length(mean)) * Point{-mean.z, mean.x};
      const Point into = nearest(family.profile, joint.at + 0.3 * radius * inward).distance > 0.0
                             ? inward
                             : -1.0 * inward;
      if (joint.corner) {
        ++corners;
        const double away = 0.95 * radius;  // from both sides
        const Contacts found =
            finder.contacts(joint.at + (away / std::cos(0.5 * joint.turn)) * into, radius);
        ASSERT_EQ(found.count, 2);
        for (int c = 0; c < 2; ++c)
          EXPECT_NEAR(found.contact[c].overlap, radius - away, 1e-4 * radius);
      } else if (joint.turn < 0.0) {
        ++edges;
        const Contacts found = finder.contacts(joint.at + 0.9 * radius * into, radius);
        ASSERT_EQ(found.count, 1);
        EXPECT_NEAR(found.contact[0].overlap, 0.1 * radius, 1e-14);
        EXPECT_LT(length(found.contact[0].normal - into), 1e-12);
      }
    }
  }
  EXPECT_GT(corners, 20);
  EXPECT_GT(edges, 10);
}

struct Flight {
  double energy, largest_overlap;
};

/// The energy of a ball after a flight by velocity Verlet: without spin and weight, against an
/// elastic liner, of stiffness and mass 1.
Flight fly(const ContactFinder& finder, Point position, Point velocity, double dt, int steps)
{
  Flight flight{};
  double stored = 0.0;
  const auto force_at = [&](Point p) {
    Point force{0.0, 0.0};
    stored = 0.0;
    const Contacts found = finder.contacts(p, radius);
    for (int c = 0; c < found.count; ++c) {
      const double overlap = found.contact[c].overlap;
      force = force + hertz(overlap) * found.contact[c].normal;
      stored += 0.4 * overlap * hertz(overlap);
      flight.largest_overlap = std::max(flight.largest_overlap, overlap);
    }
    return force;
  };
  Point force = force_at(position);
  for (int i = 0; i < steps; ++i) {
    velocity = velocity + 0.5 * dt * force;
    position = position + dt * velocity;
    force = force_at(position);
    velocity = velocity + 0.5 * dt * force;
  }
  flight.energy = 0.5 * inner(velocity, velocity) + stored;
  return flight;
}

TEST(Families, ABallThrownAtAnyEdgeOrJointKeepsItsEnergy)
{
  // Hertz: the overlap d of an impact at speed v is (5/4 m v^2 / k)^(2/5), its time 2.94 d / v.
  const double depth = 0.03 * radius, speed = std::sqrt(0.8 * std::pow(depth, 2.5));
  const double time = 2.94 * depth / speed, kinetic = 0.5 * speed * speed;
  for (const Family& family : liner_families()) {
    SCOPED_TRACE(family.name);
    const ContactFinder finder(family.profile, radius);
    RandomTouch random(family.profile);
    int hit = 0;
    for (const Joint& joint : joints(family.profile))
      for (int i = 0; i < 100; ++i) {
        // From a random direction in the cavity to a point near the joint.
        const double aim = random.uniform(-pi, pi);
        const Point to{-std::cos(aim), -std::sin(aim)};
        const Point target = joint.at + random.uniform(-0.2, 0.2) * radius * joint.after;
        const Point from = target + (-1.3 * radius) * to;
        if (nearest(family.profile, from).distance < 1.01 * radius) continue;
        for (const int parts : {100, 400}) {  // steps of an impact
          const Flight flight = fly(finder, from, speed * to, time / parts, 4 * parts);
          // The error of Verlet's method is of second order in the step, wherever the ball hits.
          ASSERT_NEAR(flight.energy / kinetic, 1.0, 2.0 / (parts * parts));
          hit += flight.largest_overlap > 0.0;
        }
      }
    EXPECT_GT(hit, 20);
  }
}

}  // namespace
