#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "core/liner/fillets.h"
#include "core/liner/nearest.h"
#include "core/liner/patch.h"
#include "core/liner/piece_grid.h"
#include "core/liner/polygon.h"
#include "core/liner/profile.h"

namespace millscale::liner {

/// The profile of a wall with the given chord error [m], with chords in place of arcs. The chords
/// of one arc count as one surface. This holds while the contacts with two neighbouring chords lie
/// within one Hertz patch, so for small folds. A fold of 60 degrees is refused, as in the engine's
/// meshes (`curvature`). Throws std::invalid_argument.
inline Profile wall_profile(const Profile& profile, double chord_error)
{
  Profile chorded = with_chords(profile, chord_error);
  double fold = 0.0;
  for (std::size_t i = 0; i < chorded.pieces().size(); ++i)
    if (chorded.nodes()[i].continues) fold = std::max(fold, chorded.pieces()[i].turn);
  if (!(fold < pi / 3.0))
    reject("chord error",
           "gives chords that fold by " + format(fold) +
               " rad; a wall takes folds < pi/3 rad, so chord errors < " +
               format(profile.radius() * (1.0 - std::cos(pi / 6.0))) +
               " m, or less for arcs of smaller radii",
           chord_error);
  return chorded;
}

/// One contact of a ball with the liner.
struct Contact {
  double overlap;  ///< > 0 [m]
  int surface;     ///< index of the surface, as in Profile::surface
  Face face;       ///< at an edge, of the piece behind the edge in the direction of rotation
  int sector;      ///< of the groove, or of the lifter for its faces and top
  Point normal;    ///< from the liner to the ball's centre, unit vector
};

/// The contacts of a ball, each with another surface. If there are more than `most`, the deepest
/// are kept.
struct Contacts {
  static constexpr int most = 3;
  int count = 0;
  std::array<Contact, most> contact;
};

/// Result of a ball's last search, which shortens most of the next searches.
struct LastSearch {
  int sector = -1;     ///< sector that the centre was in; -1: not known
  double clear = 0.0;  ///< distance the centre can move, in the mill's frame, without a contact
                       ///< [m]; 0 if the ball is in contact
};

/// The patches that a ball is in contact with.
struct Found {
  int count = 0;
  std::array<int, Contacts::most> patch;  ///< numbers of patches
  double clear = 0.0;  ///< distance the centre can move, in the mill's frame, without a contact
                       ///< with a patch not found [m]; 0 if there are three
};

/// Find the contacts of many balls with one liner. Quantities that do not depend on the ball are
/// computed once.
///
/// A contact is a local minimum of the distance to the liner that is less than the ball's radius.
/// The minimum is a point of a piece that the centre projects onto, or a convex edge. Only the
/// nearest minimum of each surface is a contact. So a concave corner gives two contacts and a
/// convex edge gives one. Over a smooth joint, or from chord to chord of an arc, a contact
/// continues: two contacts there would double the force. Balls must fit into the liner: a ball
/// reaches no farther than the two sectors beside its own.
class ContactFinder {
 public:
  /// For balls of up to `usual_radius` [m]; larger balls are searched slowly.
  ContactFinder(const Profile& profile, double usual_radius)
      : profile_(with_corners_for(profile, usual_radius)),
        reach_((is_short(profile) ? 2.0 : 1.5) * usual_radius),
        usual_radius_(usual_radius),
        grid_(profile, reach_, is_short(profile) ? profile.radius() / 64 : 0.5 * usual_radius),
        slack_(1e-12 * profile.radius()),
        phase_(std::remainder(profile.phase(), 2.0 * pi)),
        per_pitch_(1.0 / profile.pitch()),
        cos_half_pitch_(std::cos(0.5 * profile.pitch())),
        sin_half_pitch_(std::sin(0.5 * profile.pitch()))
  {
    for (int k = 0; k < profile.sectors(); ++k) frames_.emplace_back(profile.sector_angle(k));
    for (const PlacedPiece& placed : profile_.around()) candidates_.push_back(candidate(placed));
    for (std::size_t i = 0; i < candidates_.size(); ++i) all_.push_back(static_cast<int>(i));
    if (is_short(profile)) of_sector_ = grid_.all();
    make_patches();
  }

  /// The profile, with corners where it turns in too narrowly for the balls.
  const Profile& profile() const { return profile_; }
  /// Smallest distance of the liner from the axis [m].
  double clear_radius() const { return profile_.clear_radius(); }

  /// Return whether a point lies in the cavity or on the liner, as `liner::inside` does, at a cost
  /// that does not depend on the number of pieces. `p` is in the frame of the mill at rest.
  bool inside(Point p) const
  {
    if (p.x * p.x + p.z * p.z < clear_radius() * clear_radius()) return true;
    int sector = -1;
    const Local at = settle(p, sector);
    const PieceGrid::Range candidates = grid_.near(at);
    if (candidates.begin() == candidates.end()) return grid_.is_clear(at);
    detail::NearestSearch search(profile_, at);
    for (const int k : candidates) search.look_at(profile_.around()[k]);
    const double distance = search.found().distance;
    if (std::abs(distance) > reach_) return liner::inside(profile_, p);
    return distance >= 0.0;
  }

  /// Contacts of a ball with the given radius [m] and centre `p` in the cavity. `p` is in the frame
  /// of the mill at rest.
  Contacts contacts(Point p, double ball_radius) const
  {
    LastSearch last;
    return contacts(p, ball_radius, last);
  }

  /// The same contacts, found faster with the result of the ball's last search. `last` is updated.
  Contacts contacts(Point p, double ball_radius, LastSearch& last) const
  {
    const Found found = find(p, ball_radius, last.sector);
    last.clear = found.count > 0 ? 0.0 : found.clear;
    Contacts result;
    for (; result.count < found.count; ++result.count) {
      const std::size_t k = static_cast<std::size_t>(found.patch[result.count]);
      const auto touch = before(patches_[k], p.x, p.z, 0.0);
      result.contact[result.count] = {ball_radius - touch.distance,
                                      owners_[k].surface,
                                      owners_[k].face,
                                      owners_[k].sector,
                                      {touch.normal_x, touch.normal_z}};
    }
    return result;
  }

  /// The patches in contact. `sector` is that of the ball's last search, -1 if not known, and is
  /// updated. While the centre moves by less than `clear`, the ball can touch only the patches
  /// found, and does so where `before` gives a distance less than its radius.
  Found find(Point p, double ball_radius, int& sector) const
  {
    const double distance = std::sqrt(p.x * p.x + p.z * p.z);
    const double clear = clear_radius() - ball_radius;
    Found found;
    if (clear > 0.0 && !(distance >= clear)) {  // also for NaN positions
      found.clear = clear - distance;
      return found;
    }
    const Local at = settle(p, sector);
    const bool usual = ball_radius <= usual_radius_;
    const PieceGrid::Range candidates = usual ? near(at) : range(all_);
    Minima minima;
    search(candidates, at, ball_radius, minima);
    // The centre is in the wall, or the nearest pieces are farther away than `reach_`.
    if (minima.nearest.distance < 0.0) search_from_wall(at, ball_radius, minima);
    for (; found.count < minima.count; ++found.count)
      found.patch[found.count] = number_of(minima.of_surface[found.count], sector);
    const double reach = usual ? reach_ : INFINITY;
    if (minima.count == 0) {
      found.clear = std::max(0.0, std::min(minima.nearest.distance, reach) - ball_radius);
    } else if (minima.count <= 2 && minima.nearest.distance > 0.0) {
      found.clear = std::max(0.0, way_to_others(candidates, at, ball_radius, reach, minima));
    }
    return found;
  }

  /// All patches: those of sector 0, of sector 1, ... Each piece has two, itself and the edge where
  /// it begins.
  const std::vector<Patch>& patches() const { return patches_; }
  /// Index of a patch's surface, as in Profile::surface.
  int surface_of(std::size_t patch) const { return owners_[patch].surface; }

 private:
  /// A piece as the search needs it, in the frame of a sector's centre line.
  struct Candidate {
    Local begin, tangent;  ///< of the piece, at its beginning
    double length;         ///< of a line [m]
    double arc_radius;     ///< as in Node [m]
    Local centre, middle;  ///< of an arc
    double cos_half_angle;
    Local before;  ///< unit tangent at the end of the piece before
    double turn;   ///< as in Piece
    int surface;   ///< index of its surface, if the frame is that of sector 0
    int offset;    ///< its sector less the frame's
    int patch;     ///< number of its patch, if it were in sector 0
    Local end;     ///< of the piece
  };

  /// What a patch is a part of, as in Contact.
  struct Owner {
    int surface;
    Face face;
    int sector;
  };

  /// A local minimum of the distance.
  struct Minimum {
    double distance;  ///< < 0: on the wall's side [m]
    const Candidate* candidate;
    bool at_edge;
  };
  /// The minimum with the least absolute distance, and the minima of each surface within the
  /// radius.
  struct Minima {
    Minimum nearest{INFINITY, nullptr, false};
    int count = 0;
    std::array<Minimum, Contacts::most> of_surface;

    void add(const Minimum& found)
    {
      int k = 0;
      while (k < count && of_surface[k].candidate->surface != found.candidate->surface) ++k;
      if (k == count && count < Contacts::most) {
        of_surface[count++] = found;
        return;
      }
      if (k == count)
        k = static_cast<int>(std::max_element(of_surface.begin(), of_surface.end(),
                                              [](const Minimum& a, const Minimum& b) {
                                                return a.distance < b.distance;
                                              }) -
                             of_surface.begin());
      if (found.distance < of_surface[k].distance) of_surface[k] = found;
    }
  };

  Candidate candidate(const PlacedPiece& placed) const
  {
    const Piece& piece = placed.piece;
    return {piece.begin,
            piece.tangent_begin,
            piece.length,
            piece.arc_radius,
            piece.centre,
            piece.middle,
            std::cos(piece.half_angle),
            turned(piece.tangent_begin, -piece.turn),
            piece.turn,
            profile_.surface(piece, placed.offset),
            placed.offset,
            2 * placed.index,
            piece.end};
  }

  void make_patches()
  {
    for (int sector = 0; sector < profile_.sectors(); ++sector) {
      const Frame& frame = frames_[static_cast<std::size_t>(sector)];
      const auto circle = [&](Local centre, double radius, double side) {
        const Point p = frame.point(centre);
        return Patch{p.x, p.z, 0.0, 0.0, 0.0, radius, side, 1.0};
      };
      for (const Piece& piece : profile_.pieces()) {
        if (piece.is_arc()) {
          patches_.push_back(
              circle(piece.centre, piece.arc_radius, piece.arc_radius > 0.0 ? 1.0 : -1.0));
        } else {
          const Point p = frame.point(piece.begin);
          const Point normal = frame.point(left_of(piece.tangent_begin));
          patches_.push_back({p.x, p.z, normal.x, normal.z, 0.0, 0.0, 0.0, 1.0});
        }
        patches_.push_back(circle(piece.begin, 0.0, -1.0));
        const Owner owner{profile_.surface(piece, sector), piece.face,
                          profile_.groove(piece, sector)};
        owners_.insert(owners_.end(), 2, owner);
      }
    }
  }

  int number_of(const Minimum& minimum, int sector) const
  {
    const Candidate& c = *minimum.candidate;
    const int per_sector = 2 * static_cast<int>(profile_.pieces().size());
    return per_sector * beside(sector, c.offset) + c.patch + (minimum.at_edge ? 1 : 0);
  }

  /// Distance that a ball in contact can move before it may touch another patch [m], negative if
  /// none.
  double way_to_others(PieceGrid::Range candidates, Local at, double ball_radius, double reach,
                       const Minima& minima) const
  {
    double way = reach - ball_radius;
    for (const int k : candidates)
      way = std::min(way, way_to(candidates_[k], at, ball_radius, minima));
    for (int k = 0; k < minima.count; ++k)
      way = std::min(way, way_to_ends(minima.of_surface[k], at));
    return way;
  }

  /// Distance that a ball in contact can move before it may touch another piece instead of those
  /// found, or besides them, while their feet stay on the pieces [m].
  double way_to(const Candidate& c, Local at, double ball_radius, const Minima& minima) const
  {
    double nearest = INFINITY;  // of the surface
    for (int k = 0; k < minima.count; ++k) {
      const Minimum& minimum = minima.of_surface[k];
      if (shuts_out(minimum, c)) return INFINITY;
      if (minimum.candidate->surface == c.surface) nearest = minimum.distance;
    }
    // Of one surface the nearest counts. As one distance falls, the other rises no faster than the
    // centre moves.
    const double distance = distance_of(c, at);
    return std::max(distance - ball_radius, 0.5 * (distance - nearest));
  }

  /// Return whether the centre must cross an end of the minimum's piece, or leave its edge, before
  /// it projects onto a piece: the piece itself, and those that join it smoothly or at a convex
  /// edge.
  bool shuts_out(const Minimum& minimum, const Candidate& c) const
  {
    const Candidate& of = *minimum.candidate;
    if (&of == &c) return true;
    if (follows(of, c)) return minimum.at_edge || !(of.turn > 0.0);
    return !minimum.at_edge && !(c.turn > 0.0) && follows(c, of);
  }

  /// Return whether a piece begins where another ends.
  bool follows(const Candidate& c, const Candidate& before) const
  {
    const int pieces = static_cast<int>(profile_.pieces().size());
    const auto place = [pieces](const Candidate& of) { return pieces * of.offset + of.patch / 2; };
    return detail::wrapped(place(c) - place(before) - 1, pieces * profile_.sectors()) == 0;
  }

  /// Distance that a point can move before its foot reaches an end of the piece, or leaves the edge
  /// for a piece [m].
  static double way_to_ends(const Minimum& minimum, Local at)
  {
    const Candidate& c = *minimum.candidate;
    const Local gap = at - c.begin;
    if (minimum.at_edge) return std::min(-dot(gap, c.tangent), dot(gap, c.before));
    if (c.arc_radius == 0.0) {
      const double along = dot(gap, c.tangent);
      return std::min(along, c.length - along);
    }
    if (c.begin.radial == c.end.radial && c.begin.tangential == c.end.tangential)
      return INFINITY;  // a circle
    const Local arm = at - c.centre;
    const auto way = [&](Local end) {
      const Local ray = (1.0 / std::abs(c.arc_radius)) * (end - c.centre);
      return dot(arm, ray) > 0.0 ? std::abs(cross(arm, ray)) : length(arm);
    };
    return std::min(way(c.begin), way(c.end));
  }

  /// Distance of a point to a piece [m].
  static double distance_of(const Candidate& c, Local at)
  {
    if (c.arc_radius == 0.0) {
      const Local gap = at - c.begin;
      const double along = std::clamp(dot(gap, c.tangent), 0.0, c.length);
      return length(gap - along * c.tangent);
    }
    const Local arm = at - c.centre;
    const double from_centre = length(arm);
    if (dot(arm, c.middle) >= from_centre * c.cos_half_angle)
      return std::abs(from_centre - std::abs(c.arc_radius));
    return std::min(length(at - c.begin), length(at - c.end));
  }

  /// Return whether one list of the pieces near a sector is faster than a look-up.
  static bool is_short(const Profile& profile) { return profile.pieces().size() <= 4; }

  static PieceGrid::Range range(const std::vector<int>& list)
  {
    return {list.data(), list.data() + list.size()};
  }
  PieceGrid::Range near(Local at) const
  {
    return of_sector_.empty() ? grid_.near(at) : range(of_sector_);
  }

  /// Add the local minima on the pieces and on the convex edges where pieces begin. The ends of
  /// pieces reach a little too far, so that no point falls between two pieces. If two pieces claim
  /// a point, the nearer counts; both are of one surface.
  void search(PieceGrid::Range candidates, Local at, double ball_radius, Minima& minima) const
  {
    double nearest = INFINITY;
    for (const int k : candidates) {
      const Candidate& c = candidates_[k];
      const Local gap = at - c.begin;
      const double along = dot(gap, c.tangent);
      double distance;
      bool at_edge = false;
      if (c.arc_radius == 0.0) {
        if (along > c.length + slack_) continue;
        distance = cross(c.tangent, gap);
        at_edge = along < -slack_;
      } else {
        const Local arm = at - c.centre;
        const double from_centre = length(arm);
        distance = c.arc_radius > 0.0 ? c.arc_radius - from_centre : from_centre + c.arc_radius;
        at_edge = dot(arm, c.middle) < from_centre * c.cos_half_angle - slack_;
        if (at_edge && along >= 0.0) continue;
      }
      if (at_edge) {
        if (!(c.turn < 0.0) || dot(gap, c.before) < -slack_) continue;
        distance = length(gap);
      }
      const double size = std::abs(distance);
      if (size < nearest) {
        nearest = size;
        minima.nearest = {distance, &c, at_edge};
      }
      if (distance >= 0.0 && distance < ball_radius) minima.add({distance, &c, at_edge});
    }
  }

  void search_from_wall(Local at, double ball_radius, Minima& minima) const
  {
    minima = {};
    search(range(all_), at, ball_radius, minima);
    if (!(minima.nearest.distance < 0.0)) return;
    minima.count = 1;
    minima.of_surface[0] = minima.nearest;
  }

  /// Sector at most two ahead of another. Avoids a division, which takes as long as a search.
  int beside(int sector, int ahead) const
  {
    const int n = profile_.sectors();
    int k = sector + ahead;
    while (k >= n) k -= n;
    return k < 0 ? k + n : k;
  }

  /// Sector a point lies in, to single precision.
  int sector_of(Point p) const
  {
    const float angle = std::atan2(static_cast<float>(-p.x), static_cast<float>(-p.z));
    const double turns = (angle - phase_) * per_pitch_;  // at least -n
    const int n = profile_.sectors(), sector = static_cast<int>(turns + n + 0.5);
    return sector >= 2 * n ? sector - 2 * n : sector >= n ? sector - n : sector;
  }

  /// Set the sector that holds a point, and return the point in the sector's frame. The last sector
  /// is tried first, because an arc tangent costs as much as the rest of the search.
  Local settle(Point p, int& sector) const
  {
    const int n = profile_.sectors();
    if (n == 1) {
      sector = 0;
      return frames_[0].local(p);
    }
    if (sector < 0) sector = sector_of(p);
    Local at = frames_[sector].local(p);
    if (in_sector(at)) return at;
    sector = sector_of(p);
    at = frames_[sector].local(p);
    if (in_sector(at)) return at;
    // On the border of two sectors both sectors give the same contacts.
    sector = detail::wrapped(at.tangential > 0.0 ? sector + 1 : sector - 1, n);
    return frames_[sector].local(p);
  }

  bool in_sector(Local at) const
  {
    return std::abs(at.tangential) * cos_half_pitch_ <= at.radial * sin_half_pitch_;
  }

  Profile profile_;
  double reach_;  ///< pieces farther from a cell are not in its list [m]
  double usual_radius_;
  PieceGrid grid_;
  double slack_, phase_, per_pitch_, cos_half_pitch_, sin_half_pitch_;
  std::vector<Frame> frames_;  ///< of the sectors' centre lines
  std::vector<Patch> patches_;
  std::vector<Owner> owners_;          ///< of the patches
  std::vector<Candidate> candidates_;  ///< of the pieces around a sector
  std::vector<int> all_;               ///< indices of the candidates
  std::vector<int> of_sector_;  ///< those within reach of the sector, if there are few pieces
};

}  // namespace millscale::liner
