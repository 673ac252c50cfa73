#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "liner_families.h"

#include "core/liner/arc_bins.h"
#include "core/liner/contacts.h"

namespace {

using namespace millscale::liner;
using millscale::pi;

Profile drum(double radius)
{
  return Profile({Node{{-radius, 0.0}, radius}}, 1, 0.3);
}

/// Arc length of a point of the profile of a sector, by many chords.
double arc_length(const Profile& profile, Local point)
{
  double before = 0.0, best = INFINITY, at = 0.0;
  for (const Piece& piece : profile.pieces()) {
    constexpr int chords = 2000;
    for (int k = 0; k <= chords; ++k) {
      const double along = piece.length * k / chords;
      const Local p = piece.is_arc() ? piece.centre + turned(piece.begin - piece.centre,
                                                             along / piece.arc_radius)
                                     : piece.begin + along * piece.tangent_begin;
      const double distance = length(point - p);
      if (distance >= best) continue;
      best = distance;
      at = before + along;
    }
    before += piece.length;
  }
  return at;
}

TEST(ArcBins, CoverThePitchOnceAndStayOnOneFace)
{
  for (const auto& [name, profile] : millscale::test::liner_families()) {
    const ArcBins arc(profile, 100);
    double end = 0.0;
    for (const ArcBin& bin : arc.bins()) {
      EXPECT_NEAR(bin.begin, end, 1e-12) << name;
      EXPECT_LT(bin.end - bin.begin, 2.0 * arc.length() / 100) << name;
      end = bin.end;
    }
    EXPECT_NEAR(end, arc.length(), 1e-12) << name;
    for (const ArcBin& bin : arc.bins()) {
      const Frame frame(profile.sector_angle(0));
      const Nearest found = nearest(profile, frame.point(bin.middle + 1e-6 * left_of(bin.tangent)));
      EXPECT_NEAR(found.distance, 1e-6, 1e-9) << name;
      EXPECT_EQ(found.face, bin.face) << name;
      EXPECT_NEAR(arc_length(profile, bin.middle), 0.5 * (bin.begin + bin.end), 1e-3) << name;
    }
  }
}

TEST(ArcBins, HoldTheContactsOfBalls)
{
  const double ball = 0.02;
  for (const auto& [name, profile] : millscale::test::liner_families()) {
    const ArcBins arc(profile, 100);
    const ContactFinder finder(profile, ball);
    int seen = 0;
    for (int sector = 0; sector < profile.sectors(); ++sector)
      for (int k = 0; k < arc.count(); ++k) {
        const ArcBin& bin = arc.bins()[static_cast<std::size_t>(k)];
        const Frame frame(profile.sector_angle(sector));
        const Point centre = frame.point(bin.middle + 0.99 * ball * left_of(bin.tangent));
        int last = -1;
        const Found found = finder.find(centre, ball, last);
        // Near a corner, or in a fillet, the ball touches another side.
        if (found.count != 1 || nearest(profile, centre).distance < 0.989 * ball) continue;
        const ArcBins::Place place = arc.place(found.patch[0], centre);
        EXPECT_EQ(place.bin, k) << name;
        EXPECT_EQ(place.sector, sector) << name;
        ++seen;
      }
    EXPECT_GT(seen, profile.sectors() * arc.count() / 2) << name;
  }
}

TEST(ArcBins, GiveAnEdgeToTheNearerFace)
{
  const Lifters lifters(Widths{1.0, 0.92, 0.06, 0.6, 8, 0.1});
  const ArcBins arc(lifters, 100);
  const ContactFinder finder(lifters, 0.02);
  // Around the leading edge of the top of a lifter.
  const Piece& top = lifters.pieces()[0];
  for (const double turn : {0.05, 0.45, 0.55, 0.95}) {
    const double whole = -lifters.pieces()[1].turn;
    const Local out = turned(left_of(top.tangent_end), -turn * whole);
    const Point centre = Frame(lifters.sector_angle(3)).point(top.end + 0.019 * out);
    int last = -1;
    const Found found = finder.find(centre, 0.02, last);
    ASSERT_EQ(found.count, 1);
    ASSERT_EQ(found.patch[0] % 2, 1);
    const ArcBins::Place place = arc.place(found.patch[0], centre);
    EXPECT_EQ(place.sector, 3);
    EXPECT_EQ(arc.bins()[static_cast<std::size_t>(place.bin)].face,
              turn < 0.5 ? Face::top : Face::leading);
  }
  // The trailing edge of a top begins a sector; the face before it is of the sector before.
  const Local out = turned(left_of(top.tangent_begin), 0.9 * -top.turn);
  const Point centre = Frame(lifters.sector_angle(3)).point(top.begin + 0.019 * out);
  int last = -1;
  const Found found = finder.find(centre, 0.02, last);
  ASSERT_EQ(found.count, 1);
  const ArcBins::Place place = arc.place(found.patch[0], centre);
  EXPECT_EQ(place.sector, 2);
  EXPECT_EQ(place.bin, arc.count() - 1);
}

TEST(ArcBins, GoAllAroundADrum)
{
  const double radius = 0.7;
  const ArcBins arc(drum(radius), 36);
  EXPECT_EQ(arc.count(), 36);
  EXPECT_NEAR(arc.length(), 2.0 * pi * radius, 1e-12);
  const ContactFinder finder(drum(radius), 0.02);
  std::vector<int> hits(36, 0);
  for (int k = 0; k < 360; ++k) {
    const double angle = (k + 0.5) * pi / 180.0;
    const Point centre{0.69 * std::cos(angle), 0.69 * std::sin(angle)};
    int last = -1;
    const Found found = finder.find(centre, 0.02, last);
    ASSERT_EQ(found.count, 1);
    ++hits[static_cast<std::size_t>(arc.place(found.patch[0], centre).bin)];
  }
  for (const int count : hits) EXPECT_NEAR(count, 10, 1);
}

}  // namespace
