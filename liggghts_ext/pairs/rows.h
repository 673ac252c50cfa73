#pragma once

#include <cstddef>
#include <vector>

#include "pairs/balls.h"

namespace millscale::pairs {

/// What the contacts read and write of a ball, in rows of whole cache lines: the engine keeps each
/// quantity in an array of its own, and a contact would touch fourteen lines.
struct alignas(32) Place {
  double x, y, z, radius;  ///< [m]
};
struct alignas(64) Motion {
  double velocity[3], mass;  ///< [m/s], [kg]
  double spin[3], held;      ///< [rad/s], `contact::damping_held` [-]
};
/// Zero between steps.
struct alignas(64) Load {
  double force[4];            ///< [N], and a number that is not used
  double torque[3], damping;  ///< [N m]; sum of the contacts' tangential coefficients [kg/s]
};

/// Rows of all balls, owned and ghost.
struct Rows {
  Place* place;
  Motion* motion;
  Load* load;
};

/// Owns the memory of rows.
class RowStore {
 public:
  /// Without loads. Those of ghosts grow and nobody reads them, until a ghost's row becomes a
  /// ball's.
  Rows for_balls(std::size_t count)
  {
    place_.resize(count);
    motion_.resize(count);
    load_.assign(count, Load{});
    return rows();
  }

  Rows rows() { return {place_.data(), motion_.data(), load_.data()}; }

 private:
  std::vector<Place> place_;
  std::vector<Motion> motion_;
  std::vector<Load> load_;
};

}  // namespace millscale::pairs
