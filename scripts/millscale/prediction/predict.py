"""Prediction of a physical mill from the finished charges of its scaled mills."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from millscale.analysis.charge.measured import measure
from millscale.analysis.finished import Charge
from millscale.errors import PredictionError
from millscale.prediction.contour import PredictedContour, predict_contour
from millscale.prediction.extrapolation import (
    Extrapolation,
    ExtrapolationError,
    Group,
    Noise,
    by_ratio,
    extrapolate,
)
from millscale.prediction.noise import noise_of
from millscale.prediction.observables import (
    OBSERVABLES,
    Observable,
    PhysicalMill,
    balls_per_length,
    physical_mill,
)
from millscale.prediction.selection import (
    check_one_mill,
    check_scaled_mills,
    chosen_scaling,
    usable_charges,
    warnings_of,
)
from millscale.runs.untrusted import RunFolderError

SCHEMA = 1
# Residuals that only one mill in a hundred would have if the law held refuse the law.
LEAST_RESIDUAL_PROBABILITY = 0.01


@dataclass(frozen=True)
class ScaledValue:
    """An observable as measured in the scaled mills of one S, in the physical mill's unit."""

    S: float
    mean: float
    runs: int


@dataclass(frozen=True)
class PredictedNumber:
    """An observable of the physical mill.

    Attributes:
        observable: what it is.
        scale: the physical mill's unit over the dimensionless number.
        found: dimensionless; None if it is not extrapolated.
        noise: of one run, dimensionless; None if it is not extrapolated.
        noise_from: "seeds", or "lifter pitches" of single runs.
        measured: in the scaled mills, by S.
        refused: why it is not extrapolated; empty if it is.
        check: what a physical mill that was left out has; None if none was.
    """

    observable: Observable
    scale: float
    found: Extrapolation | None
    noise: Noise | None
    noise_from: str
    measured: tuple[ScaledValue, ...]
    refused: str
    check: float | None = None

    @property
    def value(self) -> float | None:
        return self.scale * self.found.value if self.found else None

    @property
    def interval(self) -> tuple[float, float] | None:
        """Return the lower and the upper end."""
        if self.found is None:
            return None
        ends = sorted((self.scale * self.found.lower, self.scale * self.found.upper))
        return ends[0], ends[1]

    @property
    def is_inside(self) -> bool | None:
        """Return whether the interval holds the measured value of the mill that was left out."""
        if self.check is None or self.interval is None:
            return None
        return self.interval[0] <= self.check <= self.interval[1]

    def document(self) -> dict[str, Any]:
        """Return it as JSON types."""
        interval = self.interval
        return {
            "name": self.observable.name,
            "unit": self.observable.unit,
            "value": self.value,
            "lower": interval[0] if interval else None,
            "upper": interval[1] if interval else None,
            "refused": self.refused,
            "noise_from": self.noise_from,
            "scale": self.scale,
            "dimensionless": asdict(self.found) if self.found else None,
            "measured": [asdict(value) for value in self.measured],
            "left_out_physical_mill": self.check,
            "is_inside": self.is_inside,
        }


@dataclass(frozen=True)
class Prediction:
    """The physical mill and what is predicted of it.

    Attributes:
        contour: the free surface; None if it is not extrapolated, which `contour_refused` explains.
        runs: charges used, by S, then seed.
        excluded: charges that were not used, and why, by id.
        warnings: what may mislead.
    """

    mill: PhysicalMill
    scheme: str
    policy: str
    numbers: tuple[PredictedNumber, ...]
    contour: PredictedContour | None
    contour_refused: str
    runs: tuple[Charge, ...]
    excluded: Mapping[str, str]
    warnings: tuple[str, ...]

    def document(self) -> dict[str, Any]:
        """Return it as JSON types."""
        return {
            "schema": SCHEMA,
            "physical_mill": asdict(self.mill),
            "scheme": self.scheme,
            "policy": self.policy,
            "numbers": [number.document() for number in self.numbers],
            "contour": self.contour
            and self.contour.document(self.mill.radius - self.mill.ball_radius),
            "contour_refused": self.contour_refused,
            "runs": [
                {"campaign": x.campaign, "id": x.id, "S": x.S, "seed": x.seed} for x in self.runs
            ],
            "excluded": dict(self.excluded),
            "warnings": list(self.warnings),
        }


def predict(
    folders: Sequence[Path],
    scheme: str | None = None,
    policy: str | None = None,
    level: float = 0.95,
    leave_out_physical: bool = False,
) -> Prediction:
    """Predict the physical mill from runs folders of its scaled mills.

    Args:
        scheme, policy: of the scaled mills to use, where the folders hold several.
        level: probability of the intervals.
        leave_out_physical: do not use S = 1, but compare with it.

    Raises:
        PredictionError: the charges are not scaled mills of one physical mill, are too few or too
            close together.
        RunFolderError: a folder holds no campaign, or a damaged one.
    """
    charges, excluded = usable_charges(folders)
    scheme, policy = chosen_scaling(charges, scheme, policy)
    wanted = [
        charge
        for charge in charges
        if charge.case.is_physical or (charge.scheme == scheme and charge.policy == policy)
    ]
    check_one_mill(wanted)
    if leave_out_physical and not any(charge.case.is_physical for charge in wanted):
        raise PredictionError("no finished charge of S = 1 to compare with: run one, or do not ask")
    used = [x for x in wanted if not (leave_out_physical and x.case.is_physical)]
    check_scaled_mills(used, excluded)
    left_out = [charge for charge in wanted if charge not in used]
    return predict_charges(used, left_out, measure(wanted, []).numbers, level, excluded)


def predict_charges(
    used: Sequence[Charge],
    left_out: Sequence[Charge],
    values: Mapping[Charge, Mapping[str, float | None]],
    level: float = 0.95,
    excluded: Mapping[str, str] | None = None,
) -> Prediction:
    """Predict the physical mill from charges of one physical mill that are measured.

    Args:
        used: of two values of S or more, of one scheme and policy.
        left_out: charges of S = 1 to compare with.
        values: of each charge, by the name of the quantity (`measured.measure`).
        excluded: charges that are not used, and why, by id.
    """
    mill = physical_mill(used[0].case, _mean(balls_per_length(charge.case) for charge in used))
    numbers = [_predicted(row, used, values, mill, level) for row in OBSERVABLES]
    if left_out:
        numbers = [_with_check(number, left_out, values) for number in numbers]
    contour, refused = _contour(used, left_out, level)
    # At S = 1 all schemes and policies are the same mill.
    scaled = next(charge for charge in used if not charge.case.is_physical)
    return Prediction(
        mill=mill,
        scheme=scaled.scheme,
        policy=scaled.policy,
        numbers=tuple(numbers),
        contour=contour,
        contour_refused=refused,
        runs=tuple(used),
        excluded=excluded or {},
        warnings=tuple(warnings_of(used)),
    )


def _predicted(
    observable: Observable,
    charges: Sequence[Charge],
    values: Mapping[Charge, Mapping[str, float | None]],
    mill: PhysicalMill,
    level: float,
) -> PredictedNumber:
    scale = observable.scale(mill)
    groups = _groups(observable.name, charges, values)
    measured = tuple(ScaledValue(g.S, scale * g.mean, len(g.values)) for g in groups)
    number = PredictedNumber(
        observable, scale, None, None, "", measured, observable.not_extrapolated
    )
    if observable.not_extrapolated:
        return number
    if len(groups) < 2:
        return replace(number, refused="measured at fewer than two values of S")
    noise, noise_from = noise_of(observable.name, groups, charges)
    if noise is None:
        return replace(number, refused="its noise is not known: add a seed")
    try:
        found = extrapolate(groups, noise, level)
    except ExtrapolationError as error:
        return replace(number, refused=str(error))
    number = replace(number, found=found, noise=noise, noise_from=noise_from)
    probability = found.residual_probability
    if probability is not None and probability < LEAST_RESIDUAL_PROBABILITY:
        reason = f"its values do not follow a power of S (probability {probability:.1g})"
        return replace(number, found=None, refused=reason)
    return number


def _groups(
    name: str,
    charges: Sequence[Charge],
    values: Mapping[Charge, Mapping[str, float | None]],
) -> list[Group]:
    """Return the values of an observable by S."""
    known = ((charge.S, value) for charge in charges if (value := values[charge][name]) is not None)
    return [Group(S, tuple(found)) for S, found in by_ratio(known)]


def _contour(
    charges: Sequence[Charge], left_out: Sequence[Charge], level: float
) -> tuple[PredictedContour | None, str]:
    """Return the contour, or why there is none."""
    try:
        return predict_contour(charges, left_out, level), ""
    except (ExtrapolationError, RunFolderError) as error:
        return None, str(error)


def _with_check(
    number: PredictedNumber,
    truth: Sequence[Charge],
    values: Mapping[Charge, Mapping[str, float | None]],
) -> PredictedNumber:
    known = [x for charge in truth if (x := values[charge][number.observable.name]) is not None]
    return replace(number, check=number.scale * _mean(known)) if known else number


def _mean(values: Iterable[float]) -> float:
    known = list(values)
    return math.fsum(known) / len(known)
