#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/math/checks.h"
#include "core/math/format.h"

namespace millscale::similarity {

/// A change of the mill's speed, stated in the mill's angle: the same in every scaled mill.
struct SpeedChange {
  double from;   ///< mill angle at which the change begins [rad]
  double over;   ///< mill angle of the change, at constant angular acceleration; 0: at once [rad]
  double ratio;  ///< speed afterwards / speed of the mill, > 0 [-]

  friend bool operator==(const SpeedChange& a, const SpeedChange& b)
  {
    return a.from == b.from && a.over == b.over && a.ratio == b.ratio;
  }
};

/// The mill's speed as a function of its angle, over its constant speed omega. The phase is omega
/// times the time since the start [rad], the angle of a mill that always turns at omega. Similar
/// mills have equal phases at similar times, so the schedule is the same in all of them.
///
/// The angle is a quadratic polynomial of the phase between changes, so it is exact to rounding and
/// no increments accumulate. Derived here.
class SpeedSchedule {
 public:
  /// A mill that always turns at omega.
  SpeedSchedule() : SpeedSchedule(std::vector<SpeedChange>{}) {}

  /// Changes in ascending order of angle. A mill whose first change is at angle 0 starts from rest,
  /// any other mill at omega. Throws std::invalid_argument if changes overlap or a number is wrong.
  explicit SpeedSchedule(const std::vector<SpeedChange>& changes)
  {
    const bool from_rest = !changes.empty() && changes.front().from == 0.0;
    pieces_.push_back({0.0, 0.0, from_rest ? 0.0 : 1.0, 0.0});
    double free_from = 0.0;
    for (const SpeedChange& change : changes) {
      check(change, free_from);
      free_from = change.from + change.over;
      const double before = pieces_.back().ratio;
      const double begin = phase(change.from);
      if (change.from == pieces_.back().angle) pieces_.pop_back();
      if (change.over > 0.0) {
        const double lasts = 2.0 * change.over / (before + change.ratio);
        pieces_.push_back({begin, change.from, before, (change.ratio - before) / lasts});
        pieces_.push_back({begin + lasts, free_from, change.ratio, 0.0});
      } else {
        pieces_.push_back({begin, change.from, change.ratio, 0.0});
      }
    }
  }

  /// Return the schedule from a mill angle [rad] on, with that angle as its zero.
  SpeedSchedule after(double angle) const
  {
    const double begin = phase(angle);
    const std::size_t first = piece_at(begin);
    SpeedSchedule rest;
    rest.pieces_.assign(pieces_.begin() + static_cast<std::ptrdiff_t>(first), pieces_.end());
    for (Piece& piece : rest.pieces_) {
      piece.phase -= begin;
      piece.angle -= angle;
    }
    rest.pieces_.front() = {0.0, 0.0, speed(begin), pieces_[first].slope};
    return rest;
  }

  /// Return the mill angle [rad] at a phase [rad], >= 0.
  double angle(double phase) const
  {
    const Piece& piece = pieces_[piece_at(phase)];
    const double since = phase - piece.phase;
    return piece.angle + (piece.ratio * since + 0.5 * piece.slope * since * since);
  }

  /// Return the speed over omega at a phase [rad], >= 0.
  double speed(double phase) const
  {
    const Piece& piece = pieces_[piece_at(phase)];
    return piece.ratio + piece.slope * (phase - piece.phase);
  }

  /// Return the phase [rad] at which the mill reaches an angle [rad], >= 0.
  double phase(double angle) const
  {
    std::size_t k = pieces_.size() - 1;
    while (k > 0 && pieces_[k].angle > angle) --k;
    const Piece& piece = pieces_[k];
    const double turned = angle - piece.angle;
    if (!(turned > 0.0)) return piece.phase;
    const double square = piece.ratio * piece.ratio + 2.0 * piece.slope * turned;
    return piece.phase + 2.0 * turned / (piece.ratio + std::sqrt(std::max(0.0, square)));
  }

  /// Return the largest speed over omega.
  double fastest() const
  {
    double most = 0.0;
    for (const Piece& piece : pieces_) most = std::max(most, piece.ratio);
    return most;
  }

  /// Return the mill angle [rad] from which on the speed is constant.
  double steady_from() const { return pieces_.back().angle; }

  /// Return the speed over omega after the last change.
  double last_ratio() const { return pieces_.back().ratio; }

 private:
  /// From a phase and mill angle on, at a ratio that changes by `slope` per phase.
  struct Piece {
    double phase, angle, ratio, slope;
  };

  std::size_t piece_at(double phase) const
  {
    std::size_t k = pieces_.size() - 1;
    while (k > 0 && pieces_[k].phase > phase) --k;
    return k;
  }

  static void check(const SpeedChange& change, double free_from)
  {
    require_finite("speed change, from", change.from);
    require_finite("speed change, over", change.over);
    require_positive("speed change, ratio", "", change.ratio);
    if (change.over < 0.0)
      reject("speed change, over", "a mill angle >= 0 is needed [rad]", change.over);
    if (change.from < free_from)
      reject("speed change, from",
             "it must be >= " + format(free_from) + " rad, where the change before ends",
             change.from);
  }

  std::vector<Piece> pieces_;
};

}  // namespace millscale::similarity
