"""Every multi-ball case against its reference: rows of results.json and the shapes to draw."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from millscale.analysis.charge.errors import shape_errors
from millscale.analysis.charge.rows import Last, all_errors, charge_row
from millscale.analysis.charge.scaled_mills import Charge, pairs, reference_of, seeds_of
from millscale.analysis.charge.seed_spread import with_seed_spread
from millscale.analysis.shapes.shape import Shape, shape_of, snapshots_at, wanted_angles
from millscale.analysis.shapes.snapshots import Snapshot
from millscale.runs.case_folder import RunFolderError
from millscale.runs.dumps import read_dump

Row = dict[str, Any]
Key = tuple[str, str]
Pairs = dict[tuple[Key, Key], tuple[Charge, Charge]]
CONTOURS_DRAWN = 4


@dataclass(frozen=True)
class ChargeComparison:
    """All charges against their references.

    Attributes:
        rows: one for each charge; keys and units: docs/reference/files.md.
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
    schemes at the same S."""
    charges = list(charges)
    measured = measure_pairs(charges, _compared_pairs(charges))
    whole, kept = measured.errors, measured.shapes
    last = max(kept, default=None)
    rows = [
        charge_row(charge, charges, whole, Last(last, kept.get(last, {}).get(charge.key)))
        for charge in charges
    ]
    for row, charge in zip(rows, charges, strict=True):
        row["not_measured"] += measured.problems[charge.key]
    with_seed_spread(rows, charges, whole)
    return ChargeComparison(charges, rows, _scheme_rows(charges, whole, rows), kept)


@dataclass(frozen=True)
class Measured:
    """Charges measured in pairs.

    Attributes:
        errors: `charge_rows.all_errors` of the first of two charges against the second.
        throw_angles: by charge and mill angle [rad], of the dumps that tell it [rad].
        steady_from: by charge, mill angle at which the window of its means begins [rad].
        shapes: as in `ChargeComparison`.
        problems: by charge, dumps that could not be read.
    """

    errors: dict[tuple[Key, Key], Row]
    throw_angles: dict[Key, dict[float, float]]
    steady_from: dict[Key, float]
    shapes: dict[float, dict[Key, Shape]]
    problems: dict[Key, list[str]]


def measure_pairs(charges: Sequence[Charge], compared: Pairs) -> Measured:
    """Measure pairs of charges. Reads each dump once; holds the shapes of one mill angle at a time,
    besides those to draw."""
    snapshots = {charge.key: _snapshots(charge) for charge in charges}
    drawn = _drawn_angles(list(snapshots.values()))
    measured = Measured(
        errors={},
        throw_angles={charge.key: {} for charge in charges},
        steady_from={charge.key: charge.steady_from for charge in charges},
        shapes={},
        problems={charge.key: [] for charge in charges},
    )
    by_angle: dict[tuple[Key, Key], dict[float, Row]] = {pair: {} for pair in compared}
    for angle in sorted(set().union(*snapshots.values())):
        shapes = _shapes_at(angle, charges, snapshots, measured.problems)
        for key, shape in shapes.items():
            if shape.throw_angle is not None:
                measured.throw_angles[key][angle] = shape.throw_angle
        for ours, theirs in compared:
            if ours in shapes and theirs in shapes:
                by_angle[ours, theirs][angle] = shape_errors(shapes[ours], shapes[theirs])
        if angle in drawn:
            measured.shapes[angle] = shapes
    for pair, both in compared.items():
        measured.errors[pair] = all_errors(*both, by_angle[pair])
    return measured


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


def _compared_pairs(charges: list[Charge]) -> Pairs:
    found = [(charge, reference_of(charge, charges)) for charge in charges]
    found += [(charge, twin_of(charge, charges)) for charge in charges]
    for charge in charges:
        seeds = seeds_of(charge, charges)
        if seeds[0] is charge:
            found += pairs(seeds)
    return {(a.key, b.key): (a, b) for a, b in found if b is not None and b is not a}


def _snapshots(charge: Charge) -> dict[float, Snapshot]:
    try:
        return snapshots_at(charge.finished, wanted_angles(charge.result["rotation_angle_rad"]))
    except RunFolderError:  # no dumps: the row says that nothing was measured
        return {}


def _drawn_angles(snapshots: list[dict[float, Snapshot]]) -> set[float]:
    """CONTOURS_DRAWN angles, evenly to the last at which every charge with dumps has one."""
    known = [set(found) for found in snapshots if found]
    angles = sorted(set.intersection(*known) or set.union(*known)) if known else []
    steps = np.linspace(0, len(angles), CONTOURS_DRAWN + 1)[1:]
    return {angles[max(0, round(step) - 1)] for step in steps} if angles else set()


def _shapes_at(
    angle: float,
    charges: Sequence[Charge],
    snapshots: dict[Key, dict[float, Snapshot]],
    problems: dict[Key, list[str]],
) -> dict[Key, Shape]:
    """Shapes of all charges with a dump at a mill angle; a dump that cannot be read is noted."""
    shapes = {}
    for charge in charges:
        snapshot = snapshots[charge.key].get(angle)
        if snapshot is None:
            continue
        try:
            shapes[charge.key] = shape_of(read_dump(snapshot.path), snapshot, charge.case)
        except RunFolderError as error:
            problems[charge.key].append(str(error))
    return shapes


def _scheme_rows(charges: list[Charge], errors: dict, of_charges: list[Row]) -> list[Row]:
    """Constant speed against constant gravity at the same S, stiffness and seed, with what two
    seeds of the latter differ by."""
    spread = {(row["campaign"], row["id"]): row["between_seeds"] for row in of_charges}
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
                "between_seeds": spread[twin.key],
            }
        )
    return rows
