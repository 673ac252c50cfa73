#pragma once

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "core/liner/frame.h"
#include "core/math/format.h"

namespace millscale::liner {

inline constexpr double pi = 3.14159265358979323846;

/// More than any mill has; what is kept of each lifter stays small.
inline constexpr int most_lifters = 10'000;

/// What a piece of the liner is. The leading face of a lifter pushes the balls of its groove.
enum class Face { groove = 0, leading = 1, top = 2, trailing = 3 };

/// Cross-section by its widths, the trapezoid reading of D1 and D2 (Powder Technology 335 (2018)
/// 91-102, Fig. 5): the face is the line from the foot, at the liner, to the corner of the top.
struct Widths {
  double radius = 0.0;             ///< R, of the groove arcs [m]
  double lifter_top_radius = 0.0;  ///< r, from the axis to the middle of a lifter's flat top [m]
  double lifter_top_width = 0.0;   ///< D1 [m]
  double groove_width = 0.0;       ///< D2, chord of a groove between the feet of its lifters [m]
  int lifters = 0;                 ///< 0: a plain drum, all widths but the radius 0
  double phase = 0.0;              ///< polar angle of the centre of groove 0 at rest [rad]
};

/// Cross-section by the lifters' shape; the groove width follows. Face angle 0 is the parallel
/// reading: D1 is the width of the lifter all the way down.
struct Slopes {
  double radius = 0.0;             ///< R, of the groove arcs [m]
  double lifter_top_radius = 0.0;  ///< r, from the axis to the middle of a lifter's flat top [m]
  double lifter_top_width = 0.0;   ///< D1 [m]
  double face_angle = 0.0;         ///< between a face and the lifter's centre line, >= 0 [rad]
  int lifters = 0;                 ///< 0: a plain drum, all others but the radius 0
  double phase = 0.0;              ///< polar angle of the centre of groove 0 at rest [rad]
};

/// Validated cross-section of the mill's liner: n equal lifters on a circle, grooves between them.
///
/// Groove k = 0..n-1 is centred at polar angle 2 pi k / n + phase, and lifter k, which trails it
/// and pushes its balls, half a pitch before. Faces do not lean over the groove (no undercut), so r
/// is the liner's smallest radius. A plain drum has no lifters and one groove, 0, all around.
class Liner {
 public:
  /// Throws std::invalid_argument with the value and the accepted range if no such liner exists.
  explicit Liner(const Widths& widths);
  explicit Liner(const Slopes& slopes);

  double radius() const { return radius_; }
  double lifter_top_radius() const { return top_radius_; }
  double lifter_top_width() const { return 2.0 * half_top_; }
  double groove_width() const { return groove_width_; }
  int lifters() const { return lifters_; }
  double phase() const { return phase_; }
  double face_angle() const { return face_angle_; }

  /// Angle from lifter to lifter; 2 pi for a plain drum [rad].
  double pitch() const { return 2.0 * pi / std::max(lifters_, 1); }
  /// Half the angle a groove arc spans; pi for a plain drum [rad].
  double groove_half_angle() const { return groove_half_angle_; }
  /// Half the angle a lifter spans at its foot; 0 for a plain drum [rad].
  double foot_half_angle() const { return 0.5 * pitch() - groove_half_angle_; }

  /// Polar angle of the centre of groove k [rad].
  double groove_angle(int k) const { return phase_ + pitch() * k; }
  /// Polar angle of the centre line of lifter k [rad].
  double lifter_angle(int k) const { return phase_ + pitch() * (k - 0.5); }

  /// Foot and top corner of a lifter's leading face, in the frame of its centre line. Those of the
  /// trailing face mirror them.
  Local foot() const
  {
    return {radius_ * std::cos(foot_half_angle()), radius_ * std::sin(foot_half_angle())};
  }
  Local corner() const { return {top_radius_, half_top_}; }

 private:
  double radius_, top_radius_ = 0.0, half_top_ = 0.0, groove_width_ = 0.0;
  int lifters_;
  double phase_, face_angle_ = 0.0, groove_half_angle_ = pi;
};

namespace detail {

[[noreturn]] inline void reject(const char* what, const std::string& accepted, double got)
{
  throw std::invalid_argument(std::string(what) + ": " + accepted + ", got " + format(got));
}

inline void require_finite(const char* what, double value)
{
  if (!std::isfinite(value)) reject(what, "must be a finite number", value);
}

inline std::string between(double low, double high, const char* unit)
{
  return "must be > " + format(low) + " and < " + format(high) + " " + unit;
}

inline void require_between(const char* what, double low, double high, double got,
                            const char* reason)
{
  if (!(got > low && got < high)) reject(what, between(low, high, "m") + " (" + reason + ")", got);
}

/// Checks what both readings share: radius, number of lifters, their tops.
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
  if (lifters < 0 || lifters == 1 || lifters > most_lifters)
    reject("lifters", "must be 0 (a plain drum), or 2 to " + std::to_string(most_lifters), lifters);
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

}  // namespace detail

inline Liner::Liner(const Widths& w) : radius_(w.radius), lifters_(w.lifters), phase_(w.phase)
{
  detail::check_drum(w.radius, w.lifters, w.phase);
  if (lifters_ == 0) {
    detail::require_zero("lifter top radius", w.lifter_top_radius);
    detail::require_zero("lifter top width", w.lifter_top_width);
    detail::require_zero("groove width", w.groove_width);
    return;
  }
  detail::check_tops(w.radius, w.lifter_top_radius, w.lifter_top_width, w.lifters);
  detail::check_groove_width(w);
  top_radius_ = w.lifter_top_radius;
  half_top_ = 0.5 * w.lifter_top_width;
  groove_width_ = w.groove_width;
  groove_half_angle_ = std::asin(0.5 * groove_width_ / radius_);

  // A width computed from parallel sides may miss the limit by rounding.
  const double rounding = 1e-12 * radius_;
  const double undercut = foot().tangential - half_top_;
  if (undercut < -rounding)
    detail::reject(
        "groove width",
        "must be <= " +
            format(2.0 * radius_ * std::sin(pi / lifters_ - std::asin(half_top_ / radius_))) +
            " m, or the lifter is narrower at its foot than at its top (undercut faces)",
        groove_width_);
  if (!(foot().radial > top_radius_))
    detail::reject(
        "groove width",
        "must be > " +
            format(2.0 * radius_ * std::sin(pi / lifters_ - std::acos(top_radius_ / radius_))) +
            " m, or the lifter's top lies below the chord of its foot",
        groove_width_);
  face_angle_ = std::atan2(std::max(undercut, 0.0), foot().radial - top_radius_);
}

inline Liner::Liner(const Slopes& s) : radius_(s.radius), lifters_(s.lifters), phase_(s.phase)
{
  detail::check_drum(s.radius, s.lifters, s.phase);
  if (lifters_ == 0) {
    detail::require_zero("lifter top radius", s.lifter_top_radius);
    detail::require_zero("lifter top width", s.lifter_top_width);
    detail::require_zero("face angle", s.face_angle);
    return;
  }
  detail::check_tops(s.radius, s.lifter_top_radius, s.lifter_top_width, s.lifters);
  if (!(s.face_angle >= 0.0 && s.face_angle < 0.5 * pi))
    detail::reject("face angle",
                   "must be >= 0 and < pi/2 rad from the lifter's centre line (no undercut faces)",
                   s.face_angle);
  top_radius_ = s.lifter_top_radius;
  half_top_ = 0.5 * s.lifter_top_width;
  face_angle_ = s.face_angle;

  // The foot is where the face meets the liner's circle.
  const double along = std::cos(face_angle_), across = std::sin(face_angle_);
  const double projection = top_radius_ * along + half_top_ * across;
  const double height = -projection + std::sqrt(projection * projection + radius_ * radius_ -
                                                top_radius_ * top_radius_ - half_top_ * half_top_);
  const double foot = std::atan2(half_top_ + height * across, top_radius_ + height * along);
  groove_half_angle_ = pi / lifters_ - foot;
  if (!(groove_half_angle_ > 0.0)) {
    const double steepest = std::atan2(radius_ * std::sin(pi / lifters_) - half_top_,
                                       radius_ * std::cos(pi / lifters_) - top_radius_);
    detail::reject("face angle",
                   "must be < " + format(steepest) + " rad, or the lifters overlap at the foot",
                   face_angle_);
  }
  groove_width_ = 2.0 * radius_ * std::sin(groove_half_angle_);
}

}  // namespace millscale::liner
