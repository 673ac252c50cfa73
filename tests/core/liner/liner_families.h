#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "core/liner/lifters.h"
#include "core/liner/profile.h"

namespace millscale::test {

/// A corner of a sector's outline, and the piece that begins there.
struct Corner {
  liner::Local point;  ///< in the frame of the sector's centre line [m]
  liner::Face face;
  double radius = 0.0;  ///< of the arc that rounds the corner; 0: sharp [m]
  int ahead = 0;
};

/// The nodes of an outline of lines with rounded corners; the first corner is sharp.
inline std::vector<liner::Node> rounded(const std::vector<Corner>& corners, int sectors)
{
  using liner::Local;
  std::vector<liner::Node> nodes;
  const std::size_t count = corners.size();
  const auto towards = [](Local a, Local b) { return (1.0 / length(b - a)) * (b - a); };
  for (std::size_t i = 0; i < count; ++i) {
    const Corner& c = corners[i];
    if (c.radius == 0.0) {
      nodes.push_back({c.point, 0.0, c.face, c.ahead});
      continue;
    }
    const Local next =
        i + 1 < count ? corners[i + 1].point : turned(corners[0].point, 2.0 * pi / sectors);
    const Local before = towards(corners[i - 1].point, c.point), after = towards(c.point, next);
    const double turn = std::atan2(cross(before, after), dot(before, after));
    const double cut = c.radius * std::tan(0.5 * std::abs(turn));
    nodes.push_back(
        {c.point - cut * before, std::copysign(c.radius, turn), corners[i - 1].face, c.ahead});
    nodes.push_back({c.point + cut * after, 0.0, c.face, c.ahead});
  }
  return nodes;
}

/// A lifter that stands on the circle of the liner.
struct LifterShape {
  double angle;              ///< of its middle from the sector's centre line [rad]
  double height, top_width;  ///< [m]
  double leading, trailing;  ///< angles of the faces from the lifter's middle [rad]
  double edge_radius = 0.0, foot_radius = 0.0;  ///< [m]
  int ahead = 0;
};

/// Corners of a lifter: its trailing foot, top corners and leading foot.
inline std::vector<Corner> lifter(const LifterShape& s, double R)
{
  using liner::Face;
  using liner::Local;
  using liner::turned;
  const double r = R - s.height, half = 0.5 * s.top_width;
  const auto foot = [&](double slope) {  // on the circle, beside the middle
    const Local along{std::cos(slope), std::sin(slope)}, from{r, half};
    const double b = dot(from, along);
    return from + (-b + std::sqrt(b * b + R * R - dot(from, from))) * along;
  };
  const Local front = foot(s.leading), back = foot(s.trailing);
  const auto at = [&](double radial, double tangential) {
    return turned({radial, tangential}, s.angle);
  };
  return {{at(back.radial, -back.tangential), Face::trailing, 0.0, s.ahead},
          {at(r, -half), Face::top, s.edge_radius, s.ahead},
          {at(r, half), Face::leading, s.edge_radius, s.ahead},
          {at(front.radial, front.tangential), Face::groove, s.foot_radius}};
}

/// A liner with flat grooves between lifters.
inline liner::Profile with_lifters(const std::vector<LifterShape>& shapes, double R, int sectors)
{
  std::vector<Corner> corners;
  for (const LifterShape& shape : shapes)
    for (const Corner& corner : lifter(shape, R)) corners.push_back(corner);
  return {rounded(corners, sectors), sectors, 0.0};
}

/// Crests and valleys of arcs with smooth joints. Each crest is a lifter.
inline liner::Profile wave(int sectors, double R = 1.02, double valley = 0.9)
{
  using liner::Face;
  using liner::Local;
  // The circles of valley and crest, of one radius r, touch half way between their centres.
  const double half = pi / sectors;
  const double q = R,
               r = 0.5 * std::sqrt(valley * valley + q * q - 2.0 * valley * q * std::cos(half));
  const Local low{valley, 0.0}, crest{q * std::cos(half), q * std::sin(half)};
  const Local mirrored{crest.radial, -crest.tangential}, top = (1.0 - r / q) * crest;
  return {{{turned(top, -2.0 * half), -r, Face::leading},
           {0.5 * (low + mirrored), r, Face::groove},
           {0.5 * (low + crest), -r, Face::trailing, 1}},
          sectors,
          0.1};
}

/// Steps: a slope that ends at a face which drops to the next slope.
inline liner::Profile steps(int sectors, double height, double crest_radius, double flat)
{
  using liner::Face;
  using liner::Local;
  const double half = pi / sectors, R = 1.0;
  const auto polar = [](double radius, double angle) {
    return Local{radius * std::cos(angle), radius * std::sin(angle)};
  };
  std::vector<Corner> corners{{polar(R, -half), Face::groove}};
  if (flat > 0.0) corners.push_back({polar(R - height, half - flat), Face::top});
  corners.push_back({polar(R - height, half - 0.02), Face::leading, crest_radius});
  return {rounded(corners, sectors), sectors, -0.3};
}

struct Family {
  std::string name;
  liner::Profile profile;
};

/// The outline of a profile given once all around, in one sector.
inline liner::Profile all_around(const liner::Profile& profile)
{
  std::vector<liner::Node> nodes;
  for (int k = 0; k < profile.sectors(); ++k)
    for (liner::Node node : profile.nodes()) {
      node.point = turned(node.point, k * profile.pitch());
      node.ahead = 0;
      nodes.push_back(node);
    }
  return {nodes, 1, profile.phase()};
}

constexpr double degree = pi / 180.0;

/// Liner families of ball mills, of radius 1 m. Heights and angles of the worn lifter are those of
/// a liner of 3.9 m radius: face 14 to 47 degrees, height 152 to 58 mm.
inline std::vector<Family> liner_families()
{
  const double mm = 1e-3 / 3.9;
  const liner::Profile hi_lo = with_lifters(
      {{-0.2, 0.10, 0.05, 0.2, 0.3, 0.008, 0.0}, {0.05, 0.04, 0.08, 0.5, 0.2, 0.0, 0.03}}, 1.0, 12);
  return {{"smooth", liner::Lifters(liner::Widths{1.0, 0.0, 0.0, 0.0, 0, 0.0})},
          {"wave", wave(24)},
          {"rib", with_lifters({{0.0, 0.08, 0.03, 0.05, 0.05, 0.006, 0.01}}, 1.0, 18)},
          {"step", steps(16, 0.05, 0.0, 0.08)},
          {"ship-lap", steps(20, 0.04, 0.015, 0.0)},
          {"hi-lo", hi_lo},
          {"new", with_lifters({{0.0, 152 * mm, 120 * mm, 14 * degree, 14 * degree}}, 1.0, 25)},
          {"worn",
           with_lifters({{0.02, 58 * mm, 90 * mm, 47 * degree, 20 * degree, 30 * mm}}, 1.0, 25)},
          {"hi-lo all around", all_around(hi_lo)}};
}

}  // namespace millscale::test
