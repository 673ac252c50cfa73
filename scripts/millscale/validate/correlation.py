"""Correlation of two runs of one seed, and what a control variate gains by it."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np

# Of all pairings of the seeds, of which there are n!, at most this many are tried.
MOST_PAIRINGS = 5040
NORMAL_95 = 1.959964


@dataclass(frozen=True)
class Correlation:
    """Correlation of two settings over their seeds.

    Attributes:
        value: Pearson's r; None if one of them does not vary.
        low, high: of the 95 % interval by Fisher's transformation of `samples`; None below 4.
        samples: independent pairs, those of one window for each seed.
        chance: share of the pairings of different seeds with an r at least as large; the same
            seeds are one of them.
    """

    value: float | None
    low: float | None
    high: float | None
    samples: int
    chance: float | None


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

    The windows of a seed count as one sample for the interval, which is therefore wide rather than
    narrow. The chance needs no such choice: it pairs each seed of the first with another of the
    second, with all windows at once.
    """
    r, seeds = pooled_correlation(first, second), len(first)
    if r is None:
        return Correlation(None, None, None, seeds, None)
    low, high = fisher_interval(r, seeds)
    pairings = itertools.islice(itertools.permutations(range(seeds)), MOST_PAIRINGS)
    others = [pooled_correlation(first, second[list(pairing)]) for pairing in pairings]
    # 1e-12: the same seeds in the same order count, whatever the rounding.
    chance = np.mean([other is not None and other >= r - 1e-12 for other in others])
    return Correlation(r, low, high, seeds, float(chance))


def fisher_interval(r: float, samples: int) -> tuple[float | None, float | None]:
    """Return the 95 % interval of a correlation: tanh(artanh r -+ 1.96 / sqrt(n - 3)).

    R. A. Fisher, Metron 1 (1921) 3. None for fewer than 4 samples.
    """
    if samples < 4:
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
