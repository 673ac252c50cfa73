#pragma once

#include "core/liner/liner.h"

namespace millscale::liner {

/// Area of the cavity inside the liner [m^2], exact: per groove a circular sector, per lifter the
/// four triangles from the axis to its faces and to the halves of its top. Derived here.
inline double area(const Liner& liner)
{
  const double R = liner.radius();
  const double groove = R * R * liner.groove_half_angle();
  if (liner.lifters() == 0) return groove;
  const Local foot = liner.foot(), corner = liner.corner();
  const double faces = corner.radial * foot.tangential - corner.tangential * foot.radial;
  const double top = corner.radial * corner.tangential;
  return liner.lifters() * (groove + faces + top);
}

}  // namespace millscale::liner
