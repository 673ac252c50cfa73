#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include "core/liner/contacts.h"
#include "core/liner/profile.h"
#include "core/math/constants.h"
#include "core/measure/bed_arc.h"
#include "core/measure/monitoring_box.h"

namespace millscale::charge {

/// One ball: its centre in the cross-section, from the axis, the squares of velocity and spin, and
/// the angular momentum about the axis of its path and of its spin [kg m^2/s].
struct Ball {
  liner::Point centre;
  double mass, radius, speed_squared, spin_squared, path_momentum, spin_momentum;
};

/// What is measured, besides the sums over all balls.
struct Plan {
  liner::Profile liner;
  double ball_radius;  ///< that sets the wall layer [m]
  double gravity;      ///< [m/s^2]
  double box_angle;    ///< polar angle of the middle of the monitoring box [rad]
};

/// Sums over the balls; docs/reference/styles/compute-mill-charge.md, compute mill/charge.
struct Summary {
  double balls, outside;  ///< of all balls, those whose centre is beyond the liner
  double mass, kinetic_translation, kinetic_rotation, potential, centre_x, centre_z;
  double box_fixed, box_rotating;  ///< mass over total mass; NaN in a plain drum
  double toe, shoulder;            ///< from the vertical [rad]; NaN without a bed at the wall
  double overlap_with_ball, overlap_with_wall, largest_speed;
  double angular_momentum;  ///< about the axis, in the direction of rotation [kg m^2/s]
  double layer_speed;  ///< of the balls that touch the liner about the axis [rad/s]; NaN without

  /// Return how far the balls that touch the liner stay behind it, over its speed [rad/s]; NaN
  /// without such balls or at rest. docs/theory/charge.md, slip on the liner.
  double liner_slip(double mill_speed) const
  {
    return mill_speed != 0.0 ? 1.0 - layer_speed / mill_speed
                             : std::numeric_limits<double>::quiet_NaN();
  }
};

/// Numbers of one pass over the balls: maxima first, then sums, so that the numbers of several
/// ranks are merged by one rule. The *wall layer* is the ring of centres up to one ball diameter
/// inside the liner's smallest radius, that of the lifter tops, cut into bins about one ball radius
/// wide.
class ChargeSums {
 public:
  explicit ChargeSums(const Plan& plan)
      : plan_(plan),
        finder_(plan.liner, plan.ball_radius),
        top_(plan.liner.clear_radius()),
        bins_(bins_of_layer(top_, plan.ball_radius)),
        fixed_(plan.box_angle),
        rotating_(plan.box_angle),
        mill_at_rest_(0.0),
        numbers_(first_bin + bins_, 0.0)
  {
    if (liner::has_groove(plan.liner)) box_.emplace(plan.liner);
  }

  /// Forgets the balls; those that follow are in a mill at this angle [rad].
  void start(double mill_angle)
  {
    std::fill(numbers_.begin(), numbers_.end(), 0.0);
    rotating_ = liner::Frame(plan_.box_angle + mill_angle);
    mill_at_rest_ = liner::Frame(mill_angle);
  }

  /// Whether a point at this squared distance from the axis [m^2] is within the liner's radius; not
  /// so if it is no number.
  bool inside(double distance_squared) const
  {
    return distance_squared <= plan_.liner.radius() * plan_.liner.radius();
  }

  /// A ball outside the liner is only counted: it is a fault, and its other numbers mean nothing.
  void add(const Ball& ball)
  {
    const double square = ball.centre.x * ball.centre.x + ball.centre.z * ball.centre.z;
    numbers_[balls] += 1.0;
    if (!inside(square)) {
      numbers_[outside] += 1.0;
      return;
    }
    raise(speed_squared, ball.speed_squared);
    numbers_[mass] += ball.mass;
    numbers_[translation] += 0.5 * ball.mass * ball.speed_squared;
    numbers_[rotation] +=
        0.5 * sphere_inertia * ball.mass * ball.radius * ball.radius * ball.spin_squared;
    numbers_[moment_x] += ball.mass * ball.centre.x;
    numbers_[moment_z] += ball.mass * ball.centre.z;
    numbers_[angular_momentum] += ball.path_momentum + ball.spin_momentum;
    const double near = top_ - 2.0 * std::max(plan_.ball_radius, ball.radius);
    if (near < 0.0 || square > near * near) add_near_wall(ball, std::sqrt(square));
  }

  /// Takes in the largest overlap of two balls [m].
  void add_overlap(double overlap) { raise(overlap_with_ball, overlap); }

  std::vector<double>& numbers() { return numbers_; }

  /// Merges the numbers of another rank, `from`, into `into`, each of `count`.
  static void merge(const double* from, double* into, std::size_t count)
  {
    for (std::size_t i = 0; i < maxima; ++i) into[i] = std::max(into[i], from[i]);
    for (std::size_t i = maxima; i < count; ++i) into[i] += from[i];
  }

  /// Angle of a bin of the wall layer: the resolution of toe and shoulder [rad].
  double resolution() const { return 2.0 * pi / static_cast<double>(bins_); }

  Summary summary() const
  {
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    const auto per_mass = [&](double x) {
      return numbers_[mass] > 0.0 ? x / numbers_[mass] : none;
    };
    Summary s{};
    s.balls = numbers_[balls];
    s.outside = numbers_[outside];
    s.mass = numbers_[mass];
    s.kinetic_translation = numbers_[translation];
    s.kinetic_rotation = numbers_[rotation];
    s.potential = plan_.gravity * numbers_[moment_z];
    s.centre_x = per_mass(numbers_[moment_x]);
    s.centre_z = per_mass(numbers_[moment_z]);
    s.box_fixed = box_ ? per_mass(numbers_[in_fixed]) : none;
    s.box_rotating = box_ ? per_mass(numbers_[in_rotating]) : none;
    s.overlap_with_ball = numbers_[overlap_with_ball];
    s.overlap_with_wall = numbers_[overlap_with_wall];
    s.largest_speed = std::sqrt(numbers_[speed_squared]);
    s.angular_momentum = numbers_[angular_momentum];
    s.layer_speed =
        numbers_[layer_inertia] > 0.0 ? numbers_[layer_momentum] / numbers_[layer_inertia] : none;
    put_bed(s);
    return s;
  }

 private:
  enum Number : std::size_t {
    speed_squared,
    overlap_with_ball,
    overlap_with_wall,
    maxima,
    balls = maxima,
    outside,
    mass,
    translation,
    rotation,
    moment_x,
    moment_z,
    angular_momentum,
    layer_momentum,
    layer_inertia,
    in_fixed,
    in_rotating,
    first_bin
  };

  static std::size_t bins_of_layer(double top, double ball_radius)
  {
    const double middle = std::max(top - ball_radius, ball_radius);
    return static_cast<std::size_t>(std::max(8.0, std::round(2.0 * pi * middle / ball_radius)));
  }

  void raise(Number which, double value) { numbers_[which] = std::max(numbers_[which], value); }

  void add_near_wall(const Ball& ball, double distance)
  {
    if (box_ && distance >= box_->inner()) {
      if (box_->holds(fixed_.local(ball.centre))) numbers_[in_fixed] += ball.mass;
      if (box_->holds(rotating_.local(ball.centre))) numbers_[in_rotating] += ball.mass;
    }
    if (distance >= top_ - 2.0 * plan_.ball_radius && distance <= top_) {
      const double turn = liner::polar_angle(ball.centre) / (2.0 * pi);
      const auto bin = static_cast<std::size_t>((turn + 0.5) * static_cast<double>(bins_));
      numbers_[first_bin + std::min(bin, bins_ - 1)] += ball.mass;
    }
    if (distance > top_ - ball.radius) {
      const liner::Local at_rest = mill_at_rest_.local(ball.centre);
      const liner::Contacts found =
          finder_.contacts({-at_rest.tangential, -at_rest.radial}, ball.radius);
      for (int c = 0; c < found.count; ++c)
        raise(overlap_with_wall, found.contact[static_cast<std::size_t>(c)].overlap);
      if (found.count > 0) {
        numbers_[layer_momentum] += ball.path_momentum;
        numbers_[layer_inertia] += ball.mass * distance * distance;
      }
    }
  }

  /// The bed along the wall, from the toe in the direction of rotation to the shoulder. The toe is
  /// counted from the top down the rising side, through the bottom: it is larger than the shoulder.
  void put_bed(Summary& s) const
  {
    const std::vector<double> layer(numbers_.begin() + first_bin, numbers_.end());
    const std::optional<Arc> bed = bed_arc(layer);
    s.toe = s.shoulder = std::numeric_limits<double>::quiet_NaN();
    if (!bed) return;
    // Bin 0 begins at polar angle -pi, the top; from there the angle from the vertical falls.
    const auto end = static_cast<double>((bed->first + bed->count) % bins_);
    s.shoulder = 2.0 * pi - end * resolution();
    if (s.shoulder > pi) s.shoulder -= 2.0 * pi;
    s.toe = s.shoulder + static_cast<double>(bed->count) * resolution();
  }

  Plan plan_;
  liner::ContactFinder finder_;
  double top_;
  std::size_t bins_;
  std::optional<MonitoringBox> box_;
  liner::Frame fixed_, rotating_, mill_at_rest_;
  std::vector<double> numbers_;
};

}  // namespace millscale::charge
