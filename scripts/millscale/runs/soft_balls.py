"""How far impacts compress the balls of a case, and the modulus that limits it."""

from __future__ import annotations

from millscale.formats import rounded_up
from millscale.runs.case_file import Case


def impact_overlap(case: Case) -> float:
    """Return the overlap of an impact at the speed of re-impact over the ball radius.

    A Hertz impact lasts 2.94 times its overlap over its speed (docs/theory/contact-law.md).
    """
    time = case.time
    return time.collision_time_s * time.impact_speed_m_s / 2.94 / case.ball.radius_m


def modulus_for(case: Case, overlap: float, found: float | None = None) -> float:
    """Return Young's modulus of the physical mill at which impacts overlap by no more, rounded up.

    The overlap of a Hertz impact follows E^(-2/5).

    Args:
        overlap: over the ball radius.
        found: overlap at the present modulus, over the ball radius; None stands for
            `impact_overlap`.
    """
    now = impact_overlap(case) if found is None else found
    return rounded_up(physical_modulus(case) * (now / overlap) ** 2.5)


def physical_modulus(case: Case) -> float:
    """Return Young's modulus of the physical mill [Pa]."""
    matched = case.material.stiffness == "overlap-matched"
    velocity = case.factors.length / case.factors.time if matched else 1.0
    return case.material.youngs_modulus_pa / velocity**2
