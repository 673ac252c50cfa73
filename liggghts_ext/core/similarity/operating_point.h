#pragma once

#include <cmath>
#include <stdexcept>
#include <string>

#include "core/math/format.h"

namespace millscale::similarity {

/// A mill in operation, in SI units: radius at the liner [m], ball radius [m], gravity [m/s^2],
/// speed of rotation [rad/s].
struct OperatingPoint {
  double radius, ball_radius, gravity, omega;
};

/// Return the Froude number omega^2 R / g of a point mass on the liner [-]. Powder Technology 335
/// (2018) 91-102, Eq. 4.
inline double froude_number(double radius, double gravity, double omega)
{
  return omega * omega * radius / gravity;
}

inline double froude_number(const OperatingPoint& mill)
{
  return froude_number(mill.radius, mill.gravity, mill.omega);
}

/// Return the angle from the vertical at which a point mass leaves the liner, arccos(Fr) [rad].
/// Powder Technology 335 (2018) 91-102, Eq. 4. Valid for 0 <= Fr <= 1; beyond Fr = 1 the mill
/// centrifuges and nothing detaches.
inline double detach_angle(double froude)
{
  if (!(froude >= 0.0 && froude <= 1.0))
    throw std::domain_error("detach_angle: defined for 0 <= Fr <= 1, got Fr = " + format(froude) +
                            (froude > 1.0 ? " (a centrifuging mill: nothing detaches)" : ""));
  return std::acos(froude);
}

/// Return the speed at which a ball on the liner just centrifuges, sqrt(g / (R - a)) [rad/s]. The
/// ball's centre moves on R - a. Standard definition of the critical speed of a mill.
inline double critical_speed(const OperatingPoint& mill)
{
  return std::sqrt(mill.gravity / (mill.radius - mill.ball_radius));
}

/// Motion of the charge by Froude number.
enum class Regime { slipping_or_cascading, cataracting, centrifuging };

/// Return the regime by Fr = omega^2 R / g: centrifuging from 1; slipping or cascading below about
/// 0.2, where balls roll down the bed's surface; cataracting between. The boundary at 0.2 is an
/// order of magnitude: friction, filling and lifters change it. Limits after Henein, Brimacombe,
/// Watkinson, Metall. Trans. B 14 (1983) 191, doi 10.1007/BF02661016, and Mellmann, Powder Technol.
/// 118 (2001) 251, doi 10.1016/S0032-5910(00)00402-2.
inline Regime regime(double froude)
{
  if (froude >= 1.0) return Regime::centrifuging;
  return froude >= 0.2 ? Regime::cataracting : Regime::slipping_or_cascading;
}

inline const char* name(Regime r)
{
  switch (r) {
    case Regime::slipping_or_cascading:
      return "slipping or cascading";
    case Regime::cataracting:
      return "cataracting";
    case Regime::centrifuging:
      return "centrifuging";
  }
  return "";
}

}  // namespace millscale::similarity
