"""Austin: power of semi-autogenous mills, here for a charge of balls."""

from __future__ import annotations

import math

from millscale.power_models.bond import speed_term
from millscale.power_models.limits import ON_EARTH, diameter, filling, speed
from millscale.power_models.mill import Mill

LIMITS = (diameter(2.4, math.inf), filling(0.1, 0.45), speed(0.5, 0.9), ON_EARTH)


def austin_power(mill: Mill) -> float:
    """Return the power at the shaft [W].

        P = 10.6 D^2.5 L (1 - 1.03 J) w phi (1 - 0.1 / 2^(9 - 10 phi))      [kW; D, L in m]
        w = (1 - e) (rho_s / w_c) J + 0.6 J_b (rho_b - rho_s / w_c)         [t/m^3]

    w is the mass of the charge over the volume of the mill. For balls alone it is 0.6 rho_b J:
    the bulk density of the charge times J, which is what is used here.
    Torque over M g R does not depend on D, and similar mills draw D^3.5.

    Valid for D above 2.4 m, J of 0.1 to 0.45, 50 to 90 % of the critical speed, flat ends. It was
    fitted to mills that grind rock with balls. The limits are those of usual mills, chosen here.

    Source: L. G. Austin, A mill power equation for SAG mills, Minerals and Metallurgical
    Processing 7 (1990) 57. The original was not seen; two public simulators have these constants.
    """
    share = 1e-3 * mill.bulk_density * mill.filling
    size = mill.diameter**2.5 * mill.length
    return 1e3 * 10.6 * size * (1.0 - 1.03 * mill.filling) * share * speed_term(mill)
