#pragma once

#include <cstddef>
#include <vector>

#include "core/neighbor/particles.h"

namespace millscale::pairs {

/// What the contacts read and write of a ball, in rows of whole cache lines: the engine keeps each
/// quantity in an array of its own, and a contact would touch fourteen lines.
struct alignas(32) Place {
  double x, y, z, radius;  ///< [m]
};
struct alignas(64) Motion {
  double velocity[3], mass;       ///< [m/s], [kg]
  double spin[3], damping_share;  ///< [rad/s], `contact::damping_share` [-]
};
/// Zero between steps.
struct alignas(64) Load {
  double force[4];            ///< [N], and a number that is not used
  double torque[3], damping;  ///< [N m]; sum of the contacts' tangential coefficients [kg/s]
};

/// The same two in single precision, one row each: for the mixed kernel.
struct alignas(32) SingleMotion {
  float velocity[3], mass, spin[3], damping_share;
};
struct alignas(32) SingleLoad {
  float force[3], damping, torque[3], not_used;
};

/// Rows of all balls, owned and ghost; motion and load in one of the two precisions.
struct Rows {
  Place* place;
  Motion* motion;
  Load* load;
  SingleMotion* single_motion;
  SingleLoad* single_load;
};

/// Owns the memory of rows.
class RowStore {
 public:
  /// Without loads. Those of ghosts grow and nobody reads them, until a ghost's row becomes a
  /// ball's.
  Rows for_balls(std::size_t count, bool single = false)
  {
    place_.resize(count);
    motion_.resize(single ? 0 : count);
    load_.assign(single ? 0 : count, Load{});
    single_motion_.resize(single ? count : 0);
    single_load_.assign(single ? count : 0, SingleLoad{});
    return rows();
  }

  Rows rows()
  {
    return {place_.data(), motion_.data(), load_.data(), single_motion_.data(),
            single_load_.data()};
  }

 private:
  std::vector<Place> place_;
  std::vector<Motion> motion_;
  std::vector<Load> load_;
  std::vector<SingleMotion> single_motion_;
  std::vector<SingleLoad> single_load_;
};

}  // namespace millscale::pairs
