"""Charges measured by themselves and in pairs, dump by dump; mill angles on all processors."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from millscale.analysis.charge.pair_errors import OF_DUMPS, Dumps, PairErrors, errors_of_dumps
from millscale.analysis.charge.scaled_mills import Pair
from millscale.analysis.finished import Charge
from millscale.analysis.forked import forked
from millscale.analysis.means import mean_known
from millscale.analysis.measures import NUMBERS, QUANTITIES, Quantity, Taken, Value
from millscale.analysis.shapes.shape import Shape, shape_of, snapshots_at, wanted_angles
from millscale.analysis.shapes.snapshots import Snapshot
from millscale.analysis.shapes.velocity_field import VelocityField, velocity_field
from millscale.runs.dumps import read_dump
from millscale.runs.untrusted import RunFolderError

SHAPES_KEPT = 4
ByAngle = dict[float, float]


@dataclass(frozen=True)
class Measured:
    """Charges measured by themselves and in pairs.

    Attributes:
        numbers: by charge, the numbers of `measures.NUMBERS` by name.
        errors: of the first of two charges against the second.
        shapes: by mill angle [rad] and charge, at the angles to draw.
        velocities: by charge, over the dumps in the steady part of the rotation.
        problems: by charge, dumps that are missing or could not be read.
    """

    numbers: dict[Charge, dict[str, float | None]] = field(default_factory=dict)
    errors: dict[Pair, PairErrors] = field(default_factory=dict)
    shapes: dict[float, dict[Charge, Shape]] = field(default_factory=dict)
    velocities: dict[Charge, VelocityField] = field(default_factory=dict)
    problems: dict[Charge, list[RunFolderError]] = field(default_factory=dict)

    @property
    def last_angle(self) -> float | None:
        """Return the last mill angle with shapes [rad]."""
        return max((angle for angle, shapes in self.shapes.items() if shapes), default=None)

    def last_shape(self, charge: Charge) -> Shape | None:
        """Return the shape of a charge at the last mill angle; None without a dump there."""
        return self.shapes.get(max(self.shapes, default=0.0), {}).get(charge)


@dataclass(frozen=True)
class _AtAngle:
    """What is measured at one mill angle; charges and pairs by their places in lists.

    Attributes:
        shapes: at an angle to draw.
        problems: dumps that could not be read.
    """

    numbers: dict[tuple[int, str], float]
    errors: dict[int, dict[str, Value]]
    shapes: dict[int, Shape]
    velocities: dict[int, VelocityField]
    problems: dict[int, RunFolderError]


def measure(charges: Sequence[Charge], pairs: Iterable[Pair]) -> Measured:
    """Return charges measured by themselves and in pairs.

    Reads each dump once, and of those before the steady part only what is drawn or compared as the
    last. A process holds the shapes of one mill angle at a time, besides those to draw.
    """
    measured = Measured(problems={charge: [] for charge in charges})
    snapshots = {charge: _snapshots(charge, measured) for charge in charges}
    kept, every = _kept_angles(list(snapshots.values())), list(pairs)
    snapshots = _needed(snapshots, kept, every)
    numbers: dict[tuple[Charge, str], ByAngle] = {}
    errors: dict[Pair, dict[float, dict[str, Value]]] = {pair: {} for pair in every}
    angles = sorted(set().union(*snapshots.values()))
    at_angles = forked(lambda angle: _measure_at(angle, snapshots, every, angle in kept), angles)
    for angle, found in zip(angles, at_angles, strict=True):
        for (i, name), value in found.numbers.items():
            numbers.setdefault((charges[i], name), {})[angle] = value
        for i, row in found.errors.items():
            errors[every[i]][angle] = row
        for i, velocity in found.velocities.items():
            known = measured.velocities.get(charges[i])
            measured.velocities[charges[i]] = known + velocity if known else velocity
        for i, problem in found.problems.items():
            measured.problems[charges[i]].append(problem)
        if angle in kept:
            measured.shapes[angle] = {charges[i]: shape for i, shape in found.shapes.items()}
    for charge in charges:
        measured.numbers[charge] = _numbers(charge, numbers, measured.problems[charge])
    for pair, by_angle in errors.items():
        measured.errors[pair] = _pair_errors(pair, by_angle, numbers)
    return measured


def _needed(
    snapshots: Mapping[Charge, dict[float, Snapshot]], kept: set[float], pairs: Sequence[Pair]
) -> dict[Charge, dict[float, Snapshot]]:
    """Return the dumps in the steady part of each charge, at the angles to draw, and at the last
    angle that two charges have in common."""
    common = [snapshots[ours].keys() & snapshots[theirs].keys() for ours, theirs in pairs]
    wanted = kept | {max(angles) for angles in common if angles}
    return {
        charge: {x: s for x, s in found.items() if x >= charge.steady_from or x in wanted}
        for charge, found in snapshots.items()
    }


def _measure_at(
    angle: float,
    snapshots: Mapping[Charge, Mapping[float, Snapshot]],
    pairs: Sequence[Pair],
    is_kept: bool,
) -> _AtAngle:
    """Return what is measured at one mill angle of the charges with a dump there."""
    shapes: dict[Charge, Shape] = {}
    found = _AtAngle({}, {}, {}, {}, {})
    for i, (charge, by_angle) in enumerate(snapshots.items()):
        if angle not in by_angle:
            continue
        try:
            dump = read_dump(by_angle[angle].path)
            shape = shape_of(dump, by_angle[angle], charge.case)
        except RunFolderError as error:
            found.problems[i] = error
            continue
        shapes[charge] = shape
        if is_kept:
            found.shapes[i] = shape
        for quantity in _averaged():
            if (value := quantity.read(shape)) is not None:
                found.numbers[i, quantity.name] = value
        if angle >= charge.steady_from and (velocity := velocity_field(dump, charge.case)):
            found.velocities[i] = velocity
    for i, (ours, theirs) in enumerate(pairs):
        if ours in shapes and theirs in shapes:
            found.errors[i] = errors_of_dumps(shapes[ours], shapes[theirs])
    return found


def _averaged() -> list[Quantity]:
    return [quantity for quantity in QUANTITIES if quantity.taken is Taken.AVERAGED]


def _numbers(
    charge: Charge,
    of_dumps: Mapping[tuple[Charge, str], ByAngle],
    problems: list[RunFolderError],
) -> dict[str, float | None]:
    """Return the numbers of a charge by name; those of dumps in the mean over the steady part.

    Args:
        problems: gets the files that could not be read.
    """

    def value(quantity: Quantity) -> float | None:
        if quantity.taken is Taken.ONCE:
            try:
                return quantity.read(charge)
            except RunFolderError as error:
                if str(error) not in map(str, problems):
                    problems.append(error)
                return None
        known = of_dumps.get((charge, quantity.name), {})
        return mean_known(x for angle, x in known.items() if angle >= charge.steady_from)

    return {quantity.name: value(quantity) for quantity in NUMBERS}


def _pair_errors(
    pair: Pair,
    by_angle: Mapping[float, dict[str, Value]],
    of_dumps: Mapping[tuple[Charge, str], ByAngle],
) -> PairErrors:
    last = max(by_angle, default=None)
    begin = max(charge.steady_from for charge in pair)
    steady = {angle: row for angle, row in by_angle.items() if angle >= begin}
    values: dict[str, Value] = {}
    for quantity in QUANTITIES:
        if quantity.taken is Taken.AT_DUMPS:
            at_last = by_angle[last] if last is not None else quantity.compared(None, None)
            values |= {error.name: at_last[error.name] for error in quantity.errors}
        elif quantity.errors:
            values |= quantity.compared(*_of_pair(quantity, pair, begin, of_dumps))
    over_angles = {name: mean_known(row[name] for row in steady.values()) for name in OF_DUMPS}
    return PairErrors(values, over_angles, Dumps(last, min(steady, default=None), len(steady)))


def _of_pair(
    quantity: Quantity,
    pair: Pair,
    begin: float,
    of_dumps: Mapping[tuple[Charge, str], ByAngle],
) -> tuple:
    """Return a quantity of two charges; of dumps its means over the steady mill angles that both
    have."""
    if quantity.taken is Taken.ONCE:
        return tuple(quantity.read(charge) for charge in pair)
    ours, theirs = (of_dumps.get((charge, quantity.name), {}) for charge in pair)
    common = [angle for angle in ours.keys() & theirs.keys() if angle >= begin]
    return tuple(mean_known(known[angle] for angle in common) for known in (ours, theirs))


def _snapshots(charge: Charge, measured: Measured) -> dict[float, Snapshot]:
    angles = wanted_angles(charge.result.rotation_angle_rad)
    try:
        return snapshots_at(charge.folder, angles)
    except RunFolderError as error:
        measured.problems[charge].append(error)
        return {}


def _kept_angles(snapshots: list[dict[float, Snapshot]]) -> set[float]:
    """Return SHAPES_KEPT angles, evenly to the last at which every charge with dumps has one."""
    known = [set(found) for found in snapshots if found]
    angles = sorted(set.intersection(*known) or set.union(*known)) if known else []
    steps = np.linspace(0, len(angles), SHAPES_KEPT + 1)[1:]
    return {angles[max(0, round(step) - 1)] for step in steps} if angles else set()
