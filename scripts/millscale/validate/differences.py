"""How far scaled mills lie from the physical mill, in numbers and curves, and what is chance.

A difference is a vector: one entry for a number, many for a curve. Its size is the error. With n
runs of a scaled mill and m of S = 1 the chance of an error is

    sqrt(s(S)^2 / n + s(1)^2 / m),    s^2 = sum_{i<j} size(d_i - d_j)^2 / n / (n - 1),

which for numbers is the standard error of the difference of two means. The deviation s of one run
is pooled over the policies at one S. An S without two seeds takes that of the nearest S with two.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from millscale.analysis.finished import Charge
from millscale.prediction.contour import displacements, mean_contour, with_normals
from millscale.prediction.extrapolation import SAME_S
from millscale.prediction.mass_flow import pitch_masses
from millscale.prediction.observables import Observable
from millscale.prediction.predict import Prediction
from millscale.runs.untrusted import RunFolderError
from millscale.validate.mills import COUNTED, Mill

# An error of fewer times its chance may be chance.
CHANCES = 2.0


@dataclass(frozen=True)
class Comparison:
    """One way to compare charges of scaled mills with S = 1.

    Attributes:
        unit: of the sizes.
        size: returns the error of a difference; signed for a number.
        differences: of each charge from the mean of S = 1.
        of_prediction: returns the difference of a prediction; None if it has none.
    """

    name: str
    label: str
    unit: str
    size: Callable[[np.ndarray], float]
    differences: Mapping[Charge, np.ndarray]
    of_prediction: Callable[[Prediction], np.ndarray | None] = lambda _: None

    def mean(self, charges: Sequence[Charge]) -> np.ndarray | None:
        """Return the mean difference of the charges that are measured; None without one."""
        known = [self.differences[x] for x in charges if x in self.differences]
        return np.mean(known, axis=0) if known else None


@dataclass(frozen=True)
class Error:
    """An error of a scaled mill, or of a prediction, against S = 1.

    Attributes:
        value: in the unit of its comparison; signed for a number.
        standard_error: of `value`, from the scaled mills' seeds; None if not known.
        chance: of `value`, that of S = 1 included; None if not known.
    """

    value: float
    standard_error: float | None
    chance: float | None

    @property
    def may_be_chance(self) -> bool:
        return self.chance is not None and abs(self.value) <= CHANCES * self.chance


@dataclass(frozen=True)
class Deviations:
    """Standard deviation of one run by S; empty where no S has two seeds."""

    by_S: Mapping[float, float]

    def at(self, S: float) -> float | None:
        """Return the deviation at the S nearest to this one."""
        if not self.by_S:
            return None
        return self.by_S[min(self.by_S, key=lambda other: abs(math.log(other / S)))]


def comparisons(mill: Mill) -> list[Comparison]:
    """Return the comparisons of a mill: all observables, the contour, the mass flow."""
    found = [_of_number(row, mill) for row in COUNTED]
    return [x for x in (*found, *_of_contour(mill), _of_mass_flow(mill)) if x is not None]


def deviations(comparison: Comparison, mill: Mill, scheme: str) -> Deviations:
    """Return the deviations of one run of a scheme, pooled over its policies."""
    groups = [mill.physical]
    for scaling, by_ratio in mill.scaled.items():
        if scaling.scheme == scheme:
            groups += by_ratio.values()
    sums: dict[float, tuple[float, int]] = {}
    for group in groups:
        known = [comparison.differences[x] for x in group if x in comparison.differences]
        if len(known) > 1:
            pairs = itertools.combinations(known, 2)
            squares = math.fsum(comparison.size(a - b) ** 2 for a, b in pairs) / len(known)
            S = next((x for x in sums if abs(x - group[0].S) < SAME_S), group[0].S)
            before, freedom = sums.get(S, (0.0, 0))
            sums[S] = before + squares, freedom + len(known) - 1
    return Deviations({S: math.sqrt(total / freedom) for S, (total, freedom) in sums.items()})


def error_of(
    comparison: Comparison,
    difference: np.ndarray,
    parts: Sequence[tuple[float, Sequence[Charge]]],
    mill: Mill,
    deviation: Deviations,
) -> Error:
    """Return the error of a difference from S = 1.

    Args:
        parts: weight and charges of each scaled mill that the difference comes from.
    """
    value = comparison.size(difference)
    if not deviation.by_S:
        return Error(value, None, None)
    variance = math.fsum(
        weight**2 * (deviation.at(seeds[0].S) or 0.0) ** 2 / len(seeds) for weight, seeds in parts
    )
    physical = (deviation.at(1.0) or 0.0) ** 2 / len(mill.physical)
    return Error(value, math.sqrt(variance), math.sqrt(variance + physical))


def _distance_along_normals(line: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """Return how far a line lies from points of another along the normals there, (n,) float in %
    of R - a; nan where it does not cross a normal.

    Args:
        line, reference: (m, 2) float, over R - a.
    """
    return 100.0 * displacements(*with_normals(reference), line)


def _mean_distance(difference: np.ndarray) -> float:
    return float(np.nanmean(np.abs(difference)))


def _largest_distance(difference: np.ndarray) -> float:
    return float(np.nanmax(np.abs(difference)))


def _root_mean_square(difference: np.ndarray) -> float:
    return float(np.sqrt(np.mean(difference**2)))


def _first(difference: np.ndarray) -> float:
    return float(difference[0])


def _of_number(row: Observable, mill: Mill) -> Comparison | None:
    """Return the comparison of an observable: in degrees, or in percent of S = 1."""
    physical = mill.physical_value(row)
    if not physical:
        return None
    is_angle = row.unit == "deg"
    size = math.radians(1.0) if is_angle else 0.01 * physical
    differences = {
        charge: np.array([(value - physical) / size])
        for charge in mill.charges
        if (value := mill.value(row, charge)) is not None
    }

    def of_prediction(prediction: Prediction) -> np.ndarray | None:
        found = next(x.found for x in prediction.numbers if x.observable.name == row.name)
        return None if found is None else np.array([(found.value - physical) / size])

    unit = "deg" if is_angle else "%"
    return Comparison(row.name, row.label, unit, _first, differences, of_prediction)


def _of_contour(mill: Mill) -> list[Comparison]:
    """Return the comparisons of the surface contour: mean and largest distance."""
    lines = {}
    for charge in mill.charges:
        try:
            lines[charge] = mean_contour(charge)
        except RunFolderError:
            continue
    if not all(charge in lines for charge in mill.physical):
        return []
    reference = lines[mill.physical[0]]
    found = {charge: _distance_along_normals(line, reference) for charge, line in lines.items()}
    middle = np.mean([found[charge] for charge in mill.physical], axis=0)
    differences = {charge: distance - middle for charge, distance in found.items()}
    known = {x: d for x, d in differences.items() if np.isfinite(d).any()}

    def of_prediction(prediction: Prediction) -> np.ndarray | None:
        if prediction.contour is None:
            return None
        difference = _distance_along_normals(prediction.contour.points, reference) - middle
        return difference if np.isfinite(difference).any() else None

    def compared(name: str, label: str, size: Callable[[np.ndarray], float]) -> Comparison:
        return Comparison(f"contour_{name}", f"contour, {label}", "% of R - a", size, known,
                          of_prediction)  # fmt: skip

    return [
        compared("mean", "mean", _mean_distance),
        compared("largest", "largest", _largest_distance),
    ]


def _of_mass_flow(mill: Mill) -> Comparison | None:
    """Return the comparison of the mass in the box over a lifter pitch; None without a box."""
    masses = {charge: pitch_masses(charge) for charge in mill.charges}
    curves = {charge: x.mean(axis=0) for charge, x in masses.items() if x is not None}
    known = [curves[charge] for charge in mill.physical if charge in curves]
    if not known or np.mean(known) <= 0.0:
        return None
    middle = np.mean(known, axis=0)
    unit = 0.01 * middle.mean()

    def of_prediction(prediction: Prediction) -> np.ndarray | None:
        found = prediction.mass_flow
        return None if found is None else (found.values - middle) / unit

    return Comparison(
        "mass_in_box",
        "mass in the box over a lifter pitch, RMS",
        "% of mean",
        _root_mean_square,
        {charge: (curve - middle) / unit for charge, curve in curves.items()},
        of_prediction,
    )
