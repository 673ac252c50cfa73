"""Which scaled mills obey the law of the errors: those whose liner still holds whole balls.

The balls are not scaled, so lifters and grooves shrink against them. A lifter lower than a ball
holds no ball: balls roll over it, and the charge slips. A groove narrower than two balls holds them
one beside the other, and no layer lies between the lifters. A mill of a few balls across has no
flowing layer thin against its bed. Beyond these limits the motion changes in kind, not by a power
of S (docs/theory/prediction.md).
"""

from __future__ import annotations

import math

from millscale.runs.case_file import Case

# In ball diameters, at the scaled mill.
LEAST_LIFTER_HEIGHT = 1.0
LEAST_GROOVE_WIDTH = 2.0
# Mill radius over ball radius: a bed of some ten ball diameters at a filling of 0.3.
LEAST_MILL_OVER_BALL = 30.0
# Rounding of S in a campaign file.
_SLACK = 1e-3


def outside_range(case: Case) -> str:
    """Return why a scaled mill does not obey the law of the errors; empty if it does.

    The reason names the largest S within the limits; none is above 1 where the physical mill
    itself is at a limit. The physical mill is always within them.
    """
    if case.is_physical:
        return ""
    groups, reasons, largest = case.groups, [], []

    def check(what: str, value: float, least: float, unit: str) -> None:
        largest.append(case.S * value / least)
        if value < least * (1.0 - _SLACK):
            reasons.append(f"{what} {value:.2g} {unit}, at least {least:g} are needed")

    if case.mill.lifters:
        height, width = (
            groups.lifter_height_over_ball_diameter,
            groups.groove_width_over_ball_diameter,
        )
        check("its lifters are", height, LEAST_LIFTER_HEIGHT, "ball diameters high")
        check("its grooves are", width, LEAST_GROOVE_WIDTH, "ball diameters wide")
    ratio = 1.0 / groups.ball_radius_over_mill_radius
    check("its radius is", ratio, LEAST_MILL_OVER_BALL, "ball radii")
    if not reasons:
        return ""
    # Rounded down: the advised S is within the limits.
    most = math.floor(100.0 * min(largest)) / 100.0
    advice = f"S up to {most:g}" if most > 1.0 else "run the physical mill, S = 1"
    return f"{' and '.join(reasons)}: {advice}"
