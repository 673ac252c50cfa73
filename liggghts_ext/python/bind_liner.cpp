#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "core/liner/area.h"
#include "core/liner/contacts.h"
#include "core/liner/groove_box.h"
#include "core/liner/lifters.h"
#include "core/liner/nearest.h"
#include "core/liner/offset.h"
#include "core/liner/polygon.h"
#include "core/liner/profile_file.h"
#include "python/bindings.h"

namespace nb = nanobind;
using namespace nb::literals;
using namespace millscale::liner;
using millscale::format;

namespace {

using Points = nb::ndarray<const double, nb::shape<-1, 2>, nb::c_contig, nb::device::cpu>;
template <typename T>
using Column = nb::ndarray<nb::numpy, T, nb::shape<-1>>;
using PointArray = nb::ndarray<nb::numpy, double, nb::shape<-1, 2>>;

/// Memory for a numpy array that frees it.
template <typename T>
std::pair<T*, nb::capsule> allocate(std::size_t size)
{
  auto memory = std::make_unique<T[]>(size);
  T* data = memory.get();
  nb::capsule owner(data, [](void* p) noexcept { delete[] static_cast<T*>(p); });
  memory.release();
  return {data, owner};
}

/// (n,) array of value(i), i = 0..n-1.
template <typename T, typename Value>
Column<T> column(std::size_t n, const Value& value)
{
  auto [data, owner] = allocate<T>(n);
  for (std::size_t i = 0; i < n; ++i) data[i] = value(i);
  return Column<T>(data, {n}, owner);
}

/// (n, 2) array of the points point(i), columns x and z.
template <typename PointAt>
PointArray points(std::size_t n, const PointAt& point)
{
  auto [data, owner] = allocate<double>(2 * n);
  for (std::size_t i = 0; i < n; ++i) {
    const Point p = point(i);
    data[2 * i] = p.x;
    data[2 * i + 1] = p.z;
  }
  return PointArray(data, {n, 2}, owner);
}

Point row(const Points& p, std::size_t i)
{
  return {p(i, 0), p(i, 1)};
}

/// The attributes of Nearest for many points, as arrays.
struct NearestPoints {
  Column<double> distance;
  Column<std::int64_t> face, sector;
  PointArray point, normal;
};

NearestPoints nearest_points(const Profile& liner, const Points& query)
{
  const std::size_t n = query.shape(0);
  const auto found = std::make_unique<Nearest[]>(n);
  for (std::size_t i = 0; i < n; ++i) found[i] = nearest(liner, row(query, i));
  return {column<double>(n, [&](std::size_t i) { return found[i].distance; }),
          column<std::int64_t>(n, [&](std::size_t i) { return static_cast<int>(found[i].face); }),
          column<std::int64_t>(n, [&](std::size_t i) { return found[i].sector; }),
          points(n, [&](std::size_t i) { return found[i].point; }),
          points(n, [&](std::size_t i) { return found[i].normal; })};
}

/// The contacts of balls at many points, one row a contact.
struct ContactRows {
  Column<std::int64_t> ball, surface, face, sector;
  Column<double> overlap;
  PointArray normal;
};

ContactRows contact_rows(const Profile& liner, const Points& centres, double ball_radius,
                         std::optional<double> chord_error)
{
  const ContactFinder finder(chord_error ? wall_profile(liner, *chord_error) : liner, ball_radius);
  std::vector<std::int64_t> ball;
  std::vector<Contact> found;
  for (std::size_t i = 0; i < centres.shape(0); ++i) {
    const Contacts here = finder.contacts(row(centres, i), ball_radius);
    for (int c = 0; c < here.count; ++c) {
      ball.push_back(static_cast<std::int64_t>(i));
      found.push_back(here.contact[static_cast<std::size_t>(c)]);
    }
  }
  const std::size_t n = found.size();
  return {column<std::int64_t>(n, [&](std::size_t i) { return ball[i]; }),
          column<std::int64_t>(n, [&](std::size_t i) { return found[i].surface; }),
          column<std::int64_t>(n, [&](std::size_t i) { return static_cast<int>(found[i].face); }),
          column<std::int64_t>(n, [&](std::size_t i) { return found[i].sector; }),
          column<double>(n, [&](std::size_t i) { return found[i].overlap; }),
          points(n, [&](std::size_t i) { return found[i].normal; })};
}

using NodeRow = std::tuple<double, double, double, int, int>;

/// Rows (radial, tangential, arc_radius, face, ahead) of the nodes.
std::vector<NodeRow> node_rows(const Profile& liner)
{
  std::vector<NodeRow> rows;
  for (const Node& n : liner.nodes())
    rows.emplace_back(n.point.radial, n.point.tangential, n.arc_radius, static_cast<int>(n.face),
                      n.ahead);
  return rows;
}

std::vector<Node> nodes_of(const std::vector<NodeRow>& rows)
{
  std::vector<Node> nodes;
  for (const auto& [radial, tangential, arc_radius, face, ahead] : rows) {
    if (face < 0 || face > 3) millscale::reject("profile, face", "must be 0 to 3", face);
    nodes.push_back({{radial, tangential}, arc_radius, static_cast<Face>(face), ahead});
  }
  return nodes;
}

std::pair<PointArray, Column<std::int64_t>> polygon_arrays(const Profile& liner, double chord_error)
{
  const Polygon p = polygon(liner, chord_error);
  return {points(p.nodes.size(), [&](std::size_t i) { return p.nodes[i]; }),
          column<std::int64_t>(p.faces.size(),
                               [&](std::size_t i) { return static_cast<int>(p.faces[i]); })};
}

std::string describe(const Lifters& l)
{
  return "Lifters(radius=" + format(l.radius()) +
         ", lifter_top_radius=" + format(l.lifter_top_radius()) +
         ", lifter_top_width=" + format(l.lifter_top_width()) +
         ", groove_width=" + format(l.groove_width()) + ", lifters=" + std::to_string(l.lifters()) +
         ", phase=" + format(l.phase()) + ")";
}

void bind_nearest(nb::module_& m)
{
  const auto vector = [](Point p) {
    return column<double>(2, [p](std::size_t i) { return i == 0 ? p.x : p.z; });
  };
  nb::class_<Nearest>(m, "Nearest", "The point of the liner that is nearest to a given point.")
      .def_ro("distance", &Nearest::distance, "[m], > 0 inside the cavity, < 0 inside the wall.")
      .def_prop_ro(
          "face", [](const Nearest& n) { return static_cast<int>(n.face); },
          "0 groove, 1 leading face, 2 top, 3 trailing face.")
      .def_ro("sector", &Nearest::sector, "Index of the groove, or of the lifter.")
      .def_prop_ro(
          "point", [vector](const Nearest& n) { return vector(n.point); }, nb::rv_policy::move,
          "(2,) float, x and z on the liner [m].")
      .def_prop_ro(
          "normal", [vector](const Nearest& n) { return vector(n.normal); }, nb::rv_policy::move,
          "(2,) float, unit vector into the cavity.");

  nb::class_<NearestPoints>(m, "NearestPoints",
                            "The points of the liner that are nearest to n given points.")
      .def_ro("distance", &NearestPoints::distance, nb::rv_policy::automatic,
              "(n,) float [m], > 0 inside the cavity.")
      .def_ro("face", &NearestPoints::face, nb::rv_policy::automatic, "(n,) int.")
      .def_ro("sector", &NearestPoints::sector, nb::rv_policy::automatic, "(n,) int.")
      .def_ro("point", &NearestPoints::point, nb::rv_policy::automatic,
              "(n, 2) float, x and z on the liner [m].")
      .def_ro("normal", &NearestPoints::normal, nb::rv_policy::automatic,
              "(n, 2) float, unit vectors into the cavity.");
}

void bind_contacts(nb::module_& m)
{
  nb::class_<ContactRows>(m, "Contacts", "Contacts of balls with the liner, one row a contact.")
      .def_ro("ball", &ContactRows::ball, nb::rv_policy::automatic, "(m,) int, row of the centre.")
      .def_ro("surface", &ContactRows::surface, nb::rv_policy::automatic,
              "(m,) int, index of the surface.")
      .def_ro("face", &ContactRows::face, nb::rv_policy::automatic,
              "(m,) int: 0 groove, 1 leading face, 2 top, 3 trailing face.")
      .def_ro("sector", &ContactRows::sector, nb::rv_policy::automatic,
              "(m,) int, index of the groove, or of the lifter.")
      .def_ro("overlap", &ContactRows::overlap, nb::rv_policy::automatic, "(m,) float, > 0 [m].")
      .def_ro("normal", &ContactRows::normal, nb::rv_policy::automatic,
              "(m, 2) float, unit vectors from the liner to the centre.");
}

void bind_profile(nb::module_& m)
{
  nb::class_<Profile>(m, "Profile",
                      "Cross-section of the mill's liner: lines and arcs of one sector, repeated. "
                      "Sector k is centred at polar angle 2 pi k / n + phase.")
      .def(
          "__init__",
          [](Profile* self, const std::vector<NodeRow>& nodes, int sectors, double phase) {
            new (self) Profile(nodes_of(nodes), sectors, phase);
          },
          "nodes"_a, "sectors"_a, "phase"_a = 0.0,
          "Nodes (radial, tangential, arc_radius, face, ahead) in the frame of the sector's "
          "centre line, in the direction of rotation. Each begins a piece that ends at the next "
          "node: a line (arc_radius 0), or an arc with its centre in the cavity (> 0) or in the "
          "wall (< 0) [m]. face: 0 groove, 1 leading, 2 top, 3 trailing; ahead: 1 for a piece of "
          "the next sector's first lifter. Raises ValueError, with the place, if the outline is "
          "inside-out or crosses itself, or if it does not go once around the axis.")
      .def_prop_ro("nodes", &node_rows, "Nodes as the constructor takes them.")
      .def_prop_ro("text", &profile_text,
                   "The profile as text of the file that `profile` of fix mill/similarity reads.")
      .def_prop_ro("radius", &Profile::radius, "R, largest distance from the axis [m].")
      .def_prop_ro("clear_radius", &Profile::clear_radius, "Smallest distance from the axis [m].")
      .def_prop_ro("sectors", &Profile::sectors, "Number of equal sectors; 1 for a plain drum.")
      .def_prop_ro("phase", &Profile::phase,
                   "Polar angle of the centre line of sector 0 at rest [rad].")
      .def_prop_ro("pitch", &Profile::pitch, "Angle from sector to sector [rad].")
      .def_prop_ro(
          "lifter_angles",
          [](const Profile& l) {
            return column<double>(
                static_cast<std::size_t>(l.grooves().count()),
                [&](std::size_t k) { return l.grooves().lifter_angle(static_cast<int>(k)); });
          },
          nb::rv_policy::move,
          "(n,) float, polar angles of the middles of all lifters at rest, from the bottom in the "
          "direction of rotation [rad]. Lifter k trails groove k. Without lifters: the borders of "
          "the sectors.")
      .def_prop_ro("groove_middle", &groove_middle,
                   "Polar angle of the middle of groove 0 at rest [rad].")
      .def_prop_ro("has_groove", &has_groove,
                   "False for a plain drum, and for a shape of one sector without straight faces.")
      .def_prop_ro("area", &area, "Area of the cavity, exact [m^2].")
      .def_prop_ro("narrowest_width", &narrowest_width,
                   "Narrowest width of a groove, at its foot or at its mouth [m].")
      .def(
          "scaled", [](const Profile& l, double S) { return scaled(l, S); }, "S"_a,
          "Return the profile with every length divided by S; angles and phase stay.")
      .def(
          "offset", [](const Profile& l, double distance) { return offset(l, distance); },
          "distance"_a,
          "Return the profile with every piece moved into the cavity by distance [m] (negative: "
          "into the wall).")
      .def(
          "offset_scaled",
          [](const Profile& l, double S, double ball_radius) {
            return offset_scaled(l, S, ball_radius);
          },
          "S"_a, "ball_radius"_a,
          "Return the liner of policy offset-liner: the path of the ball's centre scales by S "
          "[ball_radius m].")
      .def("polygon", &polygon_arrays, "chord_error"_a,
           "Return the closed polygon: nodes (n, 2) float [x, z] in m, in the direction of "
           "rotation, and faces (n,) int of the edges i -> i + 1: 0 groove, 1 leading face, 2 "
           "top, 3 trailing face. chord_error bounds the sagitta of the chords of arcs [m].")
      .def(
          "inside",
          [](const Profile& l, double x, double z) {
            return inside(l, {x, z});
          },
          "x"_a, "z"_a, "Return whether a point [m] lies in the cavity or on the liner.")
      .def(
          "inside",
          [](const Profile& l, const Points& p) {
            return column<bool>(p.shape(0), [&](std::size_t i) { return inside(l, row(p, i)); });
          },
          "points"_a,
          "Return whether each of (n, 2) points [m] lies in the cavity or on the liner; (n,) bool.")
      .def(
          "nearest",
          [](const Profile& l, double x, double z) {
            return nearest(l, {x, z});
          },
          "x"_a, "z"_a, "Return the point of the liner nearest to a given point [m], as Nearest.")
      .def("nearest", &nearest_points, "points"_a,
           "Return the points of the liner nearest to (n, 2) given points [m], as NearestPoints.")
      .def("contacts", &contact_rows, "centres"_a, "ball_radius"_a, "chord_error"_a = nb::none(),
           "Return the contacts of balls with centres (n, 2) in the cavity [m], as fix wall/mill "
           "finds them: at most one with each surface. Arcs are exact, or with a chord_error [m] "
           "the chords of `polygon`. The chords of an arc are one surface.")
      .def(
          "groove_box",
          [](const Profile& l) {
            const std::array<Point, 4> box = groove_box(l);
            return points(box.size(), [&](std::size_t i) { return box[i]; });
          },
          "Return the corners (4, 2) [m] of the box that holds groove 0 at rest. It lies between "
          "the planes of the facing lifter faces, from the tangent to the liner to the lifter "
          "tops. Without straight faces the box holds the whole sector.");
}

void bind_lifters(nb::module_& m)
{
  nb::class_<Lifters, Profile>(
      m, "Lifters",
      "Liner of equal trapezoidal lifters. Groove k is centred at polar angle 2 pi k / n + phase, "
      "lifter k half a pitch before it.")
      .def(
          "__init__",
          [](Lifters* self, double R, double r, double D1, double D2, int n, double phase) {
            new (self) Lifters(Widths{R, r, D1, D2, n, phase});
          },
          "radius"_a, "lifter_top_radius"_a, "lifter_top_width"_a, "groove_width"_a, "lifters"_a,
          "phase"_a = 0.0,
          "Trapezoid reading: faces are lines from the feet to the top corners, D1 apart. Feet of "
          "a groove are D2 apart. Plain drum: lifters = 0 and all widths but the radius 0. "
          "Lengths in m, phase in rad.")
      .def_static(
          "from_face_angle",
          [](double R, double r, double D1, double face_angle, int n, double phase) {
            return Lifters(Slopes{R, r, D1, face_angle, n, phase});
          },
          "radius"_a, "lifter_top_radius"_a, "lifter_top_width"_a, "face_angle"_a, "lifters"_a,
          "phase"_a = 0.0,
          "Return the liner whose groove width follows from the face angle [rad]; 0 is the "
          "parallel reading.")
      .def_prop_ro("lifter_top_radius", &Lifters::lifter_top_radius,
                   "r, from the axis to the middle of a lifter's flat top [m].")
      .def_prop_ro("lifter_top_width", &Lifters::lifter_top_width, "D1 [m].")
      .def_prop_ro("groove_width", &Lifters::groove_width,
                   "D2, chord of a groove between the feet of its lifters [m].")
      .def_prop_ro("lifters", &Lifters::lifters, "Number of lifters; 0 is a plain drum.")
      .def_prop_ro("face_angle", &Lifters::face_angle,
                   "Angle between a lifter's face and the lifter's centre line [rad].")
      .def(
          "scaled", [](const Lifters& l, double S) { return scaled(l, S); }, "S"_a,
          "Return the liner with every length divided by S; phase and angles stay.")
      .def(
          "offset", [](const Lifters& l, double distance) { return offset(l, distance); },
          "distance"_a,
          "Return the liner with every arc, face and top moved towards the axis by distance [m] "
          "(negative: away).")
      .def(
          "offset_scaled",
          [](const Lifters& l, double S, double ball_radius) {
            return offset_scaled(l, S, ball_radius);
          },
          "S"_a, "ball_radius"_a,
          "Return the liner of policy offset-liner: the path of the ball's centre scales by S "
          "[ball_radius m].")
      .def("__repr__", &describe);
}

}  // namespace

void millscale::python::bind_liner(nb::module_& m)
{
  bind_nearest(m);
  bind_contacts(m);
  bind_profile(m);
  bind_lifters(m);
}
