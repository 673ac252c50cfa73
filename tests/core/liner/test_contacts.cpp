#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/liner/contacts.h"
#include "core/liner/end_walls.h"
#include "core/liner/nearest.h"
#include "core/liner/paper_liners.h"

namespace {

using namespace millscale::liner;
using millscale::pi;
namespace test = millscale::test;

const Lifters paper_mill{Widths{3.9, 3.61, 0.25, 0.635, 25, 0.0}};
constexpr double ball_radius = 0.02;

Point at(double radius, double psi)
{
  return {-radius * std::sin(psi), -radius * std::cos(psi)};
}

Contacts contacts(const Profile& profile, Point p, double radius)
{
  return ContactFinder(profile, radius).contacts(p, radius);
}

double deepest(const Contacts& found)
{
  double overlap = -1.0;
  for (int t = 0; t < found.count; ++t) overlap = std::max(overlap, found.contact[t].overlap);
  return overlap;
}

TEST(Contacts, DeepestIsTheNearestPointOfTheLiner)
{
  std::mt19937 random(4);
  std::uniform_real_distribution<double> psi(-pi, pi), radius(3.57, 3.9);
  int touching = 0;
  for (int i = 0; i < 100'000; ++i) {
    const Point p = at(radius(random), psi(random));
    const Nearest exact = nearest(paper_mill, p);
    if (exact.distance < 0.0) continue;  // a centre in the wall is no ball of this mill
    const Contacts found = contacts(paper_mill, p, ball_radius);
    if (exact.distance >= ball_radius) {
      EXPECT_EQ(found.count, 0);
      continue;
    }
    ++touching;
    ASSERT_GT(found.count, 0);
    EXPECT_NEAR(deepest(found), ball_radius - exact.distance, 1e-10 * ball_radius);
  }
  EXPECT_GT(touching, 5'000);
}

TEST(Contacts, ClearWayIsNoLongerThanTheDistanceToTheLiner)
{
  // Off the foot of a face the clear distance may be shorter; over all positions it is mostly
  // exact.
  std::mt19937 random(8);
  std::uniform_real_distribution<double> psi(-pi, pi), radius(3.4, 3.9);
  const ContactFinder finder(paper_mill, 0.5);
  int exactly = 0, apart = 0;
  for (int i = 0; i < 100'000; ++i) {
    const Point p = at(radius(random), psi(random));
    const double distance = nearest(paper_mill, p).distance;
    LastSearch look;
    if (finder.contacts(p, ball_radius, look).count > 0) {
      EXPECT_EQ(look.clear, 0.0);
      continue;
    }
    if (distance < 0.0) continue;  // a centre in the wall is no ball of this mill
    ++apart;
    EXPECT_GE(look.clear, 0.0);
    EXPECT_LE(look.clear, distance - ball_radius + 1e-12);
    if (look.clear > distance - ball_radius - 1e-9) ++exactly;
  }
  EXPECT_GT(apart, 50'000);
  EXPECT_GT(exactly, apart / 3);
}

TEST(Contacts, AreTheSameWithWhateverGrooveBefore)
{
  std::mt19937 random(9);
  std::uniform_real_distribution<double> psi(-pi, pi), radius(3.57, 3.9);
  const ContactFinder finder(paper_mill, ball_radius);
  LastSearch look;  // positions are random, so the groove mostly changes
  for (int i = 0; i < 20'000; ++i) {
    const Point p = at(radius(random), psi(random));
    const Contacts fresh = finder.contacts(p, ball_radius),
                   again = finder.contacts(p, ball_radius, look);
    ASSERT_EQ(fresh.count, again.count);
    for (int t = 0; t < fresh.count; ++t) {
      EXPECT_EQ(fresh.contact[t].overlap, again.contact[t].overlap);
      EXPECT_EQ(fresh.contact[t].sector, again.contact[t].sector);
      EXPECT_EQ(fresh.contact[t].face, again.contact[t].face);
    }
  }
}

TEST(Contacts, NormalPointsFromTheNearestPointToTheCentre)
{
  std::mt19937 random(5);
  std::uniform_real_distribution<double> psi(-pi, pi), radius(3.57, 3.895);
  for (int i = 0; i < 20'000; ++i) {
    const Point p = at(radius(random), psi(random));
    const Nearest exact = nearest(paper_mill, p);
    const Contacts found = contacts(paper_mill, p, ball_radius);
    if (found.count != 1 || exact.distance < 1e-4) continue;
    EXPECT_NEAR(found.contact[0].normal.x, exact.normal.x, 1e-9);
    EXPECT_NEAR(found.contact[0].normal.z, exact.normal.z, 1e-9);
  }
}

TEST(Contacts, ConcaveCornerHasTwo)
{
  // Just inside the corner of groove and leading face, within a radius of both.
  const double psi = -paper_mill.groove_half_angle() + 0.7 * ball_radius / 3.9;
  const Contacts found = contacts(paper_mill, at(3.9 - 0.7 * ball_radius, psi), ball_radius);
  ASSERT_EQ(found.count, 2);
  EXPECT_EQ(found.contact[0].face, Face::groove);
  EXPECT_EQ(found.contact[1].face, Face::leading);
}

TEST(Contacts, ConvexEdgeHasOneAtTheExactCorner)
{
  const Local corner = paper_mill.corner();
  const Frame frame(paper_mill.lifter_angle(0));
  const double direction = -0.8;  // between the normals of top and face
  const double distance = 0.9 * ball_radius;
  const Point p = frame.point({corner.radial + distance * std::sin(direction),
                               corner.tangential + distance * std::cos(direction)});
  const Contacts found = contacts(paper_mill, p, ball_radius);
  ASSERT_EQ(found.count, 1);
  EXPECT_NEAR(found.contact[0].overlap, ball_radius - distance, 1e-14);
}

TEST(Contacts, NormalTurnsWithoutAJumpAroundALifter)
{
  // Along the path of a centre at a distance of 0.9 radii from face, edge and top.
  const Local corner = paper_mill.corner();
  const Frame frame(paper_mill.lifter_angle(0));
  const double distance = 0.9 * ball_radius, face = paper_mill.face_angle();
  double last = -1.0;
  for (double direction = -0.5 * pi; direction <= -face; direction += 1e-3) {
    const Point p = frame.point({corner.radial + distance * std::sin(direction),
                                 corner.tangential + distance * std::cos(direction)});
    const double overlap = deepest(contacts(paper_mill, p, ball_radius));
    if (last >= 0.0) {
      EXPECT_NEAR(overlap, last, 1e-12);
    }
    last = overlap;
  }
  EXPECT_GT(last, 0.0);
}

TEST(Contacts, RepeatFromSectorToSectorAndMirror)
{
  std::mt19937 random(6);
  std::uniform_real_distribution<double> psi(-0.5, 0.5), radius(3.58, 3.895);
  for (int i = 0; i < 2'000; ++i) {
    const double angle = psi(random) * paper_mill.pitch(), r = radius(random);
    const double here = deepest(contacts(paper_mill, at(r, angle), ball_radius));
    const double there =
        deepest(contacts(paper_mill, at(r, angle + 7 * paper_mill.pitch()), ball_radius));
    const double mirrored = deepest(contacts(paper_mill, at(r, -angle), ball_radius));
    EXPECT_NEAR(here, there, 1e-12);
    EXPECT_NEAR(here, mirrored, 1e-12);
  }
}

TEST(Contacts, OfAPlainDrumIsTheCircle)
{
  const Lifters drum{Widths{1.5, 0.0, 0.0, 0.0, 0, 0.0}};
  const Contacts found = contacts(drum, at(1.49, 2.0), ball_radius);
  ASSERT_EQ(found.count, 1);
  EXPECT_NEAR(found.contact[0].overlap, 0.01, 1e-15);
  EXPECT_EQ(contacts(drum, at(1.47, 2.0), ball_radius).count, 0);
}

TEST(Contacts, OfAnyNumberOfLiftersAreTheNearestPoint)
{
  std::mt19937 random(7);
  for (const Lifters& liner : test::various_liners()) {
    const double radius = 0.02 * liner.radius();
    const double inner = liner.lifters() > 0 ? liner.lifter_top_radius() : liner.radius();
    std::uniform_real_distribution<double> psi(-pi, pi), from(inner - radius, liner.radius());
    const ContactFinder finder(liner, radius);
    int touching = 0;
    for (int i = 0; i < 20'000; ++i) {
      const Point p = at(from(random), psi(random));
      const Nearest exact = nearest(liner, p);
      if (exact.distance < 0.0) continue;
      const Contacts found = finder.contacts(p, radius);
      EXPECT_LE(found.count, 2);
      touching += found.count > 0;
      EXPECT_NEAR(std::max(deepest(found), 0.0), std::max(radius - exact.distance, 0.0),
                  1e-10 * radius);
    }
    EXPECT_GT(touching, 1'000);
  }
}

TEST(ContactsOfChords, AreOneOverAJointAndGoOnFromChordToChord)
{
  const Profile chords = wall_profile(paper_mill, 1e-3);
  ASSERT_GT(chords.pieces().size(), 5u);
  double widest = 0.0;
  for (const Piece& piece : chords.pieces())
    if (piece.face == Face::groove) widest = std::max(widest, piece.length);
  const ContactFinder finder(chords, ball_radius);
  // Along the groove at a constant distance from the axis, over all its joints.
  const double distance = 3.9 - 0.8 * ball_radius, last = 0.9 * paper_mill.groove_half_angle();
  const double step = 1e-4;
  double before = -1.0;
  for (double psi = -last; psi <= last; psi += step) {
    const Contacts found = finder.contacts(at(distance, psi), ball_radius);
    ASSERT_EQ(found.count, 1);
    EXPECT_EQ(found.contact[0].face, Face::groove);
    const double overlap = found.contact[0].overlap;
    // The distance to a chord changes by the sine of at most half its angle.
    if (before >= 0.0) {
      EXPECT_LE(std::abs(overlap - before), distance * step * 0.5 * widest / 3.9);
    }
    before = overlap;
  }
}

TEST(ContactsOfChords, ComeToThoseOfTheArcAsTheErrorOfTheChord)
{
  const Point p = at(3.9 - 0.5 * ball_radius, 0.01);
  const double exact = deepest(contacts(paper_mill, p, ball_radius));
  for (double error : {1e-3, 1e-4, 1e-5, 1e-6})
    EXPECT_LE(std::abs(deepest(contacts(wall_profile(paper_mill, error), p, ball_radius)) - exact),
              error);
}

TEST(ContactsOfChords, AreFoundWhereAChordIsNearerToTheAxisThanTheLiftersTops)
{
  const Lifters low(Slopes{1.0, 0.95, 0.1, 0.2, 3, 0.0});
  const Profile chord = wall_profile(low, 0.6);
  ASSERT_EQ(chord.pieces().size(), 4u);
  const double inner = std::cos(low.groove_half_angle());
  ASSERT_LT(inner, low.lifter_top_radius() - 0.02);
  EXPECT_DOUBLE_EQ(chord.clear_radius(), inner);
  const Contacts found = contacts(chord, at(inner - 0.01, 0.0), 0.02);
  ASSERT_EQ(found.count, 1);
  EXPECT_NEAR(found.contact[0].overlap, 0.01, 1e-15);
}

TEST(ContactsOfChords, RefuseFoldsLikeCorners)
{
  const Lifters drum{Widths{1.0, 0.0, 0.0, 0.0, 0, 0.0}};
  EXPECT_NO_THROW(wall_profile(drum, 0.10));
  EXPECT_THROW(wall_profile(drum, 0.14), std::invalid_argument);
  EXPECT_THROW(wall_profile(drum, 0.0), std::invalid_argument);
}

TEST(EndWalls, AreHalfSpaces)
{
  const EndWalls ends{-0.1, 0.3};
  EXPECT_NO_THROW(ends.check());
  EXPECT_NEAR(ends.lower_overlap(-0.085, 0.02), 0.005, 1e-15);
  EXPECT_NEAR(ends.upper_overlap(0.285, 0.02), 0.005, 1e-15);
  EXPECT_NEAR(ends.upper_overlap(0.31, 0.02), 0.03, 1e-15);
  EXPECT_LT(ends.lower_overlap(0.0, 0.02), 0.0);
  EXPECT_THROW((EndWalls{0.3, 0.3}.check()), std::invalid_argument);
  EXPECT_THROW((EndWalls{0.3, std::nan("")}.check()), std::invalid_argument);
}

}  // namespace
