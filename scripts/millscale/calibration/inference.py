"""Parameters from differences between simulated and measured numbers: values, intervals, what
determines them.

Measured numbers are independent and normally distributed about those of the mill, with a stated
uncertainty. With m_j and s_j the mean and deviation of the surrogate of a difference over its
uncertainty, the likelihood of parameters is

    L(x) = prod_j (1 + s_j^2)^-1/2 exp(-1/2 m_j^2 / (1 + s_j^2)),

the density before is even over the ranges, and the density after is proportional to L: Bayesian
calibration by a surrogate (Kennedy and O'Hagan, J. R. Statist. Soc. B 63 (2001) 425-464, without
their model of what no parameter explains). The points of a profile are replaced by the few
directions in which the runs differ (Higdon, Gattiker, Williams, Rightley, J. Am. Statist. Assoc.
103 (2008) 570-583).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from millscale.calibration.posterior import particles_of
from millscale.calibration.surrogate import Surrogate, fit

# Directions of a profile: as many as hold this share of the squares, and no more than so many.
SHARE_KEPT, MOST_DIRECTIONS = 0.999, 6
# A parameter whose interval takes more of its range is not determined.
DETERMINED = 0.5
# An end of an interval this near to that of the range, over the range, is cut off by it.
AT_END = 0.02
# Correlation from which only a combination of two parameters is determined.
COMBINED = 0.9
# Difference at the best values over its standard deviation from which a target is not met.
MISSED = 2.0
# Errors of predictions from the other runs, over those the surrogate states.
SURROGATE_IS_WRONG = 2.0
# Converged: the surrogate adds less than this to the uncertainty, and the best values moved less
# than this over the deviation of the density.
SMALL_SURROGATE, SMALL_SHIFT = 0.5, 0.5
# Distance between places that are run, over the deviations of the density.
APART = 0.2


class CalibrationError(ValueError):
    """Runs that do not allow a calibration: why, and what would."""


@dataclass(frozen=True)
class Parameter:
    """A parameter and its range.

    Attributes:
        keys: of the campaign file, which get its value.
        logarithmic: the density before is even in the logarithm.
    """

    name: str
    keys: tuple[str, ...]
    least: float
    most: float
    logarithmic: bool = False

    def value(self, place: np.ndarray) -> np.ndarray:
        """Return values at places of the unit interval."""
        if self.logarithmic:
            return self.least * (self.most / self.least) ** place
        return self.least + (self.most - self.least) * place

    def place(self, value: float) -> float:
        """Return the place of a value; outside of [0, 1] if it is outside of the range."""
        if self.logarithmic:
            return math.log(value / self.least) / math.log(self.most / self.least)
        return (value - self.least) / (self.most - self.least)


@dataclass(frozen=True, eq=False)
class Evidence:
    """What the runs give of one target.

    Attributes:
        differences: (n, p) float, of each run, simulated less measured over the uncertainty.
        noise: of each run over the same uncertainty; None where it is not known.
    """

    name: str
    differences: np.ndarray
    noise: tuple[float | None, ...]


@dataclass(frozen=True, eq=False)
class TargetModel:
    """The difference of a target as a function of the place.

    Attributes:
        directions: (k, p) float, orthonormal.
        rest: (p,) float, the mean difference that is in no direction: no parameter changes it.
    """

    name: str
    directions: np.ndarray
    rest: np.ndarray
    surrogates: tuple[Surrogate, ...]

    def misfit(self, places: np.ndarray) -> np.ndarray:
        """Return -2 ln L, (m,) float."""
        total = np.zeros(len(places))
        for surrogate in self.surrogates:
            mean, deviation = surrogate.at(places)
            variance = 1.0 + deviation**2
            total += mean**2 / variance + np.log(variance)
        return total

    def differences(self, place: np.ndarray) -> np.ndarray:
        """Return the differences of all points at a place, (p,) float."""
        means = [surrogate.at(place[None])[0][0] for surrogate in self.surrogates]
        return self.rest + np.array(means) @ self.directions

    def deviation(self, places: np.ndarray) -> np.ndarray:
        """Return the root mean square deviation of the surrogates, (m,) float."""
        squares = [surrogate.at(places)[1] ** 2 for surrogate in self.surrogates]
        return np.sqrt(np.mean(squares, axis=0))

    def left_out(self) -> float:
        """Return the root mean square of `Surrogate.left_out`."""
        return float(np.sqrt(np.mean([one.left_out() ** 2 for one in self.surrogates])))


@dataclass(frozen=True)
class Found:
    """What is known of a parameter.

    Attributes:
        best: value that goes into the campaign.
        lower, upper: ends of the interval.
        width: of the interval over the range, in the scale of the parameter.
        deviation: standard deviation of the place.
        cut_by: "least" or "most", if an end of the range cuts the interval; else empty.
    """

    name: str
    best: float
    lower: float
    upper: float
    width: float
    deviation: float
    cut_by: str

    @property
    def is_determined(self) -> bool:
        return self.width <= DETERMINED


@dataclass(frozen=True)
class Met:
    """How a target is met at the best values; all over its uncertainty.

    Attributes:
        difference: of a number, simulated less measured; of a profile, the root mean square.
        points: of the profile; 1 for a number.
        surrogate: root mean square deviation of the surrogate where the density is.
        left_out: of `TargetModel.left_out`.
    """

    name: str
    difference: float
    points: int
    surrogate: float
    left_out: float

    @property
    def is_met(self) -> bool:
        return abs(self.difference) <= MISSED * math.hypot(1.0, self.surrogate)


@dataclass(frozen=True, eq=False)
class Inference:
    """Parameters from runs.

    Attributes:
        runs: number of runs used.
        best: (d,) float, the place of the best values.
        particles: (m, d) float, places of the density.
        correlation: (d, d) float, of the places.
        shift: largest change of the best values since the round before, over the deviation of the
            density; None in the first round.
    """

    parameters: tuple[Parameter, ...]
    level: float
    runs: int
    found: tuple[Found, ...]
    met: tuple[Met, ...]
    models: tuple[TargetModel, ...]
    best: np.ndarray
    particles: np.ndarray
    correlation: np.ndarray
    shift: float | None = None

    @property
    def is_converged(self) -> bool:
        small = all(target.surrogate <= SMALL_SURROGATE for target in self.met)
        return small and self.shift is not None and self.shift <= SMALL_SHIFT

    def warnings(self) -> list[str]:
        """Return what may mislead, and what would help."""
        texts = []
        for one in self.found:
            if not one.is_determined:
                texts.append(
                    f"{one.name} is not determined: its interval takes {100.0 * one.width:.0f} % "
                    "of the range; add a target that depends on it, or state it"
                )
            elif one.cut_by:
                texts.append(
                    f"the interval of {one.name} ends at its {one.cut_by} value: widen the range"
                )
        for i, row in enumerate(self.correlation):
            for j in range(i):
                if abs(row[j]) >= COMBINED:
                    names = f"{self.parameters[j].name} and {self.parameters[i].name}"
                    texts.append(
                        f"{names} correlate by {row[j]:+.2f}: the targets determine a combination"
                    )
        for target in self.met:
            if not target.is_met:
                texts.append(
                    f"{target.name} is not met: {_difference(target)} of its uncertainty at the "
                    "best values; widen a range, or doubt the mill, the model or the uncertainty"
                )
            if target.left_out > SURROGATE_IS_WRONG:
                texts.append(
                    f"the surrogate of {target.name} errs by {target.left_out:.1f} of what it "
                    "states: add samples"
                )
        return texts


def infer(
    parameters: Sequence[Parameter],
    places: np.ndarray,
    evidence: Sequence[Evidence],
    level: float = 0.95,
    seed: int = 1,
    before: Inference | None = None,
) -> Inference:
    """Return the parameters from some runs.

    Args:
        places: (n, d) float in [0, 1], of the runs.
        evidence: of each target.
        level: probability of the intervals.
        seed: of the sampler.
        before: the result of the round before.

    Raises:
        CalibrationError: too few runs for the parameters.
    """
    runs, dimensions = places.shape
    if runs < dimensions + 2:
        raise CalibrationError(
            f"{runs} finished samples for {dimensions} parameters: {dimensions + 2} are needed"
        )
    models = tuple(target_model(places, one) for one in evidence)
    particles = _particles(models, dimensions, seed)
    best = _best(models, particles)
    margin = 0.5 * (1.0 - level)
    ends = np.quantile(particles, [margin, 1.0 - margin], axis=0)
    deviations = particles.std(axis=0)
    found = tuple(
        Found(
            parameter.name,
            float(parameter.value(best[j])),
            float(parameter.value(ends[0, j])),
            float(parameter.value(ends[1, j])),
            float(ends[1, j] - ends[0, j]),
            float(deviations[j]),
            _cut(ends[:, j], margin),
        )
        for j, parameter in enumerate(parameters)
    )
    shift = None
    if before is not None:
        shift = float(np.max(np.abs(best - before.best) / np.maximum(deviations, 1e-9)))
    return Inference(
        tuple(parameters),
        level,
        runs,
        found,
        tuple(_met(model, best, particles) for model in models),
        models,
        best,
        particles,
        np.corrcoef(particles.T).reshape(dimensions, dimensions),
        shift,
    )


def target_model(places: np.ndarray, evidence: Evidence) -> TargetModel:
    """Return the surrogates of a target."""
    values = evidence.differences
    mean = values.mean(axis=0)
    directions = np.eye(1)
    if values.shape[1] > 1:
        _, sizes, rows = np.linalg.svd(values - mean, full_matrices=False)
        held = np.cumsum(sizes**2) / max(float(np.sum(sizes**2)), 1e-30)
        count = min(1 + int(np.searchsorted(held, SHARE_KEPT)), MOST_DIRECTIONS, len(rows))
        directions = rows[:count]
    along = values @ directions.T
    surrogates = tuple(fit(places, column, evidence.noise) for column in along.T)
    rest = mean - (mean @ directions.T) @ directions
    return TargetModel(evidence.name, directions, rest, surrogates)


@dataclass(frozen=True)
class Contribution:
    """What a target says of the parameters.

    Attributes:
        alone: (d,) float, widths of the intervals over the ranges if it were the only target.
        without: (d,) float, the same if it were left out.
    """

    alone: np.ndarray
    without: np.ndarray


def contributions(result: Inference, seed: int = 1) -> dict[str, Contribution]:
    """Return what each target says of the parameters, by its name.

    Args:
        seed: of the sampler.
    """
    dimensions, margin = len(result.parameters), 0.5 * (1.0 - result.level)

    def widths(models: Sequence[TargetModel]) -> np.ndarray:
        particles = _particles(models, dimensions, seed)
        return np.diff(np.quantile(particles, [margin, 1.0 - margin], axis=0), axis=0)[0]

    return {
        model.name: Contribution(
            widths([model]), widths([other for other in result.models if other is not model])
        )
        for model in result.models
    }


def next_places(result: Inference, count: int) -> np.ndarray:
    """Return where to run next, (count, d) float: the best values, then the particles at which the
    surrogates are least certain, each with the earlier ones taken as run.

    A place that was run is not run again: in the unit of the deviations of the density, places are
    `APART` from one another, as long as there are such particles.
    """
    candidates = np.vstack([result.best, result.particles])
    spread = np.maximum(result.particles.std(axis=0), 1e-9)
    models = [list(model.surrogates) for model in result.models]
    gaps = np.full(len(candidates), np.inf)
    for place in models[0][0].places:
        gaps = np.minimum(gaps, np.linalg.norm((candidates - place) / spread, axis=1))
    chosen: list[np.ndarray] = []
    while len(chosen) < count:
        variance = np.zeros(len(candidates))
        for surrogates in models:
            for one in surrogates:
                variance += one.at(candidates)[1] ** 2
        if not chosen:
            variance[0] = np.inf
        free = gaps >= APART
        number = int(np.argmax(np.where(free, variance, -1.0) if free.any() else gaps))
        place = candidates[number]
        chosen.append(place)
        gaps = np.minimum(gaps, np.linalg.norm((candidates - place) / spread, axis=1))
        models = [[one.with_place(place) for one in surrogates] for surrogates in models]
    return np.array(chosen)


def _particles(models: Sequence[TargetModel], dimensions: int, seed: int) -> np.ndarray:
    def log_likelihood(places: np.ndarray) -> np.ndarray:
        return -0.5 * sum((model.misfit(places) for model in models), np.zeros(len(places)))

    return particles_of(log_likelihood, dimensions, seed)


def _best(models: Sequence[TargetModel], particles: np.ndarray) -> np.ndarray:
    """Return the mean of the particles, or the particle of the least misfit where the mean of a
    bent or divided density does not fit: by more than one for each parameter."""
    mean = particles.mean(axis=0)
    misfits = [model.misfit(np.vstack([particles, mean])) for model in models]
    misfit = np.sum(misfits, axis=0)
    least = int(np.argmin(misfit[:-1]))
    return mean if misfit[-1] <= misfit[least] + len(mean) else particles[least]


def _cut(ends: np.ndarray, margin: float) -> str:
    """Return which end of the range cuts an interval; empty if none does."""
    if ends[0] <= max(AT_END, margin):
        return "least"
    return "most" if ends[1] >= 1.0 - max(AT_END, margin) else ""


def _met(model: TargetModel, best: np.ndarray, particles: np.ndarray) -> Met:
    differences = model.differences(best)
    number = len(differences) == 1
    return Met(
        model.name,
        float(differences[0] if number else np.sqrt(np.mean(differences**2))),
        len(differences),
        float(np.sqrt(np.mean(model.deviation(particles) ** 2))),
        model.left_out(),
    )


def _difference(target: Met) -> str:
    sign = "+" if target.points == 1 else ""
    return f"{target.difference:{sign}.1f}"
