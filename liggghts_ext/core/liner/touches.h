#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/liner/nearest.h"
#include "core/liner/polygon.h"

namespace millscale::liner {

/// Chords for a wall, which counts all chords of a groove as one surface. That holds while two
/// neighbours' contacts lie within one Hertz patch, so for small folds; as in the engine's meshes
/// (`curvature`) a fold of 60 degrees is refused. Throws std::invalid_argument.
inline GrooveChords wall_chords(const Liner& liner, double chord_error)
{
  const GrooveChords chords = groove_chords(liner, chord_error);
  const double fold = 2.0 * chords.half_angle;
  if (chords.count > 1 && !(fold < pi / 3.0))
    detail::reject("chord error",
                   "gives " + std::to_string(chords.count) + " chords a groove that fold by " +
                       format(fold) + " rad; a wall takes folds < pi/3 rad, so chord errors < " +
                       format(liner.radius() * (1.0 - std::cos(pi / 6.0))) + " m",
                   chord_error);
  return chords;
}

/// Distance from the axis that no part of the liner falls below [m].
inline double clear_radius(const Liner& liner, const GrooveChords& chords)
{
  const double groove = chords.count > 0 ? chords.inner_radius : liner.radius();
  return liner.lifters() > 0 ? std::min(liner.lifter_top_radius(), groove) : groove;
}

/// A place where a ball touches the liner.
struct Touch {
  double overlap;  ///< > 0 [m]
  Face face;       ///< of a lifter's edge: its side
  int sector;      ///< of the groove, or of the lifter for its faces and top
  Point normal;    ///< from the liner to the ball's centre, unit vector
};

/// All touches of a ball, at most one of each: groove, the two sides of the groove, a top.
struct Touches {
  int count = 0;
  std::array<Touch, 4> touch;

  void add(const Touch& t) { touch[static_cast<std::size_t>(count++)] = t; }
};

/// What one look at a ball leaves for the next, so that most looks are short.
struct Look {
  int groove = -1;     ///< the centre was in the sector of this groove; -1: not known
  double clear = 0.0;  ///< way of the centre, in the mill's frame, that ends in no touch [m]; 0 of
                       ///< a ball that touches
};

/// Finds the touches of many balls with one liner, with exact arcs or the given chords: what does
/// not depend on the ball is worked out once.
class TouchFinder {
 public:
  explicit TouchFinder(const Liner& liner, const GrooveChords& chords = {})
      : liner_(liner),
        chords_(chords),
        clear_radius_(liner::clear_radius(liner, chords)),
        phase_(std::remainder(liner.phase(), 2.0 * pi)),
        per_pitch_(1.0 / liner.pitch()),
        cos_half_pitch_(std::cos(0.5 * liner.pitch())),
        sin_half_pitch_(std::sin(0.5 * liner.pitch())),
        arc_radius_(chords.count > 0 ? chords.inner_radius : liner.radius()),
        tan_half_groove_(std::tan(liner.groove_half_angle())),
        cos_face_(std::cos(liner.face_angle())),
        sin_face_(std::sin(liner.face_angle()))
  {
    for (int k = 0; k < std::max(liner.lifters(), 1); ++k) grooves_.emplace_back(groove_angle(k));
    if (liner.lifters() == 0) return;
    const Local foot = liner.foot(), corner = liner.corner();
    face_ = {foot.radial - corner.radial, foot.tangential - corner.tangential};
    face_square_ = face_.radial * face_.radial + face_.tangential * face_.tangential;
  }

  /// Distance from the axis that no part of the liner falls below [m].
  double clear_radius() const { return clear_radius_; }

  /// Where a ball of a radius [m] at a point of the cavity touches: one contact for each surface
  /// the centre projects onto, so two at the concave corner of groove and face, and the nearest
  /// point at a convex edge. The chords of a groove stand for one smooth arc and are one surface:
  /// the nearest counts. Counting each would double the force, at a jump, over every joint. `p` is
  /// in the frame of the mill at rest.
  Touches touches(Point p, double ball_radius) const
  {
    Look look;
    return touches(p, ball_radius, look);
  }

  /// The same, beginning with what the ball's last look left in `look`.
  Touches touches(Point p, double ball_radius, Look& look) const
  {
    Touches found;
    const double distance = std::sqrt(p.x * p.x + p.z * p.z), reach = clear_radius_ - ball_radius;
    if (reach > 0.0 && !(distance >= reach)) {  // nor does a NaN touch
      look.clear = reach - distance;
      return found;
    }
    const Local at = settle(p, look.groove);
    touch_groove(look.groove, at, p, distance, ball_radius, found);
    double gap = arc_radius_ - distance;
    if (liner_.lifters() > 0)
      for (const double mirror : {1.0, -1.0})
        gap = std::min(gap, touch_lifter(look.groove, mirror, at, ball_radius, found));
    look.clear = found.count > 0 ? 0.0 : std::max(0.0, gap - ball_radius);
    return found;
  }

 private:
  double groove_angle(int k) const { return liner_.groove_angle(k); }

  /// Groove a point lies in, to single precision.
  int groove_of(Point p) const
  {
    const float angle = std::atan2(static_cast<float>(-p.x), static_cast<float>(-p.z));
    const double turns = (angle - phase_) * per_pitch_;  // at least -n
    const int n = liner_.lifters(), groove = static_cast<int>(turns + n + 0.5);
    return groove >= 2 * n ? groove - 2 * n : groove >= n ? groove - n : groove;
  }

  /// Sets the groove whose sector holds a point, and returns the point in its frame. The one it was
  /// in is tried first: an arc tangent costs as much as all the rest.
  Local settle(Point p, int& groove) const
  {
    if (liner_.lifters() == 0) {
      groove = 0;
      return grooves_[0].local(p);
    }
    if (groove < 0) groove = groove_of(p);
    Local at = grooves_[groove].local(p);
    if (in_sector(at)) return at;
    groove = groove_of(p);
    at = grooves_[groove].local(p);
    if (in_sector(at)) return at;
    const int n = liner_.lifters(), beside = at.tangential > 0.0 ? groove + 1 : groove - 1;
    groove = detail::wrapped(beside, n);  // on the centre line of a lifter, both give the same
    return grooves_[groove].local(p);
  }

  bool in_sector(Local at) const
  {
    return std::abs(at.tangential) * cos_half_pitch_ <= at.radial * sin_half_pitch_;
  }

  void touch_groove(int groove, Local at, Point p, double distance, double ball_radius,
                    Touches& found) const
  {
    if (chords_.count > 0) {
      touch_chord(groove, at, ball_radius, found);
      return;
    }
    const double overlap = distance - (liner_.radius() - ball_radius);
    const bool in_arc =
        liner_.lifters() == 0 || std::abs(at.tangential) <= tan_half_groove_ * at.radial;
    if (overlap > 0.0 && in_arc)
      found.add({overlap, Face::groove, groove, {-p.x / distance, -p.z / distance}});
  }

  /// The nearest chord of the groove, where the centre projects onto it. The nearest one is that of
  /// the centre's angle, since all middles have the same distance from the axis.
  void touch_chord(int groove, Local at, double ball_radius, Touches& found) const
  {
    const double half_groove = liner_.groove_half_angle(), chord_angle = 2.0 * chords_.half_angle;
    const double angle = std::atan2(at.tangential, at.radial);
    const double distance = std::hypot(at.radial, at.tangential);
    const int chord = std::clamp(static_cast<int>(std::floor((angle + half_groove) / chord_angle)),
                                 0, chords_.count - 1);
    const double middle = (chord + 0.5) * chord_angle - half_groove;
    const double beside = distance * std::sin(angle - middle);
    const double overlap =
        ball_radius - (chords_.inner_radius - distance * std::cos(angle - middle));
    if (!(overlap > 0.0) || std::abs(beside) > liner_.radius() * std::sin(chords_.half_angle))
      return;
    const Frame frame(liner_.groove_angle(groove) + middle);
    found.add({overlap, Face::groove, groove, frame.point({-1.0, 0.0})});
  }

  /// The lifter behind the groove (mirror = 1) or ahead of it (-1): its face where the centre
  /// projects onto it, the convex edge at its top, or the top. Works in the frame of the lifter's
  /// centre line with the tangential axis towards the groove. Returns the centre's distance from
  /// the lifter, or less, beyond the foot of its face [m].
  double touch_lifter(int groove, double mirror, Local at, double ball_radius, Touches& found) const
  {
    const double t = mirror * at.tangential;
    const Local p{at.radial * cos_half_pitch_ - t * sin_half_pitch_,
                  at.radial * sin_half_pitch_ + t * cos_half_pitch_};
    const Local corner = liner_.corner();
    const Local gap{p.radial - corner.radial, p.tangential - corner.tangential};
    const double along = gap.radial * face_.radial + gap.tangential * face_.tangential;
    const int lifter =
        detail::wrapped(mirror > 0.0 ? groove : groove + 1, static_cast<int>(grooves_.size()));
    const auto add = [&](double overlap, Face face, Local normal) {
      const double radial = normal.radial * cos_half_pitch_ + normal.tangential * sin_half_pitch_;
      const double across = normal.tangential * cos_half_pitch_ - normal.radial * sin_half_pitch_;
      found.add({overlap, face, lifter, grooves_[groove].point({radial, mirror * across})});
    };
    const Face side = mirror > 0.0 ? Face::leading : Face::trailing;
    if (along < 0.0 && gap.tangential > 0.0) {
      const double distance = std::sqrt(gap.radial * gap.radial + gap.tangential * gap.tangential);
      if (distance < ball_radius)
        add(ball_radius - distance, side, {gap.radial / distance, gap.tangential / distance});
      return distance;
    }
    const double from_face = gap.tangential * cos_face_ - gap.radial * sin_face_;
    if (along >= 0.0 && along <= face_square_ && from_face < ball_radius) {
      add(ball_radius - from_face, side, {-sin_face_, cos_face_});
      return from_face;
    }
    if (gap.tangential > 0.0) return from_face;
    if (gap.radial > -ball_radius) add(ball_radius + gap.radial, Face::top, {-1.0, 0.0});
    return -gap.radial;
  }

  Liner liner_;
  GrooveChords chords_;
  double clear_radius_, phase_, per_pitch_, cos_half_pitch_, sin_half_pitch_, arc_radius_,
      tan_half_groove_, cos_face_, sin_face_;
  std::vector<Frame> grooves_;  ///< of the centres of the grooves
  Local face_{0.0, 0.0};        ///< from corner to foot
  double face_square_ = 0.0;
};

inline Touches touches(const Liner& liner, Point p, double ball_radius,
                       const GrooveChords& chords = {})
{
  return TouchFinder(liner, chords).touches(p, ball_radius);
}

}  // namespace millscale::liner
