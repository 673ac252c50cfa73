#pragma once

#include <array>

#include "core/liner/frame.h"
#include "core/liner/groove_box.h"

namespace millscale::charge {

/// The box as large as a groove, or as a sector of a shape without lifters, in the frame of its own
/// middle: between two lines across, its sides straight. Shape and size are those of
/// liner::groove_box.
class MonitoringBox {
 public:
  /// Throws std::invalid_argument for a plain drum, which has no groove.
  explicit MonitoringBox(const liner::Profile& liner)
  {
    const liner::Frame middle(liner::groove_middle(liner));
    const std::array<liner::Point, 4> corner = liner::groove_box(liner);
    const liner::Local outer = middle.local(corner[1]), inner = middle.local(corner[2]);
    outer_ = outer.radial;
    inner_ = inner.radial;
    low_ = Side(middle.local(corner[3]), middle.local(corner[0]));
    high_ = Side(inner, outer);
  }

  /// No point closer to the axis is in the box [m].
  double inner() const { return inner_; }

  /// Whether a point is in the box, its border included. A ball counts by its centre, as DEM
  /// packages count the balls of a selection: a ball is in one of two adjacent boxes, never in
  /// both.
  bool holds(liner::Local p) const
  {
    return p.radial >= inner_ && p.radial <= outer_ &&
           p.tangential <= high_.inner + high_.slope * (p.radial - inner_) &&
           p.tangential >= low_.inner + low_.slope * (p.radial - inner_);
  }

 private:
  /// A side of the box: beside the middle [m], on the inner line and per distance from it.
  struct Side {
    double inner = 0.0, slope = 0.0;

    Side() = default;
    Side(liner::Local from, liner::Local to)
        : inner(from.tangential),
          slope((to.tangential - from.tangential) / (to.radial - from.radial))
    {
    }
  };

  double inner_, outer_;
  Side low_, high_;
};

}  // namespace millscale::charge
