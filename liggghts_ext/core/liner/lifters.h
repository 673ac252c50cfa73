#pragma once

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/liner/profile.h"

namespace millscale::liner {

/// Cross-section by its widths, the trapezoid reading of D1 and D2 (Powder Technology 335 (2018)
/// 91-102, Fig. 5). The face is the line from the foot, at the liner, to the corner of the top.
struct Widths {
  double radius = 0.0;             ///< R, of the groove arcs [m]
  double lifter_top_radius = 0.0;  ///< r, from the axis to the middle of a lifter's flat top [m]
  double lifter_top_width = 0.0;   ///< D1 [m]
  double groove_width = 0.0;       ///< D2, chord of a groove between the feet of its lifters [m]
  int lifters = 0;                 ///< 0: a plain drum, all widths but the radius 0
  double phase = 0.0;              ///< polar angle of the centre of groove 0 at rest [rad]
};

/// Cross-section by the lifters' shape, from which the groove width follows. Face angle 0 is the
/// parallel reading: the lifter has width D1 over its whole height.
struct Slopes {
  double radius = 0.0;             ///< R, of the groove arcs [m]
  double lifter_top_radius = 0.0;  ///< r, from the axis to the middle of a lifter's flat top [m]
  double lifter_top_width = 0.0;   ///< D1 [m]
  double face_angle = 0.0;         ///< between a face and the lifter's centre line, >= 0 [rad]
  int lifters = 0;                 ///< 0: a plain drum, all others but the radius 0
  double phase = 0.0;              ///< polar angle of the centre of groove 0 at rest [rad]
};

namespace detail {

/// Check what both readings share: radius, number of lifters and lifter tops.
inline void check_tops(double radius, double top_radius, double top_width, int lifters)
{
  const double half_pitch = pi / lifters;
  require_between("lifter top radius", 0.0, radius, top_radius, "the axis and the liner");
  const double inside_circle = 2.0 * std::sqrt(radius * radius - top_radius * top_radius);
  const double inside_sector = 2.0 * top_radius * std::tan(half_pitch);
  require_between("lifter top width", 0.0, std::min(inside_circle, inside_sector), top_width,
                  "the top stays inside the liner and clear of the next lifter's");
}

inline void check_drum(double radius, int lifters, double phase)
{
  require_finite("liner radius", radius);
  if (!(radius > 0.0)) reject("liner radius", "must be > 0 m", radius);
  require_finite("phase", phase);
  if (lifters < 0 || lifters == 1 || lifters > most_sectors)
    reject("lifters", "must be 0 (a plain drum), or 2 to " + std::to_string(most_sectors), lifters);
}

inline void require_zero(const char* what, double value)
{
  if (value != 0.0) reject(what, "must be 0 in a plain drum (lifters = 0)", value);
}

/// Range of the groove width for lifters that neither lean over the groove nor sink into the liner.
inline void check_groove_width(const Widths& w)
{
  const double half_pitch = pi / w.lifters;
  const double touching = 2.0 * w.radius * std::sin(half_pitch);
  if (!(w.groove_width > 0.0))
    reject("groove width", between(0.0, touching, "m") + " (at 0 the lifters overlap at the foot)",
           w.groove_width);
  if (w.groove_width >= touching)
    reject("groove width",
           "must be < 2 R sin(pi / n) = " + format(touching) + " m for " +
               std::to_string(w.lifters) + " grooves to fit on the circle",
           w.groove_width);
}

/// Dimensions of a validated cross-section.
struct LifterShape {
  double radius, top_radius = 0.0, half_top = 0.0, groove_width = 0.0;
  int lifters;
  double phase, face_angle = 0.0, groove_half_angle = pi;

  explicit LifterShape(const Widths& w) : radius(w.radius), lifters(w.lifters), phase(w.phase)
  {
    check_drum(w.radius, w.lifters, w.phase);
    if (lifters == 0) {
      require_zero("lifter top radius", w.lifter_top_radius);
      require_zero("lifter top width", w.lifter_top_width);
      require_zero("groove width", w.groove_width);
      return;
    }
    check_tops(w.radius, w.lifter_top_radius, w.lifter_top_width, w.lifters);
    check_groove_width(w);
    top_radius = w.lifter_top_radius;
    half_top = 0.5 * w.lifter_top_width;
    groove_width = w.groove_width;
    groove_half_angle = std::asin(0.5 * groove_width / radius);

    // A width computed from parallel sides may miss the limit by rounding.
    const double rounding = 1e-12 * radius;
    const double undercut = foot().tangential - half_top;
    if (undercut < -rounding)
      reject("groove width",
             "must be <= " +
                 format(2.0 * radius * std::sin(pi / lifters - std::asin(half_top / radius))) +
                 " m, or the lifter is narrower at its foot than at its top (undercut faces)",
             groove_width);
    if (!(foot().radial > top_radius))
      reject("groove width",
             "must be > " +
                 format(2.0 * radius * std::sin(pi / lifters - std::acos(top_radius / radius))) +
                 " m, or the lifter's top lies below the chord of its foot",
             groove_width);
    face_angle = std::atan2(std::max(undercut, 0.0), foot().radial - top_radius);
  }

  explicit LifterShape(const Slopes& s) : radius(s.radius), lifters(s.lifters), phase(s.phase)
  {
    check_drum(s.radius, s.lifters, s.phase);
    if (lifters == 0) {
      require_zero("lifter top radius", s.lifter_top_radius);
      require_zero("lifter top width", s.lifter_top_width);
      require_zero("face angle", s.face_angle);
      return;
    }
    check_tops(s.radius, s.lifter_top_radius, s.lifter_top_width, s.lifters);
    if (!(s.face_angle >= 0.0 && s.face_angle < 0.5 * pi))
      reject("face angle",
             "must be >= 0 and < pi/2 rad from the lifter's centre line (no undercut faces)",
             s.face_angle);
    top_radius = s.lifter_top_radius;
    half_top = 0.5 * s.lifter_top_width;
    face_angle = s.face_angle;

    // The foot is where the face meets the liner's circle.
    const double along = std::cos(face_angle), across = std::sin(face_angle);
    const double projection = top_radius * along + half_top * across;
    const double height = -projection + std::sqrt(projection * projection + radius * radius -
                                                  top_radius * top_radius - half_top * half_top);
    const double foot = std::atan2(half_top + height * across, top_radius + height * along);
    groove_half_angle = pi / lifters - foot;
    if (!(groove_half_angle > 0.0)) {
      const double steepest = std::atan2(radius * std::sin(pi / lifters) - half_top,
                                         radius * std::cos(pi / lifters) - top_radius);
      reject("face angle",
             "must be < " + format(steepest) + " rad, or the lifters overlap at the foot",
             face_angle);
    }
    groove_width = 2.0 * radius * std::sin(groove_half_angle);
  }

  /// Half the angle a lifter spans at its foot [rad].
  double foot_half_angle() const { return pi / std::max(lifters, 1) - groove_half_angle; }
  Local foot() const
  {
    return {radius * std::cos(foot_half_angle()), radius * std::sin(foot_half_angle())};
  }

  /// A sector from the trailing corner of its lifter over the lifter's top, leading face and the
  /// groove to the next lifter's corner.
  std::vector<Node> nodes() const
  {
    if (lifters == 0) return {Node{{-radius, 0.0}, radius}};
    const double half_pitch = pi / lifters;
    const double x = radius * std::cos(groove_half_angle), y = radius * std::sin(groove_half_angle);
    const Local corner{top_radius, half_top}, mirrored{top_radius, -half_top};
    return {Node{turned(mirrored, -half_pitch), 0.0, Face::top},
            Node{turned(corner, -half_pitch), 0.0, Face::leading},
            Node{{x, -y}, radius, Face::groove}, Node{{x, y}, 0.0, Face::trailing, 1}};
  }
};

}  // namespace detail

/// The liner of n equal trapezoidal lifters on a circle, with grooves between them, or a plain
/// drum.
///
/// Groove k = 0..n-1 is centred at polar angle 2 pi k / n + phase. Lifter k is half a pitch behind
/// groove k and lifts the groove's balls. Faces do not lean over the groove (no undercut), so r is
/// the liner's smallest radius. A plain drum has no lifters and a single groove, 0, all around.
class Lifters : public Profile {
 public:
  /// Throws std::invalid_argument with the value and the accepted range if no such liner exists.
  explicit Lifters(const Widths& widths) : Lifters(detail::LifterShape(widths)) {}
  explicit Lifters(const Slopes& slopes) : Lifters(detail::LifterShape(slopes)) {}

  double lifter_top_radius() const { return shape_.top_radius; }
  double lifter_top_width() const { return 2.0 * shape_.half_top; }
  double groove_width() const { return shape_.groove_width; }
  int lifters() const { return shape_.lifters; }
  double face_angle() const { return shape_.face_angle; }
  Widths widths() const
  {
    return {shape_.radius,       lifter_top_radius(), lifter_top_width(),
            shape_.groove_width, shape_.lifters,      shape_.phase};
  }

  /// Half the angle a groove arc spans; pi for a plain drum [rad].
  double groove_half_angle() const { return shape_.groove_half_angle; }
  /// Half the angle a lifter spans at its foot; 0 for a plain drum [rad].
  double foot_half_angle() const { return shape_.foot_half_angle(); }

  /// Polar angle of the centre of groove k [rad].
  double groove_angle(int k) const { return sector_angle(k); }
  /// Polar angle of the centre line of lifter k [rad].
  double lifter_angle(int k) const { return phase() + pitch() * (k - 0.5); }

  /// Foot and top corner of a lifter's leading face, in the frame of the lifter's centre line. The
  /// trailing face is its mirror image.
  Local foot() const { return shape_.foot(); }
  Local corner() const { return {shape_.top_radius, shape_.half_top}; }

 private:
  explicit Lifters(const detail::LifterShape& shape)
      : Profile(shape.nodes(), std::max(shape.lifters, 1), shape.phase), shape_(shape)
  {
  }

  detail::LifterShape shape_;
};

}  // namespace millscale::liner
