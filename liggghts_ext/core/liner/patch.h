#pragma once

#include <cmath>

namespace millscale::liner {

/// A plane or a circle that a wall follows near a contact: a line, an arc or an edge of the
/// cross-section, or an end of the mill. In the frame of the mill at rest. `Number` is a double, or
/// a pack of doubles with +, -, *, / and sqrt.
template <class Number>
struct PatchOf {
  Number x, z;                              ///< a point of the plane, or the centre of the circle
                                            ///< in the cross-section [m]
  Number normal_x, normal_z, normal_along;  ///< of a plane, to the cavity; 0 for a circle
  Number offset;                            ///< of the distance [m]
  Number side;   ///< 1: the cavity is inside the circle; -1: outside; 0: a plane
  Number turns;  ///< 1: moves with the mill; 0: at rest
};
using Patch = PatchOf<double>;

/// A point before a patch.
template <class Number>
struct BeforePatch {
  Number distance;                          ///< < 0: on the wall's side [m]
  Number normal_x, normal_z, normal_along;  ///< from the patch to the point, unit vector
};

/// Return the distance and the normal of a point: x, z in the cross-section, and its position along
/// the axis [m]. One formula for planes and circles, so that a pack may hold both.
template <class Number>
[[gnu::always_inline]] inline BeforePatch<Number> before(const PatchOf<Number>& patch,
                                                         const Number& x, const Number& z,
                                                         const Number& along)
{
  using std::sqrt;
  const Number x_gap = x - patch.x, z_gap = z - patch.z;
  const Number from_centre = sqrt(x_gap * x_gap + z_gap * z_gap);
  const Number inward = patch.side / (from_centre + Number(1e-300));  // no division by 0
  return {patch.normal_x * x_gap + patch.normal_z * z_gap + patch.normal_along * along +
              patch.offset - patch.side * from_centre,
          patch.normal_x - inward * x_gap, patch.normal_z - inward * z_gap, patch.normal_along};
}

}  // namespace millscale::liner
