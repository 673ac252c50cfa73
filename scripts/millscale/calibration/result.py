"""Result of a calibration, and its JSON."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from millscale.calibration.file import CalibrationFile
from millscale.calibration.inference import Contribution, Inference
from millscale.calibration.observed import Observed
from millscale.calibration.samples import Values
from millscale.calibration.targets import Target

SCHEMA = 1
RESULT = "calibration.json"


@dataclass(frozen=True)
class Sample:
    """A sample.

    Attributes:
        values: of the parameters, in their order.
        round: from 1; None of the calibrated mill.
    """

    values: Values
    round: int | None
    observed: Observed


@dataclass(frozen=True)
class TargetRow:
    """A target at the best values; numbers over its uncertainty are called differences.

    Attributes:
        inferred: difference that the surrogate gives; of a profile the root mean square.
        run: difference of the run with the best values; None if it has none.
        simulated: of that run; None of a profile.
    """

    target: Target
    inferred: float
    surrogate: float
    left_out: float
    run: float | None
    simulated: float | None


@dataclass(frozen=True)
class Result:
    """Result of a calibration.

    Attributes:
        history: what was inferred after each round.
        calibrated: the mill with the best values.
        campaigns: its campaign files, by experiment.
        contributions: what each target says of the parameters, by its name.
    """

    calibration: CalibrationFile
    history: tuple[Inference, ...]
    samples: tuple[Sample, ...]
    calibrated: Sample
    campaigns: Mapping[str, str]
    contributions: Mapping[str, Contribution]

    @property
    def inference(self) -> Inference:
        return self.history[-1]

    @property
    def is_converged(self) -> bool:
        return self.inference.is_converged

    def rows(self) -> list[TargetRow]:
        """Return the targets, in the order of the file."""
        return [
            TargetRow(target, met.difference, met.surrogate, met.left_out, *self._run(target))
            for target, met in zip(self.calibration.targets, self.inference.met, strict=True)
        ]

    def _run(self, target: Target) -> tuple[float | None, float | None]:
        """Return the difference of the calibrated mill, and its number."""
        seen = self.calibrated.observed.targets.get(target.name)
        if seen is None:
            return None, None
        differences = target.differences(seen.values)
        differences = differences[np.isfinite(differences)]
        if target.abscissa is None:
            return float(differences[0]), float(seen.values[0])
        return math.sqrt(float(np.mean(differences**2))), None

    def warnings(self) -> Iterator[str]:
        """Yield what may mislead, and what would help."""
        yield from self.inference.warnings()
        if not self.is_converged:
            yield "not converged: more rounds, or more samples"
        unsteady = sum(bool(sample.observed.unsteady) for sample in self.samples)
        if unsteady:
            reason = next(x.observed.unsteady for x in self.samples if x.observed.unsteady)
            yield f"{unsteady} of {len(self.samples)} samples are not steady: {reason}"
        for number, sample in enumerate(self.samples, 1):
            if sample.observed.excluded:
                yield f"not used: sample {number}: {sample.observed.excluded}"
        if self.calibrated.observed.excluded:
            yield f"the calibrated mill was not compared: {self.calibrated.observed.excluded}"

    def document(self) -> dict[str, Any]:
        """Return it as JSON types."""
        found, names = self.inference, [one.name for one in self.inference.parameters]
        return {
            "schema": SCHEMA,
            "name": self.calibration.name,
            "level": found.level,
            "is_converged": self.is_converged,
            "parameters": [
                asdict(one)
                | {
                    "keys": list(parameter.keys),
                    "is_determined": one.is_determined,
                    "width_with_target_alone": self._widths(j, "alone"),
                    "width_without_target": self._widths(j, "without"),
                }
                for j, (one, parameter) in enumerate(
                    zip(found.found, found.parameters, strict=True)
                )
            ],
            "correlation": {
                name: dict(zip(names, map(float, row), strict=True))
                for name, row in zip(names, found.correlation, strict=True)
            },
            "targets": [
                {
                    "name": row.target.name,
                    "unit": row.target.unit,
                    "measured": _plain(row.target),
                    "uncertainty": row.target.factor * row.target.uncertainty,
                    "simulated": None
                    if row.simulated is None
                    else row.target.factor * row.simulated,
                    "difference_over_uncertainty": row.run,
                    "inferred_difference_over_uncertainty": row.inferred,
                    "surrogate_over_uncertainty": row.surrogate,
                    "left_out": row.left_out,
                }
                for row in self.rows()
            ],
            "rounds": [
                {
                    "samples": one.runs,
                    "best": {x.name: x.best for x in one.found},
                    "width": {x.name: x.width for x in one.found},
                    "shift": one.shift,
                }
                for one in self.history
            ],
            "samples": [
                {
                    "round": sample.round,
                    "values": dict(zip(names, sample.values, strict=True)),
                    "targets": {
                        name: [None if math.isnan(x) else float(x) for x in seen.values]
                        for name, seen in sample.observed.targets.items()
                    },
                    "excluded": sample.observed.excluded,
                }
                for sample in self.samples
            ],
            "warnings": list(self.warnings()),
        }

    def _widths(self, parameter: int, which: str) -> dict[str, float]:
        return {
            name: float(getattr(one, which)[parameter]) for name, one in self.contributions.items()
        }


def _plain(target: Target) -> float | list[float]:
    values = (target.factor * target.measured).tolist()
    return float(values[0]) if target.abscissa is None else values
