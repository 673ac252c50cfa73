"""A row of results.json for each multi-ball case."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from millscale.analysis.charge.errors import (
    FLOW_ERRORS,
    SHAPE_ERRORS,
    flow_errors,
    mean_known,
    power_error,
    shape_errors,
)
from millscale.analysis.charge.scaled_mills import Charge, reference_of
from millscale.analysis.shapes.shape import Shape, contour_grid
from millscale.runs.case_folder import RunFolderError, read_json

Row = dict[str, Any]
SERIES_MEANS = ("toe_angle_rad", "shoulder_angle_rad")
SETTLED = ("largest_overlap_over_radius", "bulk_fraction")


@dataclass(frozen=True)
class Last:
    """The last mill angle of the comparison [rad] and the shape of a charge there, None if it has
    no dump at it."""

    mill_angle: float | None
    shape: Shape | None


def all_errors(charge: Charge, reference: Charge, by_angle: dict[float, Row]) -> Row:
    """Errors of one charge against another: shapes at the last common mill angle and in the mean
    over those in the windows of both, mass flow, power."""
    last = max(by_angle, default=None)
    at_last = by_angle[last] if last is not None else shape_errors(None, None)
    begin = max(charge.steady_from, reference.steady_from)
    steady = {angle: row for angle, row in by_angle.items() if angle >= begin}
    return {
        "mill_angle_rad": last,
        **at_last,
        "mean_over_angles": {
            "from_rad": min(steady, default=None),
            "to_rad": last,
            "angles": len(steady),
            **{key: mean_known(row[key] for row in steady.values()) for key in SHAPE_ERRORS},
        },
        **flow_errors(charge, reference),
        "power_error": power_error(charge, reference),
    }


def charge_row(charge: Charge, charges: list[Charge], errors: dict, last: Last) -> Row:
    """What a charge is, what it is compared with, and how far it is from that.

    Args:
        errors: of `all_errors`, by the keys of two charges.
    """
    case, reference = charge.case, reference_of(charge, charges)
    measured = errors.get((charge.key, reference.key), _no_errors(last))
    same_ranks = charge.timing["ranks"] == reference.timing["ranks"]
    series_means = {name: _steady_mean(charge, name) for name in SERIES_MEANS}
    return {
        "campaign": charge.campaign,
        **{key: case[key] for key in ("id", "scheme", "policy", "S", "seed")},
        "stiffness": charge.stiffness,
        "balls": case["ball"]["count"],
        "total_mass_kg": charge.mass,
        "balls_per_length_scaled_1_m": charge.filling,
        "simulated_length_m": case["mill"]["simulated_length_m"],
        "length_share": case["mill"]["simulated_length_m"] / case["mill"]["length_m"],
        "reference": reference.id,
        "reference_campaign": reference.campaign,
        "reference_S": reference.S,
        "is_reference": reference is charge,
        "wall_time_s": charge.timing["wall_time_s"],
        "processor_time_s": charge.timing.get("processor_time_s"),
        "ranks": charge.timing["ranks"],
        "speed_up": _speed_up(charge, reference) if same_ranks else None,
        "power_W": charge.result["mean"]["power_W"],
        "power_dimensionless": charge.result["dimensionless"]["power"],
        "max_overlap": charge.result["largest_overlap_over_radius"],
        **series_means,
        "settled": _settled(charge),
        "contour_resolution": contour_grid(case).resolution,
        **_of_shape(last.shape),
        **measured,
        "not_measured": _not_measured(charge, last.shape),
    }


def _speed_up(charge: Charge, reference: Charge) -> float:
    """In processor time, which a shared machine lengthens less than wall time, where both tell."""
    key = "processor_time_s"
    if not all(each.timing.get(key) for each in (charge, reference)):
        key = "wall_time_s"
    return reference.timing[key] / charge.timing[key]


def _no_errors(last: Last) -> Row:
    """The errors of a reference: none."""
    return {
        "mill_angle_rad": last.mill_angle if last.shape else None,
        **shape_errors(None, None),
        "mean_over_angles": None,
        **dict.fromkeys(FLOW_ERRORS),
        "power_error": None,
    }


def _of_shape(shape: Shape | None) -> Row:
    """What a shape says by itself: distance of the two methods' surfaces, the curtains."""
    if shape is None:
        return {"bulk_fraction": None, "contour_second_method": None, "curtains": None}
    curtains = None
    if shape.curtains is not None:
        curtains = {
            str(n): {"lifter": c.lifter, "balls": len(c.centres), "width": c.width}
            for n, c in shape.curtains.items()
        }
    return {
        "bulk_fraction": shape.contour.bulk_fraction,
        "contour_second_method": shape.method_distance,
        "curtains": curtains,
    }


def _settled(charge: Charge) -> Row:
    """Of the bed at rest, from settled.json: largest overlap over ball radius, bulk fraction."""
    try:
        settled = read_json(charge.finished.folder / "settled.json", "millscale run")
    except RunFolderError:
        settled = {}
    return {name: settled.get(name) for name in SETTLED}


def _steady_mean(charge: Charge, column: str) -> float | None:
    if not charge.has(column):
        return None
    angle = charge.series["mill_angle_rad"]
    inside = (angle >= charge.steady_from) & (angle <= charge.result["mean_to_rad"])
    return float(np.mean(charge.series[column][inside]))


def _not_measured(charge: Charge, shape: Shape | None) -> list[str]:
    """What a row lacks, and why."""
    said = []
    if shape is None:
        said.append("contour, curtains: no dump at the mill angle at which shapes are compared")
    elif shape.curtains is None:
        said.append(f"curtains: {shape.problem}")
    absent = [name for name in ("box_fixed_mass_fraction", *SERIES_MEANS) if not charge.has(name)]
    if absent:
        said.append(f"series.csv has no column {', '.join(absent)}")
    return said
