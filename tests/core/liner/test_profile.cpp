#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/liner/area.h"
#include "core/liner/contacts.h"
#include "core/liner/fillets.h"
#include "core/liner/groove_box.h"
#include "core/liner/liner_families.h"
#include "core/liner/nearest.h"
#include "core/liner/offset.h"
#include "core/liner/paper_liners.h"
#include "core/liner/polygon.h"

namespace {

using namespace millscale::liner;
using millscale::pi;
using namespace millscale::test;

/// An asymmetric sector that no manufacturer makes: a steep and a flat face, a rounded crest, a
/// rounded edge and two grooves. One groove is an arc that is not centred on the axis.
Profile made_up(int sectors = 9, double phase = 0.4)
{
  const double half = pi / sectors;
  const auto at = [half](double radius, double share) {
    return Local{radius * std::cos(share * half), radius * std::sin(share * half)};
  };
  return {{{at(1.00, -1.0), 0.4, Face::groove},         // arc, centre in the cavity
           {at(1.01, -0.5), 0.0, Face::trailing},       // concave corner, steep
           {at(0.86, -0.42), -0.17 * half, Face::top},  // crest, arc with its centre in the wall
           {at(0.87, -0.2), 0.0, Face::top},            // flat
           {at(0.88, 0.0), 0.0, Face::leading},         // convex edge
           {at(0.99, 0.35), 0.0, Face::groove}},        // concave corner
          sectors,
          phase};
}

/// Crests and valleys of arcs with smooth joints, without corners.
Profile smooth_wave(int sectors)
{
  // Two circles of the radius r touch on the sector's border and on its middle. Their centres lie
  // at 1 + r and at R - r; the angle between them is half a pitch.
  const double half = pi / sectors, valley = 0.9;
  // |valley - crest|^2 = (2 r)^2 with the crest's centre at distance q.
  const double q = 1.02,
               r = 0.5 * std::sqrt(valley * valley + q * q - 2.0 * valley * q * std::cos(half));
  const Local low{valley, 0.0};
  const Local before{q * std::cos(half), -q * std::sin(half)},
      after{q * std::cos(half), q * std::sin(half)};
  return {{{0.5 * (low + before), r, Face::groove}, {0.5 * (low + after), -r, Face::groove}},
          sectors,
          0.1};
}

/// Profiles that are not trapezoids, a trapezoidal profile, and a profile of many pieces.
std::vector<Profile> profiles()
{
  return {made_up(),
          made_up(3, -2.0),
          made_up(16, 0.0),
          smooth_wave(12),
          smooth_wave(24),
          trapezoid_mill(),
          wall_profile(smooth_wave(12), 1e-4)};
}

/// Points of the whole liner, `per_piece` on each piece.
std::vector<Point> samples(const Profile& profile, int per_piece)
{
  std::vector<Point> result;
  for (int k = 0; k < profile.sectors(); ++k) {
    const Frame frame(profile.sector_angle(k));
    for (const Piece& piece : profile.pieces())
      for (int i = 0; i < per_piece; ++i) {
        const double share = static_cast<double>(i) / per_piece;
        if (!piece.is_arc()) {
          result.push_back(frame.point(piece.begin + share * (piece.end - piece.begin)));
          continue;
        }
        // Angle from the ends of the arc, not from its middle.
        const Local from = piece.begin - piece.centre, to = piece.end - piece.centre;
        const double sweep = std::atan2(cross(from, to), dot(from, to));
        result.push_back(frame.point(piece.centre + turned(from, share * sweep)));
      }
  }
  return result;
}

std::vector<Point> random_points(double radius, int count)
{
  std::mt19937 random(11);
  std::uniform_real_distribution<double> coordinate(-1.1 * radius, 1.1 * radius);
  std::vector<Point> points;
  for (int i = 0; i < count; ++i) {
    const double x = coordinate(random);
    points.push_back({x, coordinate(random)});
  }
  return points;
}

/// Return whether a point is inside, by counting crossings of a ray with the sampled outline.
bool within(const std::vector<Point>& outline, Point q)
{
  bool result = false;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Point a = outline[i], b = outline[(i + 1) % outline.size()];
    if ((a.z > q.z) != (b.z > q.z) && q.x < a.x + (q.z - a.z) / (b.z - a.z) * (b.x - a.x))
      result = !result;
  }
  return result;
}

/// Text of the error, empty without one.
template <class Make>
std::string error_of(const Make& make)
{
  try {
    make();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(Profile, NearestPointIsThatOfManySamples)
{
  for (const Profile& profile : profiles()) {
    const std::vector<Point> outline = samples(profile, 1000);
    double spacing = 0.0;
    for (const Piece& piece : profile.pieces()) spacing = std::max(spacing, piece.length / 1000);
    for (const Point q : random_points(profile.radius(), 300)) {
      double best = INFINITY;
      for (const Point s : outline) best = std::min(best, length(q - s));
      const Nearest found = nearest(profile, q);
      // The nearest sample is at most half a spacing along the liner from the nearest point.
      EXPECT_LE(std::abs(found.distance), best + 1e-12);
      EXPECT_GE(std::abs(found.distance), best - 0.5 * spacing);
      if (best > spacing) {
        EXPECT_EQ(found.distance > 0.0, within(outline, q)) << q.x << ' ' << q.z;
      }
      EXPECT_NEAR(found.point.x + found.distance * found.normal.x, q.x, 1e-13);
      EXPECT_NEAR(found.point.z + found.distance * found.normal.z, q.z, 1e-13);
      EXPECT_EQ(inside(profile, q), found.distance >= 0.0);
    }
  }
}

TEST(Profile, AreaIsTheLimitOfThePolygons)
{
  for (const Profile& profile : profiles()) {
    const double exact = area(profile);
    for (const double chord_error : {1e-4, 1e-6}) {
      const Polygon p = polygon(profile, chord_error);
      double twice = 0.0, perimeter = 0.0;
      for (std::size_t i = 0; i < p.nodes.size(); ++i) {
        const Point a = p.nodes[i], b = p.nodes[(i + 1) % p.nodes.size()];
        twice += a.z * b.x - a.x * b.z;
        perimeter += length(b - a);
      }
      // A chord cuts off two thirds of chord times sagitta.
      EXPECT_NEAR(0.5 * twice, exact, 2.0 / 3.0 * perimeter * chord_error + 1e-12);
    }
  }
}

TEST(Profile, RadiiAreTheLeastAndTheLargestOfManySamples)
{
  for (const Profile& profile : profiles()) {
    double least = INFINITY, largest = 0.0;
    for (const Point s : samples(profile, 1000)) {
      least = std::min(least, length(s));
      largest = std::max(largest, length(s));
    }
    EXPECT_LE(profile.clear_radius(), least + 1e-12);
    EXPECT_NEAR(profile.clear_radius(), least, 1e-6);
    EXPECT_GE(profile.radius(), largest - 1e-12);
    EXPECT_NEAR(profile.radius(), largest, 1e-6);
  }
}

TEST(Profile, ContactsLieOnTheLinerEachOnAnotherSurfaceTheDeepestAtTheNearestPoint)
{
  for (const Profile& profile : profiles()) {
    const double radius = 0.02 * profile.radius();
    const ContactFinder finder(profile, radius);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> psi(-pi, pi),
        distance(profile.clear_radius() - radius, profile.radius());
    int touching = 0, twice = 0;
    for (int i = 0; i < 20'000; ++i) {
      const Point p = Frame(psi(random)).point({distance(random), 0.0});
      const Nearest exact = nearest(profile, p);
      if (exact.distance < 0.0) continue;
      LastSearch last;
      const Contacts found = finder.contacts(p, radius, last);
      ASSERT_EQ(found.count > 0, exact.distance < radius);
      EXPECT_LE(last.clear, std::max(0.0, exact.distance - radius) + 1e-12);
      if (found.count == 0) continue;
      ++touching;
      twice += found.count > 1;
      double deepest = 0.0;
      for (int c = 0; c < found.count; ++c) {
        const Contact& contact = found.contact[c];
        deepest = std::max(deepest, contact.overlap);
        // The contact's point lies on the liner, at the distance that leaves the overlap.
        const double away = radius - contact.overlap;
        const Point on{p.x - away * contact.normal.x, p.z - away * contact.normal.z};
        EXPECT_NEAR(nearest(profile, on).distance, 0.0, 1e-12);
        EXPECT_NEAR(length(contact.normal), 1.0, 1e-12);
        for (int d = 0; d < c; ++d) EXPECT_NE(contact.surface, found.contact[d].surface);
      }
      EXPECT_NEAR(deepest, radius - exact.distance, 1e-12);
    }
    EXPECT_GT(touching, 1'000);
    if (profile.surfaces_per_sector() > 0) {
      EXPECT_GT(twice, 10);
    } else {
      EXPECT_EQ(twice, 0);
    }
  }
}

TEST(Profile, WithinTheClearWayABallTouchesNoPatchButThoseFound)
{
  int tracked[3] = {}, searched[3] = {}, edges = 0, touches = 0, ends = 0;
  for (const Profile& profile : profiles()) {
    const double radius = 0.02 * profile.radius();
    for (const double usual : {radius, 0.4 * radius, 40.0 * radius}) {  // how far a search reaches
      const ContactFinder finder(profile, usual);
      std::mt19937 random(5);
      std::uniform_real_distribution<double> psi(-pi, pi), share(0.0, 1.0),
          distance(profile.clear_radius() - radius, profile.radius());
      for (int i = 0; i < 40'000; ++i) {
        const Point p = Frame(psi(random)).point({distance(random), 0.0});
        if (nearest(profile, p).distance < 0.0) continue;
        int sector = -1;
        const Found found = finder.find(p, radius, sector);
        if (found.count == 0 || found.count > 2) continue;
        ++searched[found.count];
        if (found.clear == 0.0) continue;
        ++tracked[found.count];
        const double way = found.clear * std::sqrt(share(random)), direction = psi(random);
        const Point there{p.x + way * std::cos(direction), p.z + way * std::sin(direction)};
        if (nearest(profile, there).distance < 0.0) continue;
        int fresh = -1;
        const Found now = finder.find(there, radius, fresh);
        const auto find = [&](int patch) {
          return std::count(now.patch.begin(), now.patch.begin() + now.count, patch);
        };
        int expected = 0;
        bool unsure = false;  // rounding decides
        for (int k = 0; k < found.count; ++k) {
          const int patch = found.patch[k];
          const double gap =
              before(finder.patches()[patch], there.x, there.z, 0.0).distance - radius;
          unsure = unsure || std::abs(gap) < 1e-12;
          expected += gap < 0.0;
          if (!unsure) {
            ASSERT_EQ(find(patch), gap < 0.0 ? 1 : 0);
          }
          edges += patch % 2;
          (gap < 0.0 ? touches : ends) += 1;
        }
        if (!unsure) {
          ASSERT_EQ(now.count, expected);
        }
      }
    }
  }
  EXPECT_GT(tracked[1], searched[1] / 2);  // on short chords, a next chord is always near
  EXPECT_GT(tracked[2], searched[2] / 2);
  EXPECT_GT(edges, 2'000);
  EXPECT_GT(touches, 10'000);
  EXPECT_GT(ends, 5'000);
}

TEST(Profile, OverlapChangesNoFasterThanTheCentreMovesOverJointsAndEdges)
{
  // Around each liner at a constant distance: no jump at any joint, edge or border of sectors.
  for (const Profile& profile : profiles()) {
    const double radius = 0.02 * profile.radius(), step = 1e-4 * radius;
    const ContactFinder finder(profile, radius);
    for (const Piece& piece : profile.pieces()) {
      const Local normal = left_of(piece.tangent_begin);
      double before = -1.0;
      for (int i = -2'000; i <= 2'000; ++i) {
        const Local at = piece.begin + 0.5 * radius * normal + i * step * piece.tangent_begin;
        const Point p = Frame(profile.sector_angle(0)).point(at);
        if (nearest(profile, p).distance < 0.0) {
          before = -1.0;
          continue;
        }
        const Contacts found = finder.contacts(p, radius);
        double deepest = 0.0;
        for (int c = 0; c < found.count; ++c) deepest = std::max(deepest, found.contact[c].overlap);
        if (before >= 0.0) {
          ASSERT_LE(std::abs(deepest - before), step * (1.0 + 1e-6));
        }
        before = deepest;
      }
    }
  }
}

TEST(Profile, ConcaveCornersPartSurfacesSmoothJointsAndConvexEdgesDoNot)
{
  EXPECT_EQ(made_up().surfaces_per_sector(), 3);
  EXPECT_EQ(trapezoid_mill().surfaces_per_sector(), 2);
  EXPECT_EQ(smooth_wave(12).surfaces_per_sector(), 0);
  EXPECT_EQ(wall_profile(smooth_wave(12), 1e-3).surfaces_per_sector(), 0);
  EXPECT_EQ(wall_profile(made_up(), 1e-4).surfaces_per_sector(), 3);
  const Lifters drum{Widths{1.0, 0.0, 0.0, 0.0, 0, 0.0}};
  EXPECT_EQ(drum.surfaces_per_sector(), 0);
  EXPECT_EQ(wall_profile(drum, 1e-3).surfaces_per_sector(), 0);
}

TEST(Profile, OffsetMovesEveryPieceByTheDistance)
{
  for (const Profile& profile : profiles())
    for (const double distance : {0.01, -0.01}) {
      const Profile moved = offset(profile, distance);
      for (std::size_t i = 0; i < moved.pieces().size(); ++i) {
        const Piece &piece = moved.pieces()[i], &was = profile.pieces()[i];
        for (const double share : {0.1, 0.5, 0.9}) {
          const double sweep = piece.half_angle * (2.0 * share - 1.0);
          const Local at = piece.is_arc() ? piece.centre + std::abs(piece.arc_radius) *
                                                               turned(piece.middle, sweep)
                                          : piece.begin + share * (piece.end - piece.begin);
          const double away = was.is_arc()
                                  ? std::abs(length(at - was.centre) - std::abs(was.arc_radius))
                                  : std::abs(cross(was.tangent_begin, at - was.begin));
          EXPECT_NEAR(away, std::abs(distance), 1e-9);
        }
      }
      const Profile back = offset(moved, -distance);
      for (std::size_t i = 0; i < back.nodes().size(); ++i)
        EXPECT_LT(length(back.nodes()[i].point - profile.nodes()[i].point), 1e-9);
    }
}

TEST(Profile, OffsetOfLiftersIsThatOfTheirDimensions)
{
  for (const Lifters& liner : various_liners()) {
    const Lifters by_dimensions = offset_scaled(liner, 1.7, 0.01);
    const Profile by_pieces = offset_scaled(static_cast<const Profile&>(liner), 1.7, 0.01);
    ASSERT_EQ(by_pieces.nodes().size(), by_dimensions.nodes().size());
    for (std::size_t i = 0; i < by_pieces.nodes().size(); ++i)
      EXPECT_LT(length(by_pieces.nodes()[i].point - by_dimensions.nodes()[i].point), 1e-13);
  }
}

TEST(Profile, OffsetRefusesToLoseAFace)
{
  EXPECT_THROW(offset(made_up(), 0.5), std::invalid_argument);
  const Profile lifters = static_cast<Profile>(trapezoid_mill());
  EXPECT_NE(error_of([&] { offset(lifters, -0.2); }).find("piece 0 of the profile vanishes"),
            std::string::npos);
  // Two walls of a groove that come closer than nothing.
  EXPECT_NE(error_of([&] { offset(lifters, 0.45); }), "");
}

TEST(Profile, OffsetLeavesOutWhatVanishes)
{
  // Into the wall: the crest's arc of made_up, with its centre there.
  const Profile crest = made_up();
  const Profile moved = offset(crest, -0.07);
  EXPECT_EQ(moved.pieces().size(), crest.pieces().size() - 1);
  // Into the cavity: the fillet at the foot of a rib, of 0.01 m, and its chords.
  for (const Family& family : liner_families()) {
    if (family.name != "rib") continue;
    const std::size_t pieces = family.profile.pieces().size();
    EXPECT_EQ(offset(family.profile, 0.009).pieces().size(), pieces);
    EXPECT_EQ(offset(family.profile, 0.011).pieces().size(), pieces - 1);
    const Profile chords = with_chords(family.profile, 1e-5);
    EXPECT_LT(offset(chords, 0.011).pieces().size(), chords.pieces().size() - 5);
    // The outline without the fillet moves to the same place.
    const Profile sharp = with_lifters({{0.0, 0.08, 0.03, 0.05, 0.05, 0.006, 0.0}}, 1.0, 18);
    const Profile one = offset(family.profile, 0.011), other = offset(sharp, 0.011);
    ASSERT_EQ(one.nodes().size(), other.nodes().size());
    for (std::size_t i = 0; i < one.nodes().size(); ++i)
      EXPECT_LT(length(one.nodes()[i].point - other.nodes()[i].point), 1e-12);
  }
}

TEST(Profile, OffsetIsTheDistanceFromTheOutline)
{
  // True offset: every point lies at the distance from the outline, but near mitred edges.
  for (const Family& family : liner_families()) {
    SCOPED_TRACE(family.name);
    for (const double distance : {0.004, 0.012, 0.02}) {
      const Profile moved = offset(family.profile, distance);
      int on = 0, all = 0;
      for (const Point p : samples(moved, 50)) {
        const Nearest found = nearest(family.profile, p);
        EXPECT_GT(found.distance, distance - 1e-9);
        on += found.distance < distance + 1e-9;
        ++all;
      }
      EXPECT_GT(on, 0.6 * all);
    }
  }
}

TEST(Profile, ThePathOfTheCentreScalesOnLinesAndArcs)
{
  const double ball = 0.012, S = 1.6;
  int centres = 0;
  for (const Family& family : liner_families()) {
    SCOPED_TRACE(family.name);
    const Profile model = offset_scaled(family.profile, S, ball);
    // Where the centre of a ball of the same size is on a line, or on an arc that is wide enough.
    std::mt19937 random(2);
    std::uniform_real_distribution<double> share(0.4, 0.6);
    for (int k = 0; k < model.sectors(); ++k)
      for (const Piece& piece : model.pieces()) {
        const double s = share(random), sweep = piece.half_angle * (2.0 * s - 1.0);
        const Local on = piece.is_arc()
                             ? piece.centre + piece.arc_radius * turned(piece.middle, sweep)
                             : piece.begin + s * (piece.end - piece.begin);
        const Local normal = detail::normal_at(piece, on);
        const Point centre = Frame(model.sector_angle(k)).point(on + ball * normal);
        if (nearest(model, centre).distance < ball - 1e-9) continue;  // beside another piece
        EXPECT_NEAR(nearest(family.profile, {S * centre.x, S * centre.z}).distance, ball, 1e-9);
        ++centres;
      }
  }
  EXPECT_GT(centres, 500);
}

TEST(Profile, NarrowestWidthOfLiftersIsThatOfFootOrMouth)
{
  for (const Lifters& liner : various_liners()) {
    if (liner.lifters() == 0) continue;
    const double half_pitch = 0.5 * liner.pitch();
    const double mouth = 2.0 * (liner.corner().radial * std::sin(half_pitch) -
                                liner.corner().tangential * std::cos(half_pitch));
    EXPECT_NEAR(narrowest_width(liner), std::min(mouth, liner.groove_width()), 1e-14);
  }
  EXPECT_DOUBLE_EQ(narrowest_width(Lifters(Widths{2.0, 0.0, 0.0, 0.0, 0, 0.0})), 4.0);
}

Local polar_point(double r, double angle)
{
  return {r * std::cos(angle), r * std::sin(angle)};
}

TEST(Profile, RefusesAnOutlineThatCrossesItselfWithThePlace)
{
  const auto profile = [](std::vector<Local> points, int sectors) {
    std::vector<Node> nodes;
    for (const Local p : points) nodes.push_back({p});
    return error_of([&] { Profile(nodes, sectors, 0.0); });
  };
  // A loop within a sector: out, back across the way, and on.
  const std::string loop =
      profile({{1.0, -0.1}, {0.9, 0.06}, {0.9, -0.06}, {1.0, 0.1}, {1.0, 0.15}}, 12);
  EXPECT_NE(loop.find("pieces 0 and 2 cross or touch at (0.9"), std::string::npos) << loop;
  EXPECT_NE(loop.find("must not cross itself"), std::string::npos);
  // A face that leans over the sector's border through the lifter of the next sector.
  const std::string next = profile({polar_point(1.0, -0.2), polar_point(0.8, -0.2),
                                    polar_point(0.9, 0.35), polar_point(1.0, 0.1)},
                                   12);
  EXPECT_NE(next.find(" of the next sector cross"), std::string::npos) << next;
  // A spike.
  const std::string spike =
      profile({{1.0, -0.1}, {0.9, 0.0}, {1.0, 0.0}, {0.8, 0.0}, {1.0, 0.1}}, 12);
  EXPECT_NE(spike.find("piece 2 folds back"), std::string::npos) << spike;
  // The last piece all around crosses a piece near the first.
  std::vector<Local> ring;
  for (int i = 0; i < 40; ++i) ring.push_back(polar_point(1.0, 2.0 * pi * i / 40));
  EXPECT_EQ(profile(ring, 1), "");
  ring.back() = polar_point(1.05, 2.0 * pi * 3.5 / 40);
  EXPECT_NE(profile(ring, 1), "");
  for (const Profile& each : profiles())
    EXPECT_EQ(error_of([&] { Profile(each.nodes(), each.sectors(), each.phase()); }), "");
}

TEST(Profile, RefusesAnOutlineInsideOut)
{
  for (const int sectors : {1, 12}) {
    std::vector<Node> nodes;
    for (int i = 0; i < 20; ++i)
      nodes.push_back({polar_point(1.0 - 0.02 * (i % 3), -2.0 * pi / sectors * i / 20)});
    const std::string error = error_of([&] { Profile(nodes, sectors, 0.0); });
    EXPECT_NE(error.find("inside-out"), std::string::npos) << error;
  }
}

TEST(Profile, ThousandsOfPiecesAllAroundAreChecked)
{
  std::vector<Node> nodes;
  const int count = 5'000;
  for (int i = 0; i < count; ++i)
    nodes.push_back({polar_point(1.0 - 0.05 * (i / 50 % 2), 2.0 * pi * i / count)});
  const Profile ring(nodes, 1, 0.0);
  EXPECT_EQ(ring.surfaces_per_sector(), count / 50);
  nodes[2'000].point = polar_point(0.9, 2.0 * pi * 1'990.5 / count);
  EXPECT_NE(error_of([&] { Profile(nodes, 1, 0.0); }), "");
}

TEST(Profile, ShallowFoldsAreOneSurfaceAndCornersTwo)
{
  const auto folds = [](double fold) {  // of a polygon, each side with a node in its middle
    const int sides = static_cast<int>(std::lround(2.0 * pi / fold));
    const Local middle{std::cos(pi / sides), 0.0};
    return Profile({{polar_point(1.0, -pi / sides)}, {middle}}, sides, 0.0);
  };
  EXPECT_EQ(folds(0.25).surfaces_per_sector(), 0);
  EXPECT_EQ(folds(0.35).surfaces_per_sector(), 1);
}

TEST(Profile, TurnsTooNarrowForTheBallAreCorners)
{
  for (const Family& family : liner_families()) {
    if (family.name != "rib") continue;  // its feet are rounded by 0.01 m
    const auto surfaces = [&](double ball) {
      return with_corners_for(family.profile, ball).surfaces_per_sector();
    };
    EXPECT_EQ(surfaces(0.009), 1);  // the sharp foot
    EXPECT_EQ(surfaces(0.011), 2);
    EXPECT_EQ(with_corners_for(wall_profile(family.profile, 1e-5), 0.011).surfaces_per_sector(), 2);
    EXPECT_EQ(with_corners_for(wall_profile(family.profile, 1e-5), 0.009).surfaces_per_sector(), 1);
    EXPECT_GT(narrowest_width(family.profile), 0.2);  // a fillet is no groove
  }
  for (const Profile& profile : profiles())
    EXPECT_EQ(with_corners_for(profile, 0.02).surfaces_per_sector(), profile.surfaces_per_sector());
}

TEST(Profile, WidthsAreMeasuredAcrossGroovesNotAcrossLiftersWithRoundedEdges)
{
  const int sectors = 8;
  const LifterShape narrow{pi / sectors, 0.06, 0.05, 0.2, 0.3};
  LifterShape round = narrow;
  round.edge_radius = 0.01;
  const double sharp = narrowest_width(with_lifters({narrow}, 1.0, sectors));
  const double rounded = narrowest_width(with_lifters({round}, 1.0, sectors));
  EXPECT_GT(sharp, 0.6);
  EXPECT_NEAR(rounded, sharp, 0.02);  // edges of radius 0.01 on both sides of the mouth
}

TEST(Profile, GroovesAreCountedFromLifterToLifter)
{
  for (const Lifters& liner : various_liners())
    for (int k = 0; k < liner.sectors(); ++k) {
      EXPECT_EQ(liner.grooves().at(liner.sector_angle(k)), k);
      EXPECT_EQ(liner.grooves().lifter_angle(k),
                liner.phase() + liner.pitch() * k - 0.5 * liner.pitch());
    }
  for (const Family& family : liner_families()) {
    if (family.name.find("hi-lo") == std::string::npos) continue;
    SCOPED_TRACE(family.name);
    const Profile& profile = family.profile;
    const Grooves& grooves = profile.grooves();
    ASSERT_EQ(grooves.count(), 24);
    for (int k = 0; k < 24; ++k) {
      const int sector = k / 2;
      const double middle = pi / 6.0 * sector + (k % 2 ? 0.05 : -0.2);
      const double angle = grooves.lifter_angle(k);
      EXPECT_NEAR(angle, middle, 0.005);  // the arc at the front of the top counts as top
      EXPECT_EQ(grooves.at(angle + 1e-9), k);
      EXPECT_EQ(grooves.at(angle - 1e-9 + 2.0 * pi), (k + 23) % 24);
      // The leading face belongs to the lifter, and the groove before it too.
      const auto number = [&](double angle, double r) {
        return nearest(profile, Frame(angle).point({r, 0.0}));
      };
      const Nearest top = number(middle, 0.8), groove = number(middle + 0.12, 0.99);
      EXPECT_EQ(top.face, Face::top);
      EXPECT_EQ(top.sector, k);
      EXPECT_EQ(groove.face, Face::groove);
      EXPECT_EQ(groove.sector, k);
    }
  }
}

TEST(Profile, ALifterOverTheSectorsBorderIsThatOfTheNextSectorIfItIsAhead)
{
  // The same outline, cut in the middle of its lifters or in its grooves.
  const Lifters cut = trapezoid_mill();
  std::vector<Node> nodes = cut.nodes();
  std::rotate(nodes.begin(), nodes.begin() + 3, nodes.end());
  nodes[0].point = turned(nodes[0].point, -cut.pitch());
  nodes[0].ahead = 0;
  const Profile moved(nodes, 25, 0.0);
  std::mt19937 random(8);
  std::uniform_real_distribution<double> psi(-pi, pi), r(3.0, 3.9);
  for (int i = 0; i < 2'000; ++i) {
    const Point p = Frame(psi(random)).point({r(random), 0.0});
    const Nearest a = nearest(cut, p), b = nearest(moved, p);
    EXPECT_EQ(a.face, b.face);
    EXPECT_EQ(a.sector, b.sector);
  }
}

TEST(Profile, GrooveBoxOfSeveralLiftersIsThatOfTheFirstGroove)
{
  for (const Family& family : liner_families()) {
    if (family.name.find("hi-lo") == std::string::npos) continue;
    const auto box = groove_box(family.profile);
    // From the leading face of lifter 0 at -0.2 rad to the trailing face of lifter 1 at 0.05 rad.
    EXPECT_LT(groove_middle(family.profile), 0.0);
    EXPECT_GT(groove_middle(family.profile), -0.15);
    for (const Point corner : box) {
      EXPECT_GT(polar_angle(corner), -0.2);
      EXPECT_LT(polar_angle(corner), 0.05);
    }
    EXPECT_LT(polar_angle(box[0]), polar_angle(box[1]));
    EXPECT_LT(polar_angle(box[3]), polar_angle(box[2]));
  }
  EXPECT_FALSE(has_groove(Lifters(Widths{2.0})));
}

TEST(Profile, RefusesPiecesThatDoNotGoOnceAroundTheAxis)
{
  const Local a{1.0, -0.1}, b{1.0, 0.1};
  EXPECT_THROW(Profile({}, 5, 0.0), std::invalid_argument);
  EXPECT_THROW(Profile({{a}, {a}}, 5, 0.0), std::invalid_argument);
  EXPECT_THROW(Profile({{{NAN, 0.0}}, {b}}, 5, 0.0), std::invalid_argument);
  EXPECT_THROW(Profile({{a, 0.05}, {b}}, 5, 0.0), std::invalid_argument);  // a chord of 0.2 m
  EXPECT_THROW(Profile({{a}, {b}}, 1, 0.0), std::invalid_argument);        // not around the axis
  EXPECT_THROW(Profile({{a}}, 0, 0.0), std::invalid_argument);
  EXPECT_NO_THROW(Profile({{a}, {b}}, 5, 0.0));
}

}  // namespace
