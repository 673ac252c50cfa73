"""Bond: power per mass of balls of wet overflow ball mills."""

from __future__ import annotations

import math

from millscale.power_models.limits import ON_EARTH, diameter, filling, speed
from millscale.power_models.mill import Mill

LIMITS = (diameter(2.4, math.inf), filling(0.2, 0.5), speed(0.5, 0.9), ON_EARTH)


def bond_power(mill: Mill) -> float:
    """Return the power at the pinion shaft [W].

        P / m_b = 4.879 D^0.3 (3.2 - 3 J) phi (1 - 0.1 / 2^(9 - 10 phi))      [kW/t; D in m]

    m_b is the mass of the balls. In another form: 15.6 D^0.3 (1 - 0.9375 J) phi (...).
    Torque over M g R falls as D^-0.2, and similar mills draw D^3.3.

    The formula is for wet mills that overflow; others draw more. The term of the ball size, some
    percent, is left out.

    Valid for industrial mills: D above 2.4 m, J of 0.2 to 0.5, 50 to 90 % of the critical speed.
    These limits are from memory.

    Source: C. A. Rowland, D. M. Kjos, Rod and ball mills, in Mineral Processing Plant Design, SME
    (1980), after F. C. Bond, Brit. Chem. Eng. 6 (1961) 378 and 543. The originals were not seen;
    public programs have the constants in two forms that agree (docs/theory/power-models.md).
    """
    per_tonne = 4.879 * mill.diameter**0.3 * (3.2 - 3.0 * mill.filling) * speed_term(mill)
    return 1e3 * per_tonne * 1e-3 * mill.ball_mass


def speed_term(mill: Mill) -> float:
    """Return phi (1 - 0.1 / 2^(9 - 10 phi)), which Bond found and Austin uses too."""
    phi = mill.fraction_of_critical
    return phi * (1.0 - 0.1 / 2.0 ** (9.0 - 10.0 * phi))
