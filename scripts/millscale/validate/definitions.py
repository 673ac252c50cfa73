"""Definitions of observables compared by how they extrapolate: `millscale validate definitions`.

Each observable is measured by several definitions in the scaled mills of one physical mill. A
definition is useful if its value changes steadily with S, and if the value at S = 1 lies in the
interval extrapolated from the scaled mills alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

from millscale.analysis.finished import Charge
from millscale.analysis.shapes.curtain import IN_FLIGHT, RESOLUTION
from millscale.analysis.shapes.shape import (
    END_CIRCLE,
    STATE,
    Shape,
    contour_grid,
    end_circle,
    shape_of,
    snapshots_at,
    unit_length,
    wanted_angles,
)
from millscale.analysis.shapes.solid_fraction import Grid, solid_fraction
from millscale.analysis.shapes.surface_ends import SurfaceEnds, surface_ends
from millscale.analysis.shapes.throw_angle import launch_points
from millscale.engine.record import provenance
from millscale.errors import PredictionError
from millscale.prediction.extrapolation import Group, by_ratio, extrapolate, scale_function
from millscale.prediction.kinds import Kind
from millscale.prediction.selection import check_one_mill, chosen_scaling, usable_charges
from millscale.report.figures.style import STYLE
from millscale.runs.case_file import Case
from millscale.runs.dumps import Dump, read_dump
from millscale.runs.writing import write_json

Row = dict[str, Any]
OUTERMOST = "c_detach[23]"  # of compute mill/detach: docs/reference/styles/compute-mill-detach.md
CIRCLES = (0.8, 0.85, 0.9, 0.95, 0.97)  # of the lifter tops' radius
EXPONENTS = (0.0, 0.5, 1.0)  # with which maps are extrapolated


@dataclass(frozen=True)
class View:
    """One dump and its shape.

    Attributes:
        launches: (n, 2) float [x, z], where the flights of balls in flight began [m].
        outermost: (n,) bool, flights from the layer next to the liner.
    """

    dump: Dump
    case: Case
    shape: Shape
    launches: np.ndarray
    outermost: np.ndarray

    def ends(self, circle: float) -> SurfaceEnds | None:
        """Return toe and shoulder on a circle over that of the lifter tops."""
        radius = circle / END_CIRCLE * end_circle(self.case)
        return surface_ends(self.shape.contour, contour_grid(self.case), radius)

    def launch_angles(self, circle: float) -> np.ndarray:
        """Return the launch angles of flights that began above the axis, outside a circle [rad]."""
        x, z = self.launches.T
        radius = circle / END_CIRCLE * end_circle(self.case) * unit_length(self.case)
        return np.arctan2(-x, z)[(z > 0.0) & (np.hypot(x, z) > radius)]

    def outermost_angles(self, from_tops: bool = False) -> np.ndarray:
        """Return the launch angles of the layer next to the liner, above the axis [rad].

        Args:
            from_tops: only of flights that began no deeper in a pocket than a ball radius.
        """
        x, z = self.launches.T
        chosen = (z > 0.0) & self.outermost
        if from_tops:
            tops = self.case.mill.lifter_top_radius_m
            chosen &= np.hypot(x, z) < tops + self.case.ball.radius_m
        return np.arctan2(-x, z)[chosen]


@dataclass(frozen=True)
class Definition:
    """One way to measure an observable; `of_dump` gives a value of each dump, `of_charge` one of
    the whole charge."""

    observable: str
    name: str
    factor: float
    unit: str
    of_dump: Callable[[View], float | None] | None = None
    of_charge: Callable[[Charge], float | None] | None = None


def _ring_end(charge: Charge, column: str) -> float | None:
    return charge.steady_mean(column)


def _end(circle: float, read: Callable[[SurfaceEnds], float]) -> Callable[[View], float | None]:
    def of_dump(view: View) -> float | None:
        ends = view.ends(circle)
        return None if ends is None else read(ends)

    return of_dump


def _definitions() -> list[Definition]:
    degree = math.degrees(1.0)
    found = []
    for observable, column, read in (
        ("toe", "toe_angle_rad", lambda ends: ends.toe),
        ("shoulder", "shoulder_angle_rad", lambda ends: ends.shoulder),
    ):
        ring = "ring one ball diameter wide"
        found.append(
            Definition(observable, ring, degree, "deg", of_charge=partial(_ring_end, column=column))
        )
        for circle in CIRCLES:
            name = f"contour at {circle:g} of the lifter tops"
            found.append(Definition(observable, name, degree, "deg", _end(circle, read)))
    throws: tuple[tuple[str, Callable[[View], np.ndarray], Callable], ...] = (
        ("layer next to the liner, mean", View.outermost_angles, np.mean),
        ("the same, begun at the lifter tops", lambda view: view.outermost_angles(True), np.mean),
        ("all flights, mean", lambda view: view.launch_angles(0.0), np.mean),
        ("all flights, median", lambda view: view.launch_angles(0.0), np.median),
        ("begun outside 0.9, median", lambda view: view.launch_angles(0.9), np.median),
        ("begun outside 0.95, median", lambda view: view.launch_angles(0.95), np.median),
    )
    for name, angles, middle in throws:
        found.append(Definition("throw angle", name, degree, "deg", _middle(angles, middle)))
    shares: tuple[tuple[str, Callable[[View], float | None]], ...] = (
        ("without contact", lambda view: float(np.mean(view.dump[STATE] == IN_FLIGHT))),
        ("in a confirmed flight", lambda view: len(view.launches) / len(view.dump)),
        ("in curtains", lambda view: view.shape.curtain_share),
    )
    found += [Definition("share in flight", name, 100.0, "%", share) for name, share in shares]
    layer: tuple[tuple[str, Callable[[View], float | None]], ...] = (
        ("in a confirmed flight", lambda v: len(v.outermost_angles()) / len(v.dump)),
        (
            "the same, begun at the lifter tops",
            lambda v: len(v.outermost_angles(True)) / len(v.dump),
        ),
    )
    found += [Definition("layer next to the liner", name, 100.0, "%", x) for name, x in layer]
    width = Definition(
        "curtains", "width over R - a", 100.0, "%", lambda view: view.shape.curtain_width
    )
    return [*found, width]


def _middle(
    angles: Callable[[View], np.ndarray], middle: Callable[[np.ndarray], Any]
) -> Callable[[View], float | None]:
    def of_dump(view: View) -> float | None:
        known = angles(view)
        return float(middle(known)) if len(known) else None

    return of_dump


@dataclass(frozen=True)
class Measured:
    """Values of a charge by definition, and the map of its curtains: balls in curtains over all
    balls and area over (R - a)^2."""

    values: dict[Definition, float]
    curtains: np.ndarray


def measure_charge(charge: Charge, definitions: Sequence[Definition]) -> Measured:
    """Measure a charge by all definitions, in the mean over the dumps of its steady window."""
    angles = [
        angle
        for angle in wanted_angles(charge.result.rotation_angle_rad)
        if charge.steady_from <= angle <= charge.result.mean_to_rad
    ]
    by_dump: dict[Definition, list[float]] = {}
    centres, balls, dumps = [np.empty((0, 2))], 0, 0
    for snapshot in snapshots_at(charge.folder, angles).values():
        dump = read_dump(snapshot.path)
        shape = shape_of(dump, snapshot, charge.case)
        flying, launches = launch_points(dump, charge.case)
        view = View(dump, charge.case, shape, launches, dump[OUTERMOST][flying] == 1.0)
        for definition in definitions:
            value = definition.of_dump(view) if definition.of_dump else None
            if value is not None:
                by_dump.setdefault(definition, []).append(value)
        centres += [curtain.centres for curtain in (shape.curtains or {}).values()]
        balls, dumps = balls + len(dump), dumps + 1
    values = {definition: float(np.mean(known)) for definition, known in by_dump.items()}
    of_charge = {x: x.of_charge(charge) for x in definitions if x.of_charge}
    values |= {x: value for x, value in of_charge.items() if value is not None}
    every = np.vstack(centres)
    field = solid_fraction(every, np.full(len(every), 1.0 / max(balls, 1)), Grid(RESOLUTION))
    return Measured(values, field)


def row_of(definition: Definition, measured: Mapping[Charge, Measured]) -> Row:
    """Return the values of a definition by S, what its scaled mills predict, and whether the
    interval holds the value at S = 1."""
    known = [
        (charge.S, definition.factor * found.values[definition])
        for charge, found in measured.items()
        if definition in found.values
    ]
    groups = [Group(S, tuple(values)) for S, values in by_ratio(known)]
    scaled = [group for group in groups if group.S > 1.0]
    physical = next((group.mean for group in groups if group.S == 1.0), None)
    # No definition has the advantage of a narrow prior.
    found = extrapolate(scaled, prior=Kind.UNKNOWN.prior)
    means = [group.mean for group in groups]
    return {
        "observable": definition.observable,
        "definition": definition.name,
        "unit": definition.unit,
        "by_S": [
            {
                "S": group.S,
                "mean": group.mean,
                "deviation": float(np.std(group.values, ddof=1)) if len(group.values) > 1 else None,
                "runs": len(group.values),
            }
            for group in groups
        ],
        "is_monotonic": bool(np.all(np.diff(means) > 0.0) or np.all(np.diff(means) < 0.0)),
        "predicted": asdict(found),
        "physical": physical,
        "is_inside": None if physical is None else found.lower <= physical <= found.upper,
    }


def maps_of(measured: Mapping[Charge, Measured]) -> list[Row]:
    """Return distances of the maps of curtains from that of S = 1.

    A distance is half of the integral of the absolute difference, over the share in curtains at
    S = 1 (*raw*), or of maps that are divided by their own share (*normalized*): 0 for equal maps,
    1 for maps that do not overlap. The two nearest values of S are extrapolated point by point.
    """
    area = Grid(RESOLUTION).step ** 2
    groups = by_ratio((charge.S, found.curtains) for charge, found in measured.items())
    raw = {S: np.mean(fields, axis=0) for S, fields in groups}
    shape = {S: np.mean([_normalized(x) for x in fields], axis=0) for S, fields in groups}
    truth, share = raw[1.0], float(raw[1.0].sum() * area)

    def row(name: str, field: np.ndarray, normalized: np.ndarray, total: float) -> Row:
        both = total * normalized / area
        return {
            "map": name,
            "share": total,
            "raw": 0.5 * float(np.abs(field - truth).sum()) * area / share,
            "normalized": 0.5 * float(np.abs(normalized - shape[1.0]).sum()),
            "share_times_normalized": 0.5 * float(np.abs(both - truth).sum()) * area / share,
        }

    rows = []
    for S, fields in groups:
        if S == 1.0:
            continue
        rows.append(row(f"S = {S:g}", raw[S], shape[S], float(raw[S].sum() * area)))
        if len(fields) > 1:
            pair = [_normalized(field) for field in fields[:2]]
            rows[-1]["between_two_seeds"] = 0.5 * float(np.abs(pair[0] - pair[1]).sum())
    near, far = sorted(S for S in raw if S > 1.0)[:2]
    for p in EXPONENTS:
        to_far, to_near = float(scale_function(far, p)), float(scale_function(near, p))
        weight = to_far / (to_far - to_near)
        field, form = (weight * x[near] + (1.0 - weight) * x[far] for x in (raw, shape))
        form = np.maximum(form, 0.0)
        total = float(field.sum() * area)
        rows.append(row(f"S = {near:g} and {far:g}, p = {p:g}", field, form / form.sum(), total))
    return rows


def _normalized(field: np.ndarray) -> np.ndarray:
    return field / field.sum()


def write_definitions(
    folders: Sequence[Path], docs: Path, scheme: str | None, policy: str | None
) -> None:
    """Write results/observable-definitions.json and .png.

    Args:
        folders: runs folders of one physical mill, S = 1 among them.
        scheme, policy: of the scaled mills to use, where the folders hold several.
    """
    charges, _ = usable_charges(folders)
    scheme, policy = chosen_scaling(charges, scheme, policy)
    used = [x for x in charges if x.case.is_physical or (x.scheme, x.policy) == (scheme, policy)]
    check_one_mill(used)
    if not any(charge.case.is_physical for charge in used):
        raise PredictionError("no finished charge of S = 1: its values are what is compared with")
    definitions = _definitions()
    measured = {charge: measure_charge(charge, definitions) for charge in used}
    document = {
        "schema": 1,
        **provenance(),
        "scheme": scheme,
        "policy": policy,
        "runs": [charge.id for charge in used],
        "definitions": [row_of(definition, measured) for definition in definitions],
        "maps_of_curtains": maps_of(measured),
    }
    file = docs / "results/observable-definitions.json"
    write_json(file, document)
    draw(document, file.with_suffix(".png"))


def draw(document: Row, file: Path) -> None:
    """Draw shoulder, toe, throw angle and share in flight by each definition against S."""
    names = ("toe", "shoulder", "throw angle", "share in flight")
    with rc_context(STYLE):
        figure = Figure(figsize=(9.0, 7.0), layout="constrained")
        for axes, name in zip(figure.subplots(2, 2).flat, names, strict=True):
            rows = [row for row in document["definitions"] if row["observable"] == name]
            for row in rows:
                S = [value["S"] for value in row["by_S"]]
                bars = [value["deviation"] or 0.0 for value in row["by_S"]]
                means = [value["mean"] for value in row["by_S"]]
                axes.errorbar(S, means, bars, marker="o", ms=3.5, capsize=2,
                              label=row["definition"])  # fmt: skip
            axes.set(xlabel="S", ylabel=f"{name} [{rows[0]['unit']}]")
            axes.legend(fontsize="x-small")
        figure.savefig(file, dpi=110)
