"""Hogg and Fuerstenau: the charge as a rigid segment, turned by an angle."""

from __future__ import annotations

import math

from millscale.power_models.limits import filling, speed
from millscale.power_models.mill import STANDARD_GRAVITY, Mill

# 0.238 kW with D and L in feet and tonnes per cubic metre, over rho omega R^3 L g of that mill.
# Its near 0.892 (1 - 1.065 J) is the distance of a segment's centroid from the axis over R.
_KILOWATT_M = 0.238 / 0.3048**3.5
LEVER = 1e3 * _KILOWATT_M / (1e3 * math.sqrt(2.0) * math.pi / 8.0 * STANDARD_GRAVITY**1.5)
USUAL_ANGLE = math.radians(35.0)
LIMITS = (filling(0.15, 0.45), speed(0.5, 0.8))


def hogg_fuerstenau_power(mill: Mill, angle: float = USUAL_ANGLE) -> float:
    """Return the net power of the charge [W].

        P = 0.238 D^2.5 L phi rho (J - 1.065 J^2) sin(alpha)      [kW; D, L in ft, rho in t/m^3]
          = 0.892 omega M g R (1 - 1.065 J) sin(alpha)            [W; SI]

    The second line is the first in SI units: torque over M g R depends on J and alpha alone, so
    similar mills draw D^3.5.
    The form without 0.892, which is also in print, is 12 % higher.

    Args:
        angle: alpha, by which the surface of the charge is inclined [rad]: 30 to 40 degrees.

    Valid for a charge that cascades, at 50 to 80 % of the critical speed: beyond, the power falls.
    J of 0.15 to 0.45, where 0.892 (1 - 1.065 J) is within 1 % of the segment's centroid.
    Lifters are not in the model; the angle stands for them.

    Source: R. Hogg, D. W. Fuerstenau, Power relationships for tumbling mills, Trans. SME-AIME 252
    (1972) 418; constants as given by Moly-Cop Tools (J. E. Sepulveda). The original was not seen.
    """
    arm = LEVER * (1.0 - 1.065 * mill.filling) * math.sin(angle)
    return mill.omega * mill.mass * mill.gravity * mill.radius * arm
