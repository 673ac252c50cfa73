#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/liner/frame.h"
#include "core/math/checks.h"
#include "core/math/constants.h"
#include "core/math/format.h"

namespace millscale::liner {

/// Limits on sectors and pieces, above those of any mill. They keep the storage for each sector
/// small.
inline constexpr int most_sectors = 10'000;
inline constexpr std::size_t most_pieces = 100'000;

/// Part of the liner that a piece belongs to. The leading face of a lifter lifts the balls of its
/// groove. A shape without lifters is groove all over.
enum class Face { groove = 0, leading = 1, top = 2, trailing = 3 };

/// Where a piece of the profile begins; it ends at the next node.
struct Node {
  Local point;              ///< in the frame of the sector's centre line [m]
  double arc_radius = 0.0;  ///< 0: line; > 0: arc with its centre on the cavity's side; < 0: on the
                            ///< wall's side [m]. An arc is at most half a turn.
  Face face = Face::groove;  ///< of the piece
  int ahead = 0;             ///< 1: the piece belongs to the lifter of the next sector
  bool continues = false;    ///< no corner here: the fold is between chords of one arc
};

/// A line or an arc of the profile in the direction of rotation; the cavity is on its left.
struct Piece {
  Local begin, end;                  ///< in the frame of the sector's centre line [m]
  Local tangent_begin, tangent_end;  ///< unit vectors along the piece
  double length;                     ///< [m]
  double arc_radius;                 ///< as in Node [m]
  Local centre, middle;              ///< of an arc: its centre [m], unit vector to its middle
  double half_angle;                 ///< half the angle an arc spans [rad]
  Face face;
  int ahead;          ///< as in Node
  double turn = 0.0;  ///< angle by which the profile turns to the left at the piece's beginning;
                      ///< > 0: concave corner, < 0: convex edge, 0: smooth [rad]
  int surface = 0;    ///< number of its surface in the sector
  int surface_ahead = 0;  ///< 1: it belongs to that surface of the next sector

  bool is_arc() const { return arc_radius != 0.0; }
};

/// A piece as seen from the frame of a sector's centre line, and the sector of the piece.
struct PlacedPiece {
  Piece piece;
  int offset;       ///< the piece's sector less the frame's: -1, 0, 1
  int index;        ///< of the piece in its sector
  double turn_end;  ///< as Piece::turn, at the end of the piece [rad]
};

/// How a liner repeats around the mill.
struct Sectors {
  int count = 1;
  double phase = 0.0;  ///< polar angle of the centre line of sector 0 at rest [rad]

  /// Sector that a polar angle of the mill at rest lies in, 0..count-1. This is the index of the
  /// groove there, and of the lifter that lifts the groove's balls.
  int at(double psi) const
  {
    const long k = std::lround((psi - phase) / (2.0 * pi / count));
    return static_cast<int>(((k % count) + count) % count);
  }
};

namespace detail {

inline std::string between(double low, double high, const char* unit)
{
  return "must be > " + format(low) + " and < " + format(high) + " " + unit;
}

inline void require_between(const char* what, double low, double high, double got,
                            const char* reason)
{
  if (!(got > low && got < high)) reject(what, between(low, high, "m") + " (" + reason + ")", got);
}

inline int wrapped(int k, int n)
{
  return ((k % n) + n) % n;
}

/// Smallest turn of the profile's direction that counts as a corner [rad].
inline constexpr double smooth_turn = 1e-6;

inline Piece line(Local begin, Local end)
{
  const Local along = end - begin;
  const double size = length(along);
  if (!(size > 0.0)) throw std::invalid_argument("profile: two nodes must not be the same point");
  const Local tangent = (1.0 / size) * along;
  return {begin, end, tangent, tangent, size, 0.0, {}, {}, 0.0, Face::groove, 0};
}

inline Piece arc(Local begin, Local end, double arc_radius)
{
  const Local chord = end - begin;
  const double half_chord = 0.5 * length(chord), radius = std::abs(arc_radius);
  if (!(half_chord > 0.0 && half_chord <= radius * (1.0 + 1e-12)))
    reject("profile, arc radius", "must be >= half the arc's chord, " + format(half_chord) + " m",
           radius);
  const double half_angle = std::asin(std::min(half_chord / radius, 1.0));
  const double side = arc_radius > 0.0 ? 1.0 : -1.0;
  const Local to_cavity = (0.5 / half_chord) * left_of(chord);
  Local centre = 0.5 * (begin + end) + (side * radius * std::cos(half_angle)) * to_cavity;
  if (length(centre) < 1e-12 * radius) centre = {0.0, 0.0};  // an arc around the axis
  const auto tangent = [&](Local point) { return (side / radius) * left_of(point - centre); };
  return {begin,      end,    tangent(begin),      tangent(end), 2.0 * radius * half_angle,
          arc_radius, centre, (-side) * to_cavity, half_angle,   Face::groove,
          0};
}

/// A full circle around the axis, from a point on it.
inline Piece circle(Local begin, double radius)
{
  if (!(radius > 0.0) || std::abs(length(begin) - radius) > 1e-12 * radius)
    throw std::invalid_argument("profile: a single piece must be a circle around the axis");
  const Local out = (1.0 / radius) * begin, tangent = left_of(out);
  return {begin,      begin, tangent,      tangent, 2.0 * pi * radius, radius, {0.0, 0.0},
          -1.0 * out, pi,    Face::groove, 0};
}

/// The piece as seen from a frame behind its own by an angle [rad].
inline Piece turned_piece(Piece piece, double angle)
{
  for (Local* v : {&piece.begin, &piece.end, &piece.tangent_begin, &piece.tangent_end,
                   &piece.centre, &piece.middle})
    *v = turned(*v, angle);
  return piece;
}

/// Point of a piece nearest to a given point, and which end of the piece it is, if any.
struct OnPiece {
  Local point;
  bool is_begin = false, is_end = false;
};

inline OnPiece nearest_on(const Piece& piece, Local p)
{
  if (!piece.is_arc()) {
    const double along = dot(p - piece.begin, piece.tangent_begin);
    if (along <= 0.0) return {piece.begin, true, false};
    if (along >= piece.length) return {piece.end, false, true};
    return {piece.begin + along * piece.tangent_begin};
  }
  const Local arm = p - piece.centre;
  const double distance = length(arm);
  const double radius = std::abs(piece.arc_radius);
  if (distance == 0.0) return {piece.centre + radius * piece.middle};
  if (dot(arm, piece.middle) >= distance * std::cos(piece.half_angle))
    return {piece.centre + (radius / distance) * arm};
  const bool begin = length(p - piece.begin) <= length(p - piece.end);
  return {begin ? piece.begin : piece.end, begin, !begin};
}

}  // namespace detail

/// Cross-section of the mill's liner: the lines and arcs of one sector, repeated n times.
///
/// Sector k = 0..n-1 is centred at polar angle 2 pi k / n + phase. Its lifter, if any, trails its
/// groove and lifts the balls of the sector. The pieces follow each other in the direction of
/// rotation, once around the axis. A *surface* is a chain of pieces without a concave corner. Its
/// pieces join smoothly, at convex edges, or as chords of one arc. A shape without concave corners
/// is one surface.
class Profile {
 public:
  /// Throws std::invalid_argument if the nodes do not form such a cross-section. A single node in a
  /// single sector is a circle around the axis.
  Profile(const std::vector<Node>& nodes, int sectors, double phase)
      : nodes_(nodes), sectors_(sectors), phase_(phase)
  {
    check();
    make_pieces();
    find_turns();
    number_surfaces();
    measure();
    place_around();
  }

  /// Number of sectors; 1: a plain drum, or a shape given all around.
  int sectors() const { return sectors_; }
  /// Polar angle of the centre line of sector 0 at rest [rad].
  double phase() const { return phase_; }
  /// Angle from one sector to the next [rad].
  double pitch() const { return 2.0 * pi / sectors_; }
  /// Largest distance of the liner from the axis [m].
  double radius() const { return radius_; }
  /// Smallest distance of the liner from the axis [m].
  double clear_radius() const { return clear_radius_; }
  /// Return whether the liner is a circle.
  bool is_drum() const { return sectors_ == 1 && nodes_.size() == 1; }

  const std::vector<Node>& nodes() const { return nodes_; }
  /// Pieces of one sector, in the frame of its centre line.
  const std::vector<Piece>& pieces() const { return pieces_; }

  /// Pieces of a sector and of the two sectors beside it, in the frame of the first. The nearest
  /// point of the liner is on one of them, because the nearest repetition of a point is at most
  /// half a pitch away. Order: groove, faces, top; each from ahead to behind. Ties go to the first.
  const std::vector<PlacedPiece>& around() const { return around_; }

  /// Polar angle of the centre line of sector k [rad].
  double sector_angle(int k) const { return phase_ + pitch() * k; }

  /// Sector that a polar angle lies in: the groove there, and the lifter that lifts its balls.
  int sector_at(double psi) const { return Sectors{sectors_, phase_}.at(psi); }

  /// Index of the groove, or of the lifter, that a piece of a sector belongs to.
  int owner(const Piece& piece, int sector) const
  {
    return detail::wrapped(sector + piece.ahead, sectors_);
  }
  /// Index of the surface of a piece of a sector, >= 0.
  int surface(const Piece& piece, int sector) const
  {
    if (groove_surfaces_.empty()) return 0;
    return surfaces_per_sector() * detail::wrapped(sector + piece.surface_ahead, sectors_) +
           piece.surface;
  }
  /// Return whether a surface holds a piece of groove; the surface of a lifter does not.
  bool is_groove(int surface) const
  {
    return groove_surfaces_.empty() ||
           groove_surfaces_[static_cast<std::size_t>(surface % surfaces_per_sector())];
  }
  /// Number of surfaces that end in a sector; 0 if one surface goes all around.
  int surfaces_per_sector() const { return static_cast<int>(groove_surfaces_.size()); }

 private:
  void check() const
  {
    if (nodes_.empty() || nodes_.size() > most_pieces)
      throw std::invalid_argument("profile: must have 1 to " + std::to_string(most_pieces) +
                                  " pieces, got " + std::to_string(nodes_.size()));
    if (sectors_ < 1 || sectors_ > most_sectors)
      reject("sectors", "must be 1 to " + std::to_string(most_sectors), sectors_);
    require_finite("phase", phase_);
    for (const Node& node : nodes_) {
      require_finite("profile, radial", node.point.radial);
      require_finite("profile, tangential", node.point.tangential);
      require_finite("profile, arc radius", node.arc_radius);
      if (node.ahead != 0 && node.ahead != 1)
        reject("profile, ahead", "must be 0 or 1", node.ahead);
    }
  }

  void make_pieces()
  {
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const Node& node = nodes_[i];
      const Local end =
          i + 1 < nodes_.size() ? nodes_[i + 1].point : turned(nodes_[0].point, pitch());
      pieces_.push_back(is_drum()                ? detail::circle(node.point, node.arc_radius)
                        : node.arc_radius == 0.0 ? detail::line(node.point, end)
                                                 : detail::arc(node.point, end, node.arc_radius));
      pieces_.back().face = node.face;
      pieces_.back().ahead = node.ahead;
    }
  }

  void find_turns()
  {
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      const Local before =
          i > 0 ? pieces_[i - 1].tangent_end : turned(pieces_.back().tangent_end, -pitch());
      const Local after = pieces_[i].tangent_begin;
      const double turn = std::atan2(cross(before, after), dot(before, after));
      pieces_[i].turn = std::abs(turn) < detail::smooth_turn ? 0.0 : turn;
    }
  }

  /// Surface 0 of a sector is the first surface with a groove. So the number of a groove does not
  /// depend on the node where the sector begins.
  void number_surfaces()
  {
    const auto ends_a_surface = [this](std::size_t i) {
      return pieces_[i].turn > 0.0 && !nodes_[i].continues;
    };
    int corners = 0;
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      corners += ends_a_surface(i) ? 1 : 0;
      pieces_[i].surface = corners;
    }
    if (corners == 0) return;
    if (ends_a_surface(0))
      for (Piece& piece : pieces_) --piece.surface;
    std::vector<bool> groove(static_cast<std::size_t>(corners), false);
    for (Piece& piece : pieces_) {
      piece.surface_ahead =
          piece.surface / corners;  // surface ends behind the sector's first corner
      piece.surface %= corners;
      if (piece.face == Face::groove) groove[static_cast<std::size_t>(piece.surface)] = true;
    }
    const auto first = std::find(groove.begin(), groove.end(), true);
    const int shift = first == groove.end() ? 0 : static_cast<int>(first - groove.begin());
    for (Piece& piece : pieces_) piece.surface = detail::wrapped(piece.surface - shift, corners);
    std::rotate(groove.begin(), groove.begin() + shift, groove.end());
    groove_surfaces_ = groove;
  }

  void measure()
  {
    clear_radius_ = INFINITY;
    double around = 0.0;
    for (const Piece& piece : pieces_) {
      clear_radius_ = std::min(clear_radius_, length(detail::nearest_on(piece, {0.0, 0.0}).point));
      radius_ = std::max({radius_, length(piece.begin), length(piece.end)});
      if (piece.is_arc()) {
        // The point of an arc's circle that is farthest from the axis, if the arc has it.
        const double off = length(piece.centre);
        const Local out = off > 0.0 ? (1.0 / off) * piece.centre : piece.middle;
        if (dot(out, piece.middle) >= std::cos(piece.half_angle))
          radius_ = std::max(radius_, off + std::abs(piece.arc_radius));
      }
      around += std::atan2(cross(piece.begin, piece.end), dot(piece.begin, piece.end));
    }
    for (const Piece& piece : pieces_)  // remove the rounding of the ends of an arc around the axis
      if (length(piece.centre) == 0.0 && std::abs(radius_ - piece.arc_radius) < 1e-12 * radius_)
        radius_ = piece.arc_radius;
    if (!is_drum() && !(std::abs(around - pitch()) < 1e-6))
      throw std::invalid_argument(
          "profile: the pieces of a sector must go around the axis by the pitch, " +
          format(pitch()) + " rad, got " + format(around));
    if (!(clear_radius_ > 0.0))
      throw std::invalid_argument("profile: the axis must lie in the cavity");
  }

  void place_around()
  {
    const int count = static_cast<int>(pieces_.size());
    for (int offset = sectors_ > 1 ? 1 : 0; offset >= (sectors_ > 2 ? -1 : 0); --offset)
      for (int i = count - 1; i >= 0; --i) {
        const Piece& piece = pieces_[static_cast<std::size_t>(i)];
        const Piece& next = pieces_[static_cast<std::size_t>((i + 1) % count)];
        around_.push_back({detail::turned_piece(piece, offset * pitch()), offset, i, next.turn});
      }
    const auto rank = [](const PlacedPiece& placed) {
      const Face face = placed.piece.face;
      return face == Face::groove ? 0 : face == Face::top ? 2 : 1;
    };
    std::stable_sort(
        around_.begin(), around_.end(),
        [rank](const PlacedPiece& a, const PlacedPiece& b) { return rank(a) < rank(b); });
  }

  std::vector<Node> nodes_;
  std::vector<Piece> pieces_;
  std::vector<PlacedPiece> around_;
  std::vector<bool> groove_surfaces_;
  int sectors_;
  double phase_, radius_ = 0.0, clear_radius_ = 0.0;
};

}  // namespace millscale::liner
