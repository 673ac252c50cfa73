"""Warnings of input that runs but is more likely a slip, each with the number that shows it.

`feasible` refuses what cannot run, and `millscale.campaign.build` warns of single values.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from millscale.formats import duration, rounded_up
from millscale.packing.bed import LARGEST_OVERLAP
from millscale.runs.case_file import Case
from millscale.runs.soft_balls import impact_overlap, modulus_for, physical_modulus

# Overlap of the fastest impact over the ball radius that DEM practice stays below, and a tenth of
# a Hertz contact's range.
USUAL_OVERLAP, SMALL_OVERLAP = 0.05, 0.01
# Young's modulus above which a softer ball is usual [Pa].
STIFF_PA = 1e10
# What softer balls cost, where it was measured (docs/results/speed-against-error.md).
SOFTENED = "a quarter of E moved the contour of the mill of S = 2.6 by 1.2 %, its mass flow by 4 %"


def slips_of(cases: Sequence[Case], times: Sequence[float]) -> dict[str, list[str]]:
    """Return the warnings about the cases of a campaign, by case.

    A warning concerns several cases and has the numbers of the one where they are worst.

    Args:
        times: predicted wall time of each case [s].
    """
    found: dict[str, list[str]] = {}
    for text, concerned in (
        *_overlap(cases),
        *_stiffness(cases, times),
        *_lifters(cases),
        *_settling(cases),
    ):
        for case in concerned:
            found.setdefault(case.id, []).append(text)
    return found


Warnings = Iterable[tuple[str, Sequence[Case]]]


def _overlap(cases: Sequence[Case]) -> Warnings:
    # `feasible` warns of deeper ones.
    soft = [x for x in cases if USUAL_OVERLAP < impact_overlap(x) <= LARGEST_OVERLAP]
    if not soft:
        return
    worst = max(soft, key=impact_overlap)
    least = modulus_for(worst, USUAL_OVERLAP)
    steps = math.sqrt(least / physical_modulus(worst))
    yield (
        f"impacts at {worst.time.impact_speed_m_s:.3g} m/s overlap by "
        f"{impact_overlap(worst):.2g} of the ball radius at S = {worst.S:g}; a youngs_modulus_pa "
        f"of {least:g} keeps them below {USUAL_OVERLAP:g}, with steps {steps:.2g} times shorter",
        soft,
    )


def _stiffness(cases: Sequence[Case], times: Sequence[float]) -> Warnings:
    timed = [pair for pair in zip(cases, times, strict=True) if _is_stiff(pair[0])]
    if not timed:
        return
    stiff, total = [case for case, _ in timed], sum(time for _, time in timed)
    worst, shortest = max(stiff, key=impact_overlap), min(case.time.step_s for case in stiff)
    modulus = physical_modulus(worst)
    softer = []
    for overlap in (USUAL_OVERLAP, SMALL_OVERLAP):
        least = modulus_for(worst, overlap)
        # Step and time follow 1 / sqrt(E), as the Rayleigh time does.
        if least < modulus:
            factor = math.sqrt(least / modulus)
            softer.append(
                f"{least:g} keeps it below {overlap:g} (steps of {shortest / factor:.2g} s, "
                f"{duration(total * factor)})"
            )
    yield (
        f"youngs_modulus_pa = {modulus:g} takes steps of {shortest:.2g} s, {duration(total)} in "
        f"all, for impacts that overlap by {impact_overlap(worst):.2g} of the ball radius"
        + "".join(f"; {text}" for text in softer)
        + f"; {SOFTENED}",
        stiff,
    )


def _is_stiff(case: Case) -> bool:
    """Return whether balls half as stiff would still do."""
    modulus = physical_modulus(case)
    return modulus > STIFF_PA and modulus_for(case, USUAL_OVERLAP) < 0.5 * modulus


def _lifters(cases: Sequence[Case]) -> Warnings:
    low = [
        case
        for case in cases
        # A height of one diameter may be rounded.
        if case.mill.lifters and case.groups.lifter_height_over_ball_diameter < 1.0 - 1e-9
    ]
    if not low:
        return
    worst = min(low, key=lambda case: case.groups.lifter_height_over_ball_diameter)
    height = worst.groups.lifter_height_over_ball_diameter
    most = math.floor(1e3 * height * worst.S) / 1e3
    yield (
        f"lifters are {height:.2g} ball diameters high at S = {worst.S:g}, and balls roll over "
        "them" + (f"; S <= {most:g} keeps them a diameter high" if most >= 1.0 else ""),
        low,
    )


def _settling(cases: Sequence[Case]) -> Warnings:
    def fall(case: Case) -> float:
        return 0.5 * case.mill.gravity_m_s2 * case.time.start_s**2

    hanging = [
        case
        for case in cases
        if case.kind == "multi-ball" and fall(case) < 2.0 * case.ball.radius_m
    ]
    if not hanging:
        return
    worst = min(hanging, key=fall)
    diameter = 2.0 * worst.ball.radius_m
    least = math.sqrt(2.0 * diameter / worst.mill.gravity_m_s2) / worst.factors.time
    yield (
        f"in the settling of {worst.time.start_s / worst.factors.time:.2g} s a ball falls by "
        f"{fall(worst):.2g} m at S = {worst.S:g}, less than its diameter of {diameter:g} m; a "
        f"settle_s of {rounded_up(least):g} is enough for that",
        hanging,
    )
