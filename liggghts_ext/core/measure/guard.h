#pragma once

#include <cmath>
#include <cstddef>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "core/liner/contacts.h"
#include "core/liner/nearest.h"
#include "core/math/format.h"
#include "core/math/vector.h"
#include "core/similarity/operating_point.h"

namespace millscale::charge {

/// Return twice the speed that a ball can reach without an impact of another ball [m/s]: 2 sqrt((2
/// omega R)^2 + 4 g R).
///
/// Derived here. The wall moves at omega R or less, so an elastic impact gives a ball at most 2
/// omega R. From the top of the mill the ball falls by 2 R at most. A ball at rest hit by a much
/// heavier ball of this speed leaves at (1 + e) times that speed, hence the factor 2. Chains of
/// impacts among balls of very different sizes could exceed the limit; no measured speed is near
/// it.
inline double plausible_speed(const similarity::OperatingPoint& mill)
{
  const double thrown = 2.0 * mill.omega * mill.radius;
  return 2.0 * std::sqrt(thrown * thrown + 4.0 * mill.gravity * mill.radius);
}

/// Index of the first of `count` vectors, 3 numbers each, that is NaN or longer than a limit;
/// `count` if none is.
///
/// One sum checks a whole block. A vector longer than the limit has numbers x whose sum of (x /
/// limit)^8 exceeds 1 / 27, and a NaN makes the sum NaN. Ordinary speeds, far below the limit,
/// hardly add to the sum. The sum is kept in lanes, so that the compiler adds several numbers at
/// once.
inline std::size_t first_beyond(const double* vectors, std::size_t count, double limit)
{
  constexpr std::size_t lanes = 8, block = 64;
  const double scale = 1.0 / (limit * limit);
  for (std::size_t begin = 0; begin < count; begin += block) {
    const std::size_t end = begin + block < count ? begin + block : count;
    double sum[lanes] = {};
    std::size_t k = 3 * begin;
    for (; k + lanes <= 3 * end; k += lanes)
      for (std::size_t lane = 0; lane < lanes; ++lane) {
        const double second = vectors[k + lane] * vectors[k + lane] * scale;
        sum[lane] += second * second * second * second;
      }
    for (; k < 3 * end; ++k) sum[0] += std::pow(vectors[k] * vectors[k] * scale, 4);
    double all = 0.0;
    for (const double s : sum) all += s;
    if (all < 0.999 / 27.0) continue;
    for (std::size_t i = begin; i < end; ++i) {
      const double* v = vectors + 3 * i;
      if (!(v[0] * v[0] + v[1] * v[1] + v[2] * v[2] <= limit * limit)) return i;
    }
  }
  return count;
}

inline bool finite(const Vector& v)
{
  return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
}

/// The ball that an error message names.
struct Suspect {
  long id;
  Vector position, velocity, force;  ///< [m], [m/s], [N]
};

/// Check balls near the liner, and name the part of the mill at a point.
class WallGuard {
 public:
  /// usual_radius: ball radius [m]; overlap_limit: of a ball and the wall, in ball radii.
  WallGuard(const liner::Profile& profile, double usual_radius, double overlap_limit)
      : finder_(profile, usual_radius), limit_(overlap_limit)
  {
  }

  /// Return whether a ball with the given radius [m] and squared distance from the axis [m^2] can
  /// neither touch the liner nor be beyond it. Return false for NaN.
  bool clear(double distance_squared, double radius) const
  {
    const double reach = finder_.clear_radius() - radius;
    return reach > 0.0 && distance_squared < reach * reach;
  }

  /// Fault of a ball with the given radius [m] at a point of the cross-section of the mill at rest.
  std::optional<std::string> fault(liner::Point p, double radius) const
  {
    const double square = p.x * p.x + p.z * p.z;
    if (clear(square, radius)) return std::nullopt;
    if (!std::isfinite(square)) return "has no finite position";
    if (!finder_.inside(p))
      return "is outside the mill, its centre " + format(-liner::nearest(profile(), p).distance) +
             " m beyond " + where(p);
    const double deepest = largest_overlap(p, radius);
    if (!(deepest > limit_ * radius)) return std::nullopt;
    return "overlaps " + where(p) + " by " + format(deepest / radius) +
           " of its radius, the limit is " + format(limit_);
  }

  /// Return whether a point is beyond the liner or in the outer fifth of the mill.
  bool near(liner::Point p) const
  {
    return !(p.x * p.x + p.z * p.z < 0.64 * profile().radius() * profile().radius());
  }

  /// The part of the liner nearest to a point.
  std::string where(liner::Point p) const
  {
    if (!std::isfinite(p.x) || !std::isfinite(p.z)) return "an unknown wall";
    if (profile().is_drum()) return "the drum";
    const liner::Nearest nearest = liner::nearest(profile(), p);
    const std::string number = " " + std::to_string(nearest.sector);
    switch (nearest.face) {
      case liner::Face::groove:
        return "groove" + number;
      case liner::Face::leading:
        return "the leading face of lifter" + number;
      case liner::Face::trailing:
        return "the trailing face of lifter" + number;
      default:
        return "the top of lifter" + number;
    }
  }

 private:
  double largest_overlap(liner::Point p, double radius) const
  {
    const liner::Contacts found = finder_.contacts(p, radius);
    double deepest = 0.0;
    for (int c = 0; c < found.count; ++c)
      deepest = std::fmax(deepest, found.contact[static_cast<std::size_t>(c)].overlap);
    return deepest;
  }

  const liner::Profile& profile() const { return finder_.profile(); }

  liner::ContactFinder finder_;
  double limit_;
};

inline std::string text(const Vector& v)
{
  return "(" + format(v[0]) + ", " + format(v[1]) + ", " + format(v[2]) + ")";
}

/// Possible causes of a fault, as far as the rank that found it knows them.
struct Circumstances {
  bool walls = true;           ///< there is a wall
  bool compared = true;        ///< the wall is known to have the mill's radius
  bool past_open_end = false;  ///< the ball is beyond an end of the mill without a wall
  bool hole = false;           ///< the mesh has no triangle in the direction of the ball
  double wobble = 0.0;         ///< of the mesh, in radii of the mill
  double bed_overlap = 0.0;    ///< of balls that carry a bed as deep as the radius, in ball radii
  double step = 0.0;           ///< in Rayleigh times of the ball; 0: not known
};

inline std::string about(double x)
{
  char words[32];
  std::snprintf(words, sizeof words, "%.2g", x);
  return words;
}

/// Causes, each with its remedy, the likeliest first. Missing or mismatched parts come first, then
/// quantities beyond their usual range, the largest excess first. The words `overlap` and `outside`
/// name the fault itself. They are not used here, because failures are classified by them.
inline std::vector<std::string> causes(const Circumstances& c)
{
  std::vector<std::string> found;
  const auto add = [&found](bool so, const std::string& words) {
    if (so) found.push_back(words);
  };
  add(!c.walls, "no wall holds the balls (fix wall/mill, or fix wall/gran with the mesh)");
  add(c.past_open_end,
      "no wall closes this end of the mill (`ends` of fix wall/mill, an end in the mesh, or a box "
      "that is periodic along the axis)");
  add(c.hole, "a hole in the mesh: in this direction from the axis it has no triangle");
  add(!c.compared,
      "a mesh of another radius than the mill's (name it as `mesh` of fix mill/similarity, which "
      "compares them)");
  add(c.wobble > 1e-3, "a mesh that wobbles by " + about(c.wobble) +
                           " of the radius (`origin` of fix mill/similarity)");
  constexpr double usual_overlap = 0.05, usual_step = 0.2;
  const std::string soft = "a soft material, in whose bed balls sink " + about(c.bed_overlap) +
                           " radii into each other, usual is up to " + about(usual_overlap) +
                           " (a larger youngsModulus)";
  const std::string step =
      (c.step > 0.0 ? "the time step, " + about(c.step) + " Rayleigh times, usual is up to " +
                          about(usual_step)
                    : std::string("the time step")) +
      " (a shorter timestep)";
  const bool is_soft = c.bed_overlap > usual_overlap;
  const bool soft_first = c.bed_overlap / usual_overlap > c.step / usual_step;
  add(is_soft && soft_first, soft);
  found.push_back(step);
  add(is_soft && !soft_first, soft);
  return found;
}

/// The error message: ball, fault, time, position and possible causes.
inline std::string report(const Suspect& ball, const std::string& fault, long step,
                          const std::string& near_wall, const std::vector<std::string>& causes)
{
  std::string list;
  for (const std::string& cause : causes) list += (list.empty() ? "" : "; ") + cause;
  return "fix mill/guard: ball " + std::to_string(ball.id) + " " + fault + "; step " +
         std::to_string(step) + ", position " + text(ball.position) + " m, speed " +
         format(std::sqrt(dot(ball.velocity, ball.velocity))) + " m/s, force " +
         format(std::sqrt(dot(ball.force, ball.force))) + " N, nearest wall " + near_wall +
         "; likeliest first: " + list + "; see docs/results/hard-cases.md";
}

}  // namespace millscale::charge
