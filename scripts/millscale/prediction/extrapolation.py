"""Extrapolation of an observable from scaled mills to the physical mill, with an interval.

A scaled mill has the same balls in a mill that is S times smaller, so its error grows with S.
The error of an observable q follows a power of S:

    q(S) = q(1) + b (S^p - 1) / p;    q(1) + b ln S at p = 0.

Two values of S do not determine p, so it stays uncertain: uniform between the ends of a prior,
which depends on the kind of observable (`kinds`). Three values of S or more weight each p by how
well it fits. Derived here; docs/theory/prediction.md.

For a given p the law is linear in q(1) and b. With n_g runs of group g, means q_g and the standard
deviation s of one run (nu degrees of freedom), generalized least squares give q(1) = sum_g w_g q_g,
of standard error s sqrt(sum_g w_g^2 / n_g), Student-distributed with nu degrees of freedom. The
distribution of q(1) is the mixture of these over p.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from scipy.optimize import brentq
from scipy.special import fdtrc, stdtr, stdtrit

# Values of p that stand for a uniform prior: the midpoints of as many equal parts.
_EXPONENTS = 40
# Weights of a larger norm multiply the noise of the runs more than an extrapolation can stand.
LARGEST_WEIGHTS = 5.0
# Exponents beyond this are not looked for.
FARTHEST_EXPONENT = 3.0
# Two values of S closer than this are one group.
SAME_S = 1e-6
T = TypeVar("T")


class ExtrapolationError(ValueError):
    """The runs do not allow an extrapolation; the message says why and what would."""


@dataclass(frozen=True)
class Prior:
    """Uniform distribution of the exponent p before anything is measured."""

    lower: float
    upper: float

    @property
    def middle(self) -> float:
        return 0.5 * (self.lower + self.upper)

    @property
    def exponents(self) -> np.ndarray:
        """Return values of p of equal probability, (`_EXPONENTS`,) float."""
        return self.lower + (self.upper - self.lower) * (np.arange(_EXPONENTS) + 0.5) / _EXPONENTS


WIDE = Prior(0.0, 1.0)


@dataclass(frozen=True)
class Noise:
    """Standard deviation of one run and how well it is known.

    Attributes:
        deviation: in the unit of the observable.
        freedom: degrees of freedom it was estimated with; infinity if it is known.
    """

    deviation: float
    freedom: float


@dataclass(frozen=True)
class Group:
    """The runs of one S.

    Attributes:
        S: scale ratio, 1 or more.
        values: one for each run, in the unit of the observable.
    """

    S: float
    values: tuple[float, ...]

    @property
    def mean(self) -> float:
        return math.fsum(self.values) / len(self.values)


@dataclass(frozen=True)
class Extrapolation:
    """An observable of the physical mill.

    Attributes:
        value: median of its distribution, in the unit of the observable.
        lower, upper: ends of the interval.
        level: probability of the interval.
        noise_error: standard error from the noise of the runs alone, at the mean of p.
        exponent_error: standard deviation of the value over p.
        exponent, exponent_deviation: mean and standard deviation of p, after the fit.
        weights: of each group, at the mean of p.
        residual_probability: of residuals at least this large if the law holds; None with two
            groups, which every p fits.
    """

    value: float
    lower: float
    upper: float
    level: float
    noise_error: float
    exponent_error: float
    exponent: float
    exponent_deviation: float
    weights: tuple[float, ...]
    residual_probability: float | None

    @property
    def half_width(self) -> float:
        return 0.5 * (self.upper - self.lower)


def scale_function(S: float | np.ndarray, p: float) -> np.ndarray:
    """Return (S^p - 1) / p, and ln S at p = 0: what the error of an observable is linear in."""
    logarithm = np.log(S)
    return logarithm if p == 0.0 else np.expm1(p * logarithm) / p


def by_ratio(values: Iterable[tuple[float, T]]) -> list[tuple[float, list[T]]]:
    """Return values of charges, given with their S, gathered by S in rising order."""
    groups: dict[int, tuple[float, list[T]]] = {}
    for S, value in values:
        groups.setdefault(round(S / SAME_S), (S, []))[1].append(value)
    return [groups[key] for key in sorted(groups)]


def pooled_noise(groups: Sequence[Group]) -> Noise:
    """Return the standard deviation of one run from the scatter within the groups.

    Raises:
        ExtrapolationError: no group has two runs.
    """
    freedom = sum(len(group.values) - 1 for group in groups)
    if freedom == 0:
        raise ExtrapolationError(
            "no value of S has two seeds, so the noise of a run is not known: add a seed"
        )
    squares = math.fsum((x - group.mean) ** 2 for group in groups for x in group.values)
    return Noise(math.sqrt(squares / freedom), float(freedom))


def extrapolate(
    groups: Sequence[Group],
    noise: Noise | None = None,
    level: float = 0.95,
    prior: Prior = WIDE,
) -> Extrapolation:
    """Extrapolate an observable to S = 1.

    Args:
        groups: two or more values of S; S = 1 may be one of them, or the only one.
        noise: of one run; from the scatter within the groups if not given.
        level: probability of the interval, between 0 and 1.
        prior: of the exponent.

    Raises:
        ExtrapolationError: one scaled value of S alone, values of S too close together, noise
            unknown.
    """
    groups = sorted(groups, key=lambda group: group.S)
    _check(groups)
    noise = noise or pooled_noise(groups)
    S = np.array([group.S for group in groups])
    means = np.array([group.mean for group in groups])
    runs = np.array([len(group.values) for group in groups], dtype=float)

    exponents = prior.exponents
    of_exponents = np.array([weights(S, runs, p) for p in exponents])
    check_norm(S, weights_norm(groups, prior))
    centres = of_exponents @ means
    scales = noise.deviation * np.sqrt((of_exponents**2 / runs).sum(axis=1))
    misfits = np.array([_misfit(S, runs, means, p) for p in exponents])
    shares = _shares(misfits, noise, len(groups) - 2)

    mixture = _Mixture(shares, centres, scales, noise.freedom)
    tail = 0.5 * (1.0 - level)
    p = float(shares @ exponents)
    at_mean = weights(S, runs, p)
    return Extrapolation(
        value=mixture.quantile(0.5),
        lower=mixture.quantile(tail),
        upper=mixture.quantile(1.0 - tail),
        level=level,
        noise_error=float(noise.deviation * math.sqrt((at_mean**2 / runs).sum())),
        exponent_error=math.sqrt(max(float(shares @ (centres - shares @ centres) ** 2), 0.0)),
        exponent=p,
        exponent_deviation=math.sqrt(max(float(shares @ (exponents - p) ** 2), 0.0)),
        weights=tuple(map(float, at_mean)),
        residual_probability=_residual_probability(float(misfits.min()), noise, len(groups) - 2),
    )


def reverses(groups: Sequence[Group], noise: Noise) -> bool:
    """Return whether the means rise and fall with S, each by more than two standard errors."""
    ordered = sorted(groups, key=lambda group: group.S)
    signs = set()
    for one, other in itertools.combinations(ordered, 2):
        error = noise.deviation * math.sqrt(1.0 / len(one.values) + 1.0 / len(other.values))
        if abs(other.mean - one.mean) > 2.0 * error:
            signs.add(other.mean > one.mean)
    return len(signs) > 1


def exact_exponent(groups: Sequence[Group], truth: float) -> float | None:
    """Return the exponent with which the weights give a known value at S = 1; None if none between
    -`FARTHEST_EXPONENT` and `FARTHEST_EXPONENT` does."""
    ordered = sorted(groups, key=lambda group: group.S)
    S = np.array([group.S for group in ordered])
    means = np.array([group.mean for group in ordered])
    runs = np.array([len(group.values) for group in ordered], dtype=float)

    def excess(p: float) -> float:
        return float(weights(S, runs, p) @ means) - truth

    ends = -FARTHEST_EXPONENT, FARTHEST_EXPONENT
    if excess(ends[0]) * excess(ends[1]) >= 0.0:
        return None
    return float(brentq(excess, *ends))


def weights_norm(groups: Sequence[Group], prior: Prior) -> float:
    """Return the norm of the weights in the middle of a prior, by which noise is multiplied."""
    S = np.array([group.S for group in groups])
    runs = np.array([len(group.values) for group in groups], dtype=float)
    return float(np.linalg.norm(weights(S, runs, prior.middle)))


def check_norm(ratios: Iterable[float], norm: float) -> None:
    """Refuse weights that multiply the noise too much.

    Raises:
        ExtrapolationError: the norm of the weights is above `LARGEST_WEIGHTS`.
    """
    if norm > LARGEST_WEIGHTS:
        raise ExtrapolationError(
            f"S = {', '.join(f'{x:.4g}' for x in ratios)} lie too close together or too far from "
            f"1: weights of norm {norm:.3g}; accepted: at most {LARGEST_WEIGHTS:g}; "
            "next: add a scaled mill nearer to S = 1, or one of a larger S"
        )


def _check(groups: Sequence[Group]) -> None:
    if len(groups) < 2 and not (groups and abs(groups[0].S - 1.0) < SAME_S):
        found = f"S = {groups[0].S:.4g} alone" if groups else "no scaled mill"
        raise ExtrapolationError(f"{found}: an extrapolation needs two values of S or more")
    for group, following in itertools.pairwise(groups):
        if following.S - group.S < SAME_S:
            raise ExtrapolationError(f"S = {group.S:.6g} stands in two groups")
    if groups[0].S < 1.0 - SAME_S:
        raise ExtrapolationError(f"S = {groups[0].S:.4g} is below 1: a scaled mill is smaller")


def _design(S: np.ndarray, p: float) -> np.ndarray:
    """(groups, 2) float: columns of q(1) and b."""
    return np.column_stack([np.ones_like(S), scale_function(S, p)])


def weights(S: np.ndarray, runs: np.ndarray, p: float) -> np.ndarray:
    """Return the weights of the group means in q(1), which sum to 1, (groups,) float.

    Args:
        S, runs: (groups,) float, and the number of runs of each.
    """
    if len(S) == 1:
        return np.ones(1)
    design = _design(S, p)
    normal = design.T @ (runs[:, None] * design)
    return np.linalg.solve(normal, design.T * runs)[0]


def _misfit(S: np.ndarray, runs: np.ndarray, means: np.ndarray, p: float) -> float:
    """Sum of the squared residuals of the group means, each times the number of its runs."""
    if len(S) <= 2:
        return 0.0
    root = np.sqrt(runs)
    design = root[:, None] * _design(S, p)
    left = root * means - design @ np.linalg.lstsq(design, root * means, rcond=None)[0]
    return float(left @ left)


def _shares(misfits: np.ndarray, noise: Noise, freedom: int) -> np.ndarray:
    """Probability of each p: the likelihood of its residuals; equal where two groups have none."""
    if freedom <= 0 or noise.deviation == 0.0:
        return np.full(len(misfits), 1.0 / len(misfits))
    over = (misfits - misfits.min()) / noise.deviation**2
    if math.isinf(noise.freedom):
        likelihood = np.exp(-0.5 * over)
    else:
        base = 1.0 + misfits.min() / noise.deviation**2 / noise.freedom
        likelihood = (1.0 + over / noise.freedom / base) ** (-0.5 * (noise.freedom + freedom))
    return likelihood / likelihood.sum()


def _residual_probability(misfit: float, noise: Noise, freedom: int) -> float | None:
    # The fitted p takes a degree of freedom as well.
    left = freedom - 1 if freedom > 1 else freedom
    if freedom <= 0 or noise.deviation == 0.0:
        return None
    ratio = misfit / noise.deviation**2 / left
    spread = noise.freedom if math.isfinite(noise.freedom) else 1e9
    return float(fdtrc(left, spread, ratio))


@dataclass(frozen=True)
class _Mixture:
    """Student distributions of one number of degrees of freedom, mixed."""

    shares: np.ndarray
    centres: np.ndarray
    scales: np.ndarray
    freedom: float

    def quantile(self, probability: float) -> float:
        freedom = min(self.freedom, 1e9)
        # Beyond the quantile of every part of the mixture, by rounding at least.
        widest = float(stdtrit(freedom, max(probability, 1.0 - probability, 0.9)))
        rounding = 1e-12 * float(np.abs(self.centres).max())
        reach = 1.01 * widest * float(self.scales.max()) + rounding
        lower, upper = self.centres.min() - reach, self.centres.max() + reach
        if upper <= lower:
            return float(lower)
        scales = np.maximum(self.scales, 1e-12 * (upper - lower))

        def excess(x: float) -> float:
            below = stdtr(freedom, (x - self.centres) / scales)
            return float(self.shares @ below) - probability

        return float(brentq(excess, lower, upper))
