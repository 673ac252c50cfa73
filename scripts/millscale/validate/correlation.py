"""Correlation of two runs of one seed, and what a control variate gains by it."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

# Of the n! pairings of the seeds all are tried up to this number, else as many at random.
MOST_PAIRINGS = 5040
NORMAL_95 = 1.959964


@dataclass(frozen=True)
class Correlation:
    """Correlation of two settings over their seeds.

    Attributes:
        value: Pearson's r; None if one of them does not vary.
        low, high: 95 % interval by Fisher's transformation of `samples`; None without.
        samples: independent pairs that scatter as the pairings of different seeds do.
        chance: share of the pairings of different seeds with an r at least as large; the same
            seeds are one of them.
    """

    value: float | None
    low: float | None = None
    high: float | None = None
    samples: float | None = None
    chance: float | None = None


def pooled_correlation(first: np.ndarray, second: np.ndarray) -> float | None:
    """Return Pearson's r of deviations from the mean over the seeds, which each window has its own
    of; None if one setting does not vary.

    Args:
        first, second: (seeds, windows) float.
    """
    a, b = (x - x.mean(axis=0) for x in (first, second))
    scale = math.sqrt(float(np.sum(a * a) * np.sum(b * b)))
    return float(np.sum(a * b)) / scale if scale > 0.0 else None


def correlation(first: np.ndarray, second: np.ndarray) -> Correlation:
    """Return the correlation of (seeds, windows) float of two settings.

    Pairing each seed of the first with another of the second leaves chance alone. Its mean square
    of r is 1 / (n - 1) for n independent pairs, which gives the number of pairs that correlated
    windows are worth: n itself for one window.
    """
    r = pooled_correlation(first, second)
    if r is None:
        return Correlation(None)
    others = np.array(
        [pooled_correlation(first, second[list(pairing)]) for pairing in _pairings(len(first))]
    )
    samples = 1.0 + 1.0 / float(np.mean(others**2))
    low, high = fisher_interval(r, samples)
    # 1e-12: the same seeds in the same order count, whatever the rounding.
    return Correlation(r, low, high, samples, float(np.mean(others >= r - 1e-12)))


def _pairings(seeds: int) -> Iterable[Sequence[int]]:
    if math.factorial(seeds) <= MOST_PAIRINGS:
        return itertools.permutations(range(seeds))
    generator = np.random.default_rng(1)
    return [generator.permutation(seeds).tolist() for _ in range(MOST_PAIRINGS)]


def fisher_interval(r: float, samples: float) -> tuple[float | None, float | None]:
    """Return the 95 % interval of a correlation: tanh(artanh r -+ 1.96 / sqrt(n - 3)).

    R. A. Fisher, Metron 1 (1921) 3. None for 3 samples or fewer.
    """
    if samples <= 3.0 + 1e-9:
        return None, None
    centre = math.atanh(min(max(r, -1.0 + 1e-12), 1.0 - 1e-12))
    half = NORMAL_95 / math.sqrt(samples - 3)
    return math.tanh(centre - half), math.tanh(centre + half)


def variance_left(r: float) -> float:
    """Return the variance that a control variate of known mean leaves, over that without: 1 -
    r^2."""
    return max(0.0, 1.0 - r * r)


def cost_at_equal_variance(r: float, cost_ratio: float) -> float:
    """Return the cost of two fidelities at the best numbers of runs, over that of the dear one
    alone with the same variance of the mean.

    [sqrt(1 - r^2) + |r| sqrt(w)]^2, w the cost of a cheap run over that of a dear one. At least
    one cheap run goes with each dear one. B. Peherstorfer, K. Willcox and M. Gunzburger, SIAM J.
    Sci. Comput. 38 (2016) A3163, doi 10.1137/15M1046472.
    """
    return (math.sqrt(variance_left(r)) + abs(r) * math.sqrt(cost_ratio)) ** 2


def least_correlation(cost_ratio: float) -> float:
    """Return the r above which two fidelities cost less than the dear one alone: 2 sqrt(w) / (1 +
    w)."""
    return 2.0 * math.sqrt(cost_ratio) / (1.0 + cost_ratio)


@dataclass(frozen=True)
class Extrapolated:
    """Extrapolation of means at two steps or lengths to the exact limit.

    Attributes:
        order: p of an error proportional to h^p.
        value, error: the limit and its standard error.
    """

    order: float
    value: float
    error: float


def richardson(
    fine: tuple[float, float], coarse: tuple[float, float], ratio: float, order: float
) -> Extrapolated:
    """Return fine + (fine - coarse) / (ratio^order - 1) of independent means.

    Args:
        fine, coarse: mean and its standard error.
        ratio: coarse h over fine h.
    """
    weight = 1.0 / (ratio**order - 1.0)
    value = fine[0] + weight * (fine[0] - coarse[0])
    return Extrapolated(order, value, math.hypot((1.0 + weight) * fine[1], weight * coarse[1]))
