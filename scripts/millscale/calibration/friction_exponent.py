"""The friction exponent k of policy friction-matched, from an observable of a mill at several k.

The mill of S_far holds balls of friction mu (S_far / S_near)^-k, that of S_near, the reference,
balls of mu. Their charges stand alike at the k at which an observable y of both is equal:

    y_far(k) = y_near

y_far is the line through its values at both ends of the range of k, and the parabola of least
squares through more. The ends are run first, because the noise of y counts least there. Derived
here; docs/theory/similarity-law.md, "Friction between balls".
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from millscale.errors import PredictionError
from millscale.prediction.extrapolation import Group, Noise

# As the similarity law accepts: liggghts_ext/core/similarity/law.h.
LARGEST_EXPONENT = 2.0
# Exponents are run with two decimals, and nearer ones are the same.
SAME_EXPONENT = 0.05


@dataclass(frozen=True)
class Match:
    """The exponent at which the mills agree.

    Attributes:
        exponent: k.
        half_width: of its interval, from the noise of all runs.
        differences: of the observable from the reference at each k that was run.
        largest_chance: difference that the noise makes; a larger one is none by chance.
        next_exponent: k to run next; None if a run at k has confirmed it.
    """

    exponent: float
    half_width: float
    differences: Mapping[float, float]
    largest_chance: float
    next_exponent: float | None


def match(
    reference: Group, tried: Mapping[float, Group], noise: Noise, level: float = 0.95
) -> Match:
    """Return the exponent at which an observable is that of the reference.

    Args:
        reference: the mill of S_near.
        tried: the mill of S_far by k; holds 0 and `LARGEST_EXPONENT`.
        noise: of one run.
        level: probability of the interval.

    Raises:
        PredictionError: the noise does not allow k to be determined, or k is out of range.
    """
    runs = np.array([len(group.values) for group in tried.values()])
    factor = float(stdtrit(noise.freedom, 0.5 * (1.0 + level)))
    chance = largest_chance(noise, reference, tried.values(), level)
    differences = {k: group.mean - reference.mean for k, group in tried.items()}
    _check_signal(differences, chance)
    k = np.array(list(differences))
    values = np.array(list(differences.values()))
    exponent = _root(k, values)
    _check_range(exponent, differences)
    # Each run moves k by its own noise, and the reference moves it by that of all values at once.
    root = _root(k, values)
    moved = np.array([_root(k, values + noise.deviation * row) for row in np.eye(len(k))]) - root
    together = _root(k, values - noise.deviation) - root
    square = float(np.sum(moved**2 / runs)) + together**2 / len(reference.values)
    half_width = factor * math.sqrt(square)
    if not half_width < LARGEST_EXPONENT:
        raise PredictionError(
            f"k = {exponent:.2f} +- {half_width:.2g} is not determined: add seeds"
        )

    nearest = min(differences, key=lambda tried_k: abs(tried_k - exponent))
    close = SAME_EXPONENT if len(k) == 2 else max(SAME_EXPONENT, half_width)
    confirmed = abs(nearest - exponent) <= close and abs(differences[nearest]) <= chance
    return Match(
        exponent, half_width, differences, chance, None if confirmed else round(exponent, 2)
    )


def largest_chance(
    noise: Noise, reference: Group, tried: Iterable[Group], level: float = 0.95
) -> float:
    """Return the largest difference of two groups that the noise makes, at a probability."""
    fewest = min(len(group.values) for group in tried)
    factor = float(stdtrit(noise.freedom, 0.5 * (1.0 + level)))
    return factor * noise.deviation * math.sqrt(1.0 / fewest + 1.0 / len(reference.values))


def exponent_of(differences: Mapping[float, float]) -> float | None:
    """Return the exponent at which the fit of a difference is zero; None if it is out of range.

    Args:
        differences: of an observable from the reference, by k.
    """
    exponent = _root(np.array(list(differences)), np.array(list(differences.values())))
    return exponent if 0.0 < exponent <= LARGEST_EXPONENT else None


def _check_signal(differences: Mapping[float, float], chance: float) -> None:
    unmatched, effect = differences[0.0], differences[0.0] - differences[LARGEST_EXPONENT]
    if abs(unmatched) <= chance:
        raise PredictionError(
            f"the mills differ by {unmatched:+.2g} in -x_c / R without matching, and by "
            f"{chance:.2g} by chance: k is not determined; choose S farther apart or more seeds"
        )
    if abs(effect) <= chance:
        raise PredictionError(
            f"k = {LARGEST_EXPONENT:g} changes -x_c / R by {-effect:+.2g}, and chance by "
            f"{chance:.2g}: the friction between balls does not decide how the charge stands"
        )


def _check_range(exponent: float, differences: Mapping[float, float]) -> None:
    if not 0.0 < exponent <= LARGEST_EXPONENT:
        shown = ", ".join(f"{d:+.3g} at k = {k:g}" for k, d in differences.items())
        raise PredictionError(
            f"no k above 0 and up to {LARGEST_EXPONENT:g} matches the mills: -x_c / R differs by "
            f"{shown}"
        )


def _root(k: np.ndarray, values: np.ndarray) -> float:
    """Return where the fit is zero, nearest to the smallest value; nan if nowhere."""
    roots = np.roots(np.polyfit(k, values, min(2, len(k) - 1)))
    real = roots[np.abs(roots.imag) < 1e-9].real
    smallest = k[np.argmin(np.abs(values))]
    return float(real[np.argmin(np.abs(real - smallest))]) if len(real) else math.nan
