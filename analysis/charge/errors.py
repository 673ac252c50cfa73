"""How far one charge is from another: contour, curtains, mass flow, power."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from millscale.analysis.charge.scaled_mills import Charge
from millscale.analysis.shapes.comparison import curve_distances, overlap
from millscale.analysis.shapes.curtain import RESOLUTION, Curtain
from millscale.analysis.shapes.mass_flow import FRAMES, compare_flow
from millscale.analysis.shapes.shape import Shape
from millscale.analysis.shapes.solid_fraction import Grid

CURTAINS_OF_THE_PAPER = (2, 4, 6, 7)  # Fig. 12
PARTS = ("whole", "upper", "lower")
SHAPE_ERRORS = ("contour_error_mean", "contour_error_max", *(f"curtain_iou_{p}" for p in PARTS))
FLOW_ERRORS = (
    *("massflow_rms", "massflow_rms_over_mean", "massflow_correlation"),
    *("massflow_rotating_rms", "massflow_rotating_rms_over_mean"),
    "massflow_rotating_correlation",
)

Errors = dict[str, Any]


def shape_errors(shape: Shape | None, reference: Shape | None) -> Errors:
    """Distances of the contours and overlaps of the curtains at one mill angle.

    Returns:
        The keys of SHAPE_ERRORS and curtain_iou, by curtain; None where there is nothing to
        compare. curtain_iou_whole, _upper and _lower are means over the curtains.
    """
    errors: Errors = dict.fromkeys(SHAPE_ERRORS)
    errors["curtain_iou"] = None
    if shape is None or reference is None:
        return errors
    if shape.contour.lines and reference.contour.lines:
        mean, largest = curve_distances(shape.contour.lines, reference.contour.lines)
        errors |= {"contour_error_mean": mean, "contour_error_max": largest}
    if shape.curtains is None or reference.curtains is None:
        return errors
    each = {
        str(number): curtain_overlap(shape.curtains[number], reference.curtains[number])
        for number in sorted(shape.curtains.keys() & reference.curtains.keys())
    }
    means = {f"curtain_iou_{part}": mean_known(c[part] for c in each.values()) for part in PARTS}
    return errors | {"curtain_iou": each} | means


def curtain_overlap(curtain: Curtain, reference: Curtain) -> dict[str, float | None]:
    """Intersection over union of two curtains: whole, of their upper and lower ends (above and
    below the median height of the reference's balls), and whole by the second method."""
    height = Grid(RESOLUTION).nodes[:, None]
    upper = height >= reference.middle
    return {
        "whole": overlap(curtain.region, reference.region),
        "upper": overlap(curtain.region, reference.region, upper),
        "lower": overlap(curtain.region, reference.region, ~upper),
        "second_method": overlap(curtain.banded, reference.banded),
    }


def flow_errors(charge: Charge, reference: Charge) -> Errors:
    """Difference and correlation of the mass in the box, in the fixed and the rotating frame;
    None for series without it. Keys: FLOW_ERRORS."""
    errors: Errors = dict.fromkeys(FLOW_ERRORS)
    for frame, column in FRAMES.items():
        if not (charge.has(column) and reference.has(column)):
            continue
        ours, theirs = charge.series, reference.series
        compared = compare_flow(
            ours["mill_angle_rad"], ours[column], theirs["mill_angle_rad"], theirs[column]
        )
        prefix = "massflow_" if frame == "fixed" else f"massflow_{frame}_"
        errors |= {f"{prefix}{name}": value for name, value in compared.items()}
    return errors


def power_error(charge: Charge, reference: Charge) -> float | None:
    """Mean power over M g R omega, relative to that of the reference."""
    ours, theirs = (c.result["dimensionless"]["power"] for c in (charge, reference))
    return ours / theirs - 1.0 if theirs else None


def mean_known(values) -> float | None:
    """Mean of the values that are not None; None if there is none."""
    known = [value for value in values if value is not None]
    return float(np.mean(known)) if known else None


def deviation(values: Sequence[float | None]) -> float | None:
    """Standard deviation (n - 1) of the values that are not None; None below two."""
    known = [value for value in values if value is not None]
    return float(np.std(known, ddof=1)) if len(known) > 1 else None
