#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "core/liner/profile.h"

namespace millscale::liner {

/// A part of the profile of one sector.
struct ArcBin {
  double begin, end;  ///< arc length from the first node of the sector [m]
  Face face;
  int groove;             ///< as in Piece
  Local middle, tangent;  ///< the point in the middle [m], unit vector along the profile there
};

/// Bins of arc length along the profile of one sector, in the direction of rotation. A bin never
/// reaches over the border of two faces. The bins of one face are equally wide.
class ArcBins {
 public:
  /// Bins of about a `count`-th of the profile's length; a face has one or more.
  ArcBins(const Profile& profile, int count) : pieces_(profile.pieces().size())
  {
    for (const Piece& piece : profile.pieces()) length_ += piece.length;
    const double width = length_ / count;
    double before = 0.0;
    for (std::size_t i = 0; i < pieces_;) {
      std::size_t end = i;
      double run = 0.0;
      for (; end < pieces_ && same_face(profile.pieces()[i], profile.pieces()[end]); ++end)
        run += profile.pieces()[end].length;
      const int bins = std::max(1, static_cast<int>(std::lround(run / width)));
      add_face(profile, i, end, before, run / bins, bins);
      before += run;
      i = end;
    }
    make_tracks(profile);
  }

  const std::vector<ArcBin>& bins() const { return bins_; }
  int count() const { return static_cast<int>(bins_.size()); }
  /// Length of the profile of one sector [m].
  double length() const { return length_; }

  /// Where a contact is.
  struct Place {
    int sector, bin;
  };

  /// Return the place of the contact of a ball with a patch of a ContactFinder. centre: of the
  /// ball, in the frame of the mill at rest. A contact with an edge belongs to the nearer face.
  Place place(int patch, Point centre) const
  {
    const Track& track = tracks_[static_cast<std::size_t>(patch) / 2];
    const Point arm = centre - track.from;
    if (patch % 2 != 0) {
      const Point gap = centre - track.edge;
      return crossed(track.bisector, gap) < 0.0 ? Place{track.sector, track.edge_bin}
                                                : track.before_edge;
    }
    const double along =
        track.arc_radius == 0.0
            ? arm.x * track.towards.x + arm.z * track.towards.z
            : track.half_length +
                  track.arc_radius * std::atan2(crossed(track.towards, arm),
                                                arm.x * track.towards.x + arm.z * track.towards.z);
    return {track.sector, track.bin_at(along)};
  }

 private:
  /// A face of one lifter: pieces that follow each other.
  struct FaceBins {
    double begin, per_length;  ///< arc length where it begins [m], bins per length [1/m]
    int first, count;          ///< of its bins
  };

  /// A piece of a sector in the frame of the mill at rest, and the edge where it begins.
  struct Track {
    Point from, towards;  ///< begin and tangent of a line, or centre and middle of an arc
    double arc_radius;    ///< as in Node [m]
    double half_length;   ///< of an arc [m]
    double offset;        ///< arc length from the begin of its face to that of the piece [m]
    FaceBins face;
    int sector;
    Point edge, bisector;  ///< the begin of the piece; sum of the normals of both pieces there
    int edge_bin;          ///< bin where the piece begins
    Place before_edge;     ///< where the piece before ends

    int bin_at(double along) const
    {
      const int bin = static_cast<int>((offset + along) * face.per_length);
      return face.first + std::clamp(bin, 0, face.count - 1);
    }
  };

  static bool same_face(const Piece& a, const Piece& b)
  {
    return a.face == b.face && a.groove == b.groove;
  }

  /// Cross product as of Local, whose directions in a cross-section seen along the axis are those
  /// of the other hand.
  static double crossed(Point a, Point b) { return a.z * b.x - a.x * b.z; }

  void add_face(const Profile& profile, std::size_t first, std::size_t end, double begin,
                double width, int count)
  {
    const FaceBins face{begin, 1.0 / width, this->count(), count};
    const Piece& piece = profile.pieces()[first];
    for (std::size_t i = first; i < end; ++i) faces_.push_back(face);
    for (int k = 0; k < count; ++k) {
      const double from = begin + k * width;
      bins_.push_back({from, from + width, piece.face, piece.groove, {}, {}});
      set_middle(profile, first, (k + 0.5) * width);
    }
  }

  /// Set the middle of the last bin, at an arc length from the begin of a piece.
  void set_middle(const Profile& profile, std::size_t i, double along)
  {
    for (; along > profile.pieces()[i].length && i + 1 < pieces_; ++i)
      along -= profile.pieces()[i].length;
    const Piece& piece = profile.pieces()[i];
    ArcBin& bin = bins_.back();
    if (!piece.is_arc()) {
      bin.middle = piece.begin + along * piece.tangent_begin;
      bin.tangent = piece.tangent_begin;
      return;
    }
    const double angle = along / piece.arc_radius;
    bin.middle = piece.centre + turned(piece.begin - piece.centre, angle);
    bin.tangent = turned(piece.tangent_begin, angle);
  }

  void make_tracks(const Profile& profile)
  {
    const int sectors = profile.sectors();
    for (int sector = 0; sector < sectors; ++sector) {
      const Frame frame(profile.sector_angle(sector));
      double before = 0.0;
      for (std::size_t i = 0; i < pieces_; ++i) {
        const Piece& piece = profile.pieces()[i];
        Track track{};
        track.arc_radius = piece.arc_radius;
        track.half_length = 0.5 * piece.length;
        track.from = frame.point(piece.is_arc() ? piece.centre : piece.begin);
        track.towards = frame.point(piece.is_arc() ? piece.middle : piece.tangent_begin);
        track.face = faces_[i];
        track.offset = before - track.face.begin;
        track.sector = sector;
        track.edge = frame.point(piece.begin);
        const Local normal = left_of(piece.tangent_begin);
        track.bisector = frame.point(normal + turned(normal, -piece.turn));
        track.edge_bin = track.bin_at(0.0);
        tracks_.push_back(track);
        before += piece.length;
      }
    }
    const auto all = tracks_.size();
    for (std::size_t k = 0; k < all; ++k) {
      const Track& behind = tracks_[(k + all - 1) % all];
      const double length = profile.pieces()[(k + pieces_ - 1) % pieces_].length;
      tracks_[k].before_edge = {behind.sector, behind.bin_at(length)};
    }
  }

  std::size_t pieces_;
  double length_ = 0.0;
  std::vector<ArcBin> bins_;
  std::vector<FaceBins> faces_;  ///< of the pieces
  std::vector<Track> tracks_;    ///< of the pieces of all sectors
};

}  // namespace millscale::liner
