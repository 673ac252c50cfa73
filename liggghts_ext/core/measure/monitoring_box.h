#pragma once

#include <array>
#include <cmath>

#include "core/liner/frame.h"
#include "core/liner/groove_box.h"

namespace millscale::charge {

/// The box as large as the groove between two lifters, in the frame of its own middle: between two
/// lines across, its sides straight. Shape and size are those of liner::groove_box.
class MonitoringBox {
 public:
  /// Throws std::invalid_argument for a plain drum, which has no groove.
  explicit MonitoringBox(const liner::Liner& liner)
  {
    const liner::Frame middle(liner.groove_angle(0));
    const std::array<liner::Point, 4> corner = liner::groove_box(liner);
    const liner::Local outer = middle.local(corner[1]), inner = middle.local(corner[2]);
    outer_ = outer.radial;
    inner_ = inner.radial;
    inner_half_ = inner.tangential;
    slope_ = (outer.tangential - inner.tangential) / (outer_ - inner_);
  }

  /// No point closer to the axis is in the box [m].
  double inner() const { return inner_; }

  /// Whether a point is in the box, its border included. A ball counts by its centre, as DEM
  /// packages count the balls of a selection: a ball is in one of two adjacent boxes, never in
  /// both.
  bool holds(liner::Local p) const
  {
    return p.radial >= inner_ && p.radial <= outer_ &&
           std::abs(p.tangential) <= inner_half_ + slope_ * (p.radial - inner_);
  }

 private:
  double inner_, outer_, inner_half_, slope_;
};

}  // namespace millscale::charge
