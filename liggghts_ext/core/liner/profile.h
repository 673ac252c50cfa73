#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/liner/crossing.h"
#include "core/liner/frame.h"
#include "core/liner/piece.h"
#include "core/math/checks.h"
#include "core/math/constants.h"
#include "core/math/format.h"

namespace millscale::liner {

/// Limits on sectors and pieces, above those of any mill. They keep the storage for each sector
/// small.
inline constexpr int most_sectors = 10'000;
inline constexpr std::size_t most_pieces = 100'000;

/// A piece as seen from the frame of a sector's centre line, and the sector of the piece.
struct PlacedPiece {
  Piece piece;
  int offset;       ///< the piece's sector less the frame's: -1, 0, 1
  int index;        ///< of the piece in its sector
  double turn_end;  ///< as Piece::turn, at the end of the piece [rad]
};

/// The grooves of a liner, and the lifters between them. Lifter k trails groove k and lifts its
/// balls. A groove reaches from the middle of its lifter to that of the next.
struct Grooves {
  int sectors = 1;
  double phase = 0.0;             ///< polar angle of the centre line of sector 0 at rest [rad]
  std::vector<double> lifters{};  ///< their middles from the centre line of their sector [rad];
                                  ///< empty: a sector is a groove

  int per_sector() const { return lifters.empty() ? 1 : static_cast<int>(lifters.size()); }
  int count() const { return sectors * per_sector(); }
  /// Angle from one sector to the next [rad].
  double pitch() const { return 2.0 * pi / sectors; }

  /// Groove that a polar angle of the mill at rest lies in, 0..count-1.
  int at(double psi) const
  {
    if (lifters.empty()) {
      const long k = std::lround((psi - phase) / pitch());
      return static_cast<int>(((k % sectors) + sectors) % sectors);
    }
    const double from_first = (psi - phase - lifters.front()) / pitch();
    const double turns = std::floor(from_first / sectors);
    const double place = from_first - turns * sectors;  // [0, sectors), in pitches
    const int sector = std::min(static_cast<int>(place), sectors - 1);
    const double beyond = lifters.front() + (place - sector) * pitch();
    const auto next = std::upper_bound(lifters.begin(), lifters.end(), beyond);
    const int of_sector = std::max(static_cast<int>(next - lifters.begin()) - 1, 0);
    return sector * per_sector() + of_sector;
  }

  /// Polar angle of the middle of lifter k of the mill at rest, 0..count-1 [rad].
  double lifter_angle(int k) const
  {
    const double from_centre =
        lifters.empty() ? -0.5 * pitch() : lifters[static_cast<std::size_t>(k % per_sector())];
    return phase + pitch() * (k / per_sector()) + from_centre;
  }
};

namespace detail {

inline int wrapped(int k, int n)
{
  return ((k % n) + n) % n;
}

}  // namespace detail

/// Cross-section of the mill's liner: the lines and arcs of one sector, repeated n times.
///
/// Sector k = 0..n-1 is centred at polar angle 2 pi k / n + phase. It may hold several lifters, or
/// none. A *lifter* is a chain of pieces that are not groove: trailing faces, tops, leading faces.
/// Behind a leading face begins another lifter. The pieces follow each other in the direction of
/// rotation, once around the axis, and do not cross. A *surface* is a chain of pieces without a
/// concave corner. Its pieces join smoothly, at convex edges, at shallow folds, or as chords of one
/// arc. A shape without concave corners is one surface.
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
    require_no_crossing(pieces_, sectors_);
    number_grooves();
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

  /// Sector that a polar angle lies in.
  int sector_at(double psi) const { return Grooves{sectors_, phase_}.at(psi); }

  const Grooves& grooves() const { return grooves_; }
  /// Index of the groove, or of the lifter, that a piece of a sector belongs to.
  int groove(const Piece& piece, int sector) const
  {
    return detail::wrapped(sector * grooves_.per_sector() + piece.groove, grooves_.count());
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
    int corners = 0;
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      pieces_[i].corner =
          nodes_[i].corner || (pieces_[i].turn >= detail::smallest_corner && !nodes_[i].continues);
      corners += pieces_[i].corner ? 1 : 0;
      pieces_[i].surface = corners;
    }
    if (corners == 0) return;
    if (pieces_[0].corner)
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
    const Piece& last = pieces_.back();
    const double to_last_node =
        around - std::atan2(cross(last.begin, last.end), dot(last.begin, last.end));
    if (to_last_node < -0.5 * pitch())
      throw std::invalid_argument(
          "profile: it is inside-out: from its first node to its last it goes by " +
          format(to_last_node) +
          " rad around the axis, against the direction of rotation; reverse "
          "the order of the nodes");
    if (!is_drum() && !(std::abs(around - pitch()) < 1e-6))
      throw std::invalid_argument(
          "profile: the pieces of a sector must go around the axis by the pitch, " +
          format(pitch()) + " rad, got " + format(around));
    if (!(clear_radius_ > 0.0))
      throw std::invalid_argument("profile: the axis must lie in the cavity");
  }

  /// Number grooves and lifters. At the beginning of a sector lies the lifter that the last sector
  /// began `ahead`, or else the groove behind the last lifter of the last sector.
  void number_grooves()
  {
    grooves_ = {sectors_, phase_};
    const std::size_t count = pieces_.size();
    const auto begins_lifter = [&](std::size_t i) {
      const Face face = pieces_[i].face, before = pieces_[(i + count - 1) % count].face;
      return face != Face::groove &&
             (before == Face::groove || (before == Face::leading && face != Face::leading));
    };
    std::vector<std::size_t> begins;
    for (std::size_t i = 0; i < count; ++i) {
      if (begins_lifter(i)) begins.push_back(i);
      pieces_[i].groove = static_cast<int>(begins.size());
    }
    if (begins.empty()) {
      for (Piece& piece : pieces_) piece.groove = piece.ahead;
      return;
    }
    const bool ahead = std::any_of(pieces_.begin() + static_cast<long>(begins.back()),
                                   pieces_.end(), [](const Piece& p) { return p.ahead == 1; });
    for (Piece& piece : pieces_) piece.groove -= ahead ? 0 : 1;
    if (ahead) {
      std::rotate(begins.begin(), begins.end() - 1, begins.end());
    }
    for (const std::size_t begin : begins) {
      std::size_t end = begin + 1;
      while (end < begin + count && pieces_[end % count].face != Face::groove &&
             !begins_lifter(end % count))
        ++end;
      const bool of_last = ahead && begin == begins.front();
      grooves_.lifters.push_back(middle_of(begin, end) - (of_last ? pitch() : 0.0));
    }
    // The middle of an equal lifter on the sectors' border is known exactly.
    if (begins.size() == 1 && std::abs(grooves_.lifters[0] + 0.5 * pitch()) < 1e-9)
      grooves_.lifters.clear();
  }

  /// Angle of the middle of a lifter from the sector's centre line: the middle of its tops, or the
  /// point nearest to the axis [rad]. begin, end: of its pieces, beyond the sector's last too.
  double middle_of(std::size_t begin, std::size_t end) const
  {
    const std::size_t count = pieces_.size();
    const auto angle_from = [](Local a, Local b) { return std::atan2(cross(a, b), dot(a, b)); };
    const Local first = pieces_[0].begin;
    double angle = std::atan2(first.tangential, first.radial);
    for (std::size_t i = 0; i < begin; ++i) angle += angle_from(pieces_[i].begin, pieces_[i].end);
    double low = 0.0, high = 0.0, crest = 0.0, least = INFINITY;
    bool has_top = false;
    for (std::size_t i = begin; i < end; ++i) {
      const Piece& piece = pieces_[i % count];
      const double after = angle + angle_from(piece.begin, piece.end);
      const Local nearest = detail::nearest_on(piece, {0.0, 0.0}).point;
      if (length(nearest) < least) {
        least = length(nearest);
        crest = angle + angle_from(piece.begin, nearest);
      }
      if (piece.face == Face::top) {
        if (!has_top) low = angle;
        high = after;
        has_top = true;
      }
      angle = after;
    }
    return has_top ? 0.5 * (low + high) : crest;
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
  Grooves grooves_;
  int sectors_;
  double phase_, radius_ = 0.0, clear_radius_ = 0.0;
};

}  // namespace millscale::liner
