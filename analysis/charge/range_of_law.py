"""Which scaled mills obey the law of the errors: those whose liner still holds whole balls.

The balls are not scaled, so lifters and grooves shrink against them. A lifter lower than a ball
holds no ball: balls roll over it, and the charge slips. A groove narrower than two balls holds them
one beside the other, and no layer lies between the lifters. A mill of a few balls across has no
flowing layer thin against its bed. Beyond these limits the motion changes in kind, not by a power
of S (docs/theory/prediction.md).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from millscale.runs.case_file import Case

# In ball diameters, at the scaled mill.
LEAST_LIFTER_HEIGHT = 1.0
LEAST_GROOVE_WIDTH = 2.0
# Mill radius over ball radius: a bed of some ten ball diameters at a filling of 0.3.
LEAST_MILL_OVER_BALL = 30.0
# Rounding of S in a campaign file.
_SLACK = 1e-3


@dataclass(frozen=True)
class _Limit:
    """A size of a scaled mill over that of its balls, and the least at which the law holds."""

    what: str
    value: float
    least: float
    unit: str

    @property
    def is_kept(self) -> bool:
        return self.value >= self.least * (1.0 - _SLACK)


def outside_range(case: Case) -> str:
    """Return why a scaled mill does not obey the law of the errors; empty if it does.

    The reason names the largest S within the limits; none is above 1 where the physical mill
    itself is at a limit. The physical mill is always within them.
    """
    if case.is_physical:
        return ""
    reasons = [
        f"{x.what} {x.value:.2g} {x.unit}, at least {x.least:g} are needed"
        for x in _limits(case)
        if not x.is_kept
    ]
    if not reasons:
        return ""
    most = largest_S(case)
    advice = f"S up to {most:g}" if most > 1.0 else "run the physical mill, S = 1"
    return f"{' and '.join(reasons)}: {advice}"


def largest_S(case: Case) -> float:
    """Return the largest S at which a scaled mill of the same physical mill obeys the law, rounded
    down to hundredths; 1 or less where none does."""
    most = min(case.S * limit.value / limit.least for limit in _limits(case))
    return math.floor(100.0 * most) / 100.0


def _limits(case: Case) -> list[_Limit]:
    groups = case.groups
    across = _Limit(
        "its radius is",
        1.0 / groups.ball_radius_over_mill_radius,
        LEAST_MILL_OVER_BALL,
        "ball radii",
    )
    if not case.mill.lifters:
        return [across]
    height, width = groups.lifter_height_over_ball_diameter, groups.groove_width_over_ball_diameter
    return [
        _Limit("its lifters are", height, LEAST_LIFTER_HEIGHT, "ball diameters high"),
        _Limit("its grooves are", width, LEAST_GROOVE_WIDTH, "ball diameters wide"),
        across,
    ]
