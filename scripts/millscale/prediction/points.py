"""Extrapolation of many points of a curve or field at once, with the noise of all of them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from millscale.prediction.extrapolation import (
    ExtrapolationError,
    Group,
    Noise,
    Prior,
    extrapolate,
)
from millscale.prediction.noise import FEWEST_SEED_FREEDOM, PITCHES, SEEDS

# S and the values (points,) float of each run.
PointGroups = Sequence[tuple[float, Sequence[np.ndarray]]]


def extrapolate_points(
    groups: PointGroups, noise: Noise, level: float, prior: Prior
) -> tuple[np.ndarray, np.ndarray]:
    """Return values at S = 1 and half widths of their intervals, (points,) float each.

    Raises:
        ExtrapolationError: fewer than two values of S, or too close together.
    """
    values, half_widths = [], []
    for i in range(len(groups[0][1][0])):
        at_point = [Group(S, tuple(float(run[i]) for run in runs)) for S, runs in groups]
        found = extrapolate(at_point, noise, level, prior)
        values.append(found.value)
        half_widths.append(found.half_width)
    return np.array(values), np.array(half_widths)


def noise_of_points(groups: PointGroups, otherwise: Noise | None) -> tuple[Noise, str]:
    """Return the noise of one run at one point, and what it was found from.

    From the seeds of each S, pooled over all points, where they have degrees of freedom enough.

    Args:
        otherwise: from the scatter within the runs; None if it is not known.

    Raises:
        ExtrapolationError: neither is known.
    """
    freedom = sum(len(runs) - 1 for _, runs in groups)
    if otherwise is not None and freedom < FEWEST_SEED_FREEDOM:
        return otherwise, PITCHES
    if freedom == 0:
        raise ExtrapolationError("no value of S has two seeds: the noise is not known; add a seed")
    squares = [
        np.sum((np.array(runs) - np.mean(runs, axis=0)) ** 2, axis=0)
        for _, runs in groups
        if len(runs) > 1
    ]
    return Noise(
        math.sqrt(float(np.mean(np.sum(squares, axis=0))) / freedom), float(freedom)
    ), SEEDS
