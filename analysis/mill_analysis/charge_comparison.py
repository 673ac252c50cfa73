"""Every multi-ball case against its reference: rows of results.json and the shapes to draw."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mill_analysis.charge_errors import (
    FLOW_ERRORS,
    SHAPE_ERRORS,
    flow_errors,
    mean_known,
    power_error,
    shape_errors,
)
from mill_analysis.charge_models import Charge, pairs, reference_of, seeds_of
from mill_analysis.seed_spread import with_seed_spread
from mill_analysis.shapes import Shape, case_shapes, contour_grid, wanted_angles

Row = dict[str, Any]
Key = tuple[str, str]
CONTOURS_DRAWN = 4
SERIES_MEANS = ("toe_angle_rad", "shoulder_angle_rad")


@dataclass(frozen=True)
class ChargeComparison:
    """All charges against their references.

    Attributes:
        rows: one for each charge; keys and units: docs/files.md.
        schemes: rows of constant speed against constant gravity at the same S.
        shapes: by mill angle [rad] and charge (campaign and id), at the angles to draw.
    """

    charges: list[Charge]
    rows: list[Row]
    schemes: list[Row]
    shapes: dict[float, dict[Key, Shape]]

    @property
    def last_angle(self) -> float | None:
        """Last mill angle with shapes [rad]."""
        return max((angle for angle, shapes in self.shapes.items() if shapes), default=None)


def compare_charges(charges: Sequence[Charge]) -> ChargeComparison:
    """Compare every charge with `charge_models.reference_of` it, seeds with each other and the
    schemes at the same S. Reads each dump once; holds the shapes of one mill angle at a time,
    besides those to draw."""
    charges = list(charges)
    compared = _compared_pairs(charges)
    end = max((charge.result["rotation_angle_rad"] for charge in charges), default=0.0)
    angles = wanted_angles(end)
    drawn = _drawn_angles(charges)
    kept: dict[float, dict[Key, Shape]] = {}
    errors: dict[tuple[Key, Key], dict[float, Row]] = {pair: {} for pair in compared}
    for angle in angles:
        shapes = _shapes_at(charges, angle)
        for ours, theirs in compared:
            if ours in shapes and theirs in shapes:
                errors[ours, theirs][angle] = shape_errors(shapes[ours], shapes[theirs])
        if angle in drawn:
            kept[angle] = shapes
    last = kept[max(kept)] if kept else {}
    whole = {pair: _all_errors(*charges_of, errors[pair]) for pair, charges_of in compared.items()}
    rows = [_row(charge, charges, whole, last.get(charge.key)) for charge in charges]
    with_seed_spread(rows, charges, whole)
    return ChargeComparison(charges, rows, _scheme_rows(charges, whole), kept)


def twin_of(charge: Charge, charges: Sequence[Charge]) -> Charge | None:
    """The same model and seed at constant gravity, of a charge at constant speed; of its own
    campaign if possible."""
    if charge.case["scheme"] != "constant-speed":
        return None
    twins = [
        other
        for other in charges
        if other.case["scheme"] == "constant-gravity"
        and other.model[2:] == charge.model[2:]
        and other.case["seed"] == charge.case["seed"]
        and other.case["ball"]["count"] == charge.case["ball"]["count"]
    ]
    return min(twins, key=lambda other: other.campaign != charge.campaign, default=None)


def _compared_pairs(charges: list[Charge]) -> dict[tuple[Key, Key], tuple[Charge, Charge]]:
    found = [(charge, reference_of(charge, charges)) for charge in charges]
    found += [(charge, twin_of(charge, charges)) for charge in charges]
    for charge in charges:
        seeds = seeds_of(charge, charges)
        if seeds[0] is charge:
            found += pairs(seeds)
    return {(a.key, b.key): (a, b) for a, b in found if b is not None and b is not a}


def _drawn_angles(charges: list[Charge]) -> set[float]:
    """CONTOURS_DRAWN angles, evenly to the last that every charge has reached."""
    shortest = min((charge.result["rotation_angle_rad"] for charge in charges), default=0.0)
    angles = wanted_angles(shortest)
    if not angles:
        return set()
    steps = np.linspace(0, len(angles), CONTOURS_DRAWN + 1)[1:]
    return {angles[max(0, round(step) - 1)] for step in steps}


def _shapes_at(charges: list[Charge], angle: float) -> dict[Key, Shape]:
    shapes = {}
    for charge in charges:
        if angle <= charge.result["rotation_angle_rad"] + 0.1:
            shape = case_shapes(charge.finished, [angle]).get(angle)
            if shape is not None:
                shapes[charge.key] = shape
    return shapes


def _all_errors(charge: Charge, reference: Charge, by_angle: dict[float, Row]) -> Row:
    """Errors of one charge against another: shapes at the last common mill angle and in the mean
    over the second half of the rotation, mass flow, power."""
    last = max(by_angle, default=None)
    at_last = by_angle[last] if last is not None else shape_errors(None, None)
    steady = {angle: row for angle, row in by_angle.items() if angle >= 0.5 * last}
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


def _row(charge: Charge, charges: list[Charge], errors: dict, shape: Shape | None) -> Row:
    case, reference = charge.case, reference_of(charge, charges)
    measured = errors.get((charge.key, reference.key), _no_errors(shape))
    same_ranks = charge.timing["ranks"] == reference.timing["ranks"]
    series_means = {name: _mean_of_second_half(charge, name) for name in SERIES_MEANS}
    return {
        "campaign": charge.campaign,
        **{key: case[key] for key in ("id", "scheme", "policy", "S", "seed")},
        "stiffness": charge.stiffness,
        "balls": case["ball"]["count"],
        "total_mass_kg": charge.mass,
        "balls_per_length_scaled_1_m": charge.filling,
        "simulated_length_m": case["mill"]["simulated_length_m"],
        "reference": reference.id,
        "reference_campaign": reference.campaign,
        "reference_S": reference.S,
        "is_reference": reference is charge,
        "wall_time_s": charge.timing["wall_time_s"],
        "ranks": charge.timing["ranks"],
        "speed_up": reference.timing["wall_time_s"] / charge.timing["wall_time_s"]
        if same_ranks
        else None,
        "power_W": charge.result["mean"]["power_W"],
        "power_dimensionless": charge.result["dimensionless"]["power"],
        "max_overlap": charge.result["largest_overlap_over_radius"],
        **series_means,
        "contour_resolution": contour_grid(case).resolution,
        **_of_shape(shape),
        **measured,
        "not_measured": _not_measured(charge, shape),
    }


def _no_errors(shape: Shape | None) -> Row:
    """The errors of a reference: none."""
    return {
        "mill_angle_rad": shape.mill_angle if shape else None,
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


def _mean_of_second_half(charge: Charge, column: str) -> float | None:
    if not charge.has(column):
        return None
    angle = charge.series["mill_angle_rad"]
    return float(np.mean(charge.series[column][angle >= 0.5 * angle[-1]]))


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


def _scheme_rows(charges: list[Charge], errors: dict) -> list[Row]:
    """Constant speed against constant gravity at the same S, stiffness and seed."""
    rows = []
    for charge in charges:
        twin = twin_of(charge, charges)
        if twin is None:
            continue
        ours, theirs = charge.result["dimensionless"], twin.result["dimensionless"]
        measured = errors[charge.key, twin.key]
        rows.append(
            {
                **{key: charge.case[key] for key in ("policy", "S", "seed")},
                "stiffness": charge.stiffness,
                "constant_speed": charge.id,
                "constant_gravity": twin.id,
                "dimensionless": {
                    name: {"constant_speed": ours[name], "constant_gravity": theirs[name]}
                    for name in ours
                },
                **measured,
                "between_seeds": None,
            }
        )
    return rows
