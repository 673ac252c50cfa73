"""Surrogate of a simulated number: a Gaussian process over the unit cube of the parameters.

The number is a linear trend with a wide prior, a smooth deviation from it, and noise:

    y(x) = b_0 + b x + f(x) + noise,    cov f = s^2 exp(-1/2 sum_j ((x_j - x'_j) / l_j)^2)

The lengths l_j, the size s and the noise that the runs do not state are the most probable ones
(Rasmussen and Williams, Gaussian Processes for Machine Learning, 2006, eqs. 2.25, 2.26, 5.8). A
length far above 1 is a parameter that acts linearly or not at all.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.optimize import minimize

# Deviation of the coefficients of the trend, over that of the values.
TREND = 3.0
# Medians and deviations of the logarithms before anything is known: of the lengths over the cube,
# of the size and of the unknown noise over the deviation of the values.
LENGTH, SIZE, NOISE = (0.7, 0.7), (0.5, 1.0), (0.02, 1.5)
# Least noise over the deviation of the values, which keeps the matrix well conditioned.
LEAST_NOISE = 1e-3
# Lengths from which the search for the most probable ones begins.
STARTS = (0.3, 1.0)


@dataclass(frozen=True)
class Surrogate:
    """What some runs say of a number at any place of the cube.

    Attributes:
        places: (n, d) float in [0, 1], of the runs.
        lengths: (d,) float, l_j.
        size: s, in the unit of the number.
        noise: (n,) float, deviation of each run, stated and found, in the unit of the number.
    """

    places: np.ndarray
    lengths: np.ndarray
    size: float
    noise: np.ndarray
    _mean: float
    _trend: float
    _values: np.ndarray
    _inverse: np.ndarray

    def at(self, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return mean and standard deviation of the number without noise, (m,) float each.

        Args:
            places: (m, d) float.
        """
        covariance = self._covariance(places)
        mean = self._mean + covariance @ (self._inverse @ self._values)
        before = self.size**2 + self._trend**2 * (1.0 + np.sum((places - 0.5) ** 2, axis=1))
        known = np.einsum("ij,ij->i", covariance @ self._inverse, covariance)
        return mean, np.sqrt(np.maximum(before - known, 0.0))

    def left_out(self) -> np.ndarray:
        """Return the error of the prediction of each run from the others, over its standard
        deviation, (n,) float (the same, eqs. 5.10 to 5.12)."""
        diagonal = np.diag(self._inverse)
        return (self._inverse @ self._values) / np.sqrt(diagonal)

    def with_place(self, place: np.ndarray) -> Surrogate:
        """Return the surrogate after a further run at a place, (d,) float, that gave its mean: the
        deviations do not depend on what a run gives."""
        value = self.at(place[None])[0]
        return _conditioned(
            np.vstack([self.places, place]),
            np.append(self._values + self._mean, value),
            np.append(self.noise, float(np.median(self.noise))),
            (self.lengths, self.size),
            (self._mean, self._trend),
        )

    def _covariance(self, places: np.ndarray) -> np.ndarray:
        return _kernel(places, self.places, self.lengths, self.size, self._trend)


def fit(places: np.ndarray, values: np.ndarray, noise: Sequence[float | None]) -> Surrogate:
    """Return the surrogate of some runs.

    Args:
        places: (n, d) float in [0, 1].
        values: (n,) float.
        noise: standard deviation of each run; None where it is not known.
    """
    unit = float(np.std(values)) or 1.0
    mean = float(np.mean(values))
    stated = np.array([0.0 if one is None else one for one in noise]) / unit
    scaled = (values - mean) / unit

    def split(logs: np.ndarray) -> tuple[np.ndarray, float, np.ndarray]:
        own = np.exp(logs)
        return own[:-2], float(own[-2]), np.hypot(stated, max(float(own[-1]), LEAST_NOISE))

    def improbability(logs: np.ndarray) -> float:
        lengths, size, noises = split(logs)
        matrix = _kernel(places, places, lengths, size, TREND) + np.diag(noises**2)
        try:
            factor = cho_factor(matrix, lower=True)
        except np.linalg.LinAlgError:
            return 1e9
        data = scaled @ cho_solve(factor, scaled) + 2.0 * np.sum(np.log(np.diag(factor[0])))
        return 0.5 * float(data) + _improbability(logs)

    dimensions = places.shape[1]
    bounds = [(np.log(0.05), np.log(20.0))] * dimensions + [(-7.0, 3.0), (-9.0, 0.5)]
    found: list[Any] = [
        minimize(
            improbability,
            np.log([start] * dimensions + [SIZE[0], NOISE[0]]),
            method="L-BFGS-B",
            bounds=bounds,
        )
        for start in STARTS
    ]
    lengths, size, noises = split(min(found, key=lambda one: one.fun).x)
    return _conditioned(places, values, unit * noises, (lengths, unit * size), (mean, unit * TREND))


def _improbability(logs: np.ndarray) -> float:
    """Return minus the logarithm of the prior of the hyperparameters, but for a constant."""
    medians = [LENGTH] * (len(logs) - 2) + [SIZE, NOISE]
    return sum(
        0.5 * float(((log - np.log(median)) / deviation) ** 2)
        for log, (median, deviation) in zip(logs, medians, strict=True)
    )


def _conditioned(
    places: np.ndarray,
    values: np.ndarray,
    noise: np.ndarray,
    process: tuple[np.ndarray, float],
    trend: tuple[float, float],
) -> Surrogate:
    """Return the surrogate of given hyperparameters.

    Args:
        process: lengths and size.
        trend: mean of the values, and deviation of the coefficients.
    """
    matrix = _kernel(places, places, *process, trend[1]) + np.diag(noise**2)
    inverse = cho_solve(cho_factor(matrix, lower=True), np.eye(len(places)))
    return Surrogate(places, *process, noise, *trend, values - trend[0], inverse)


def _kernel(
    first: np.ndarray, second: np.ndarray, lengths: np.ndarray, size: float, trend: float
) -> np.ndarray:
    a, b = first / lengths, second / lengths
    squares = np.sum(a**2, axis=1)[:, None] + np.sum(b**2, axis=1) - 2.0 * a @ b.T
    linear = 1.0 + (first - 0.5) @ (second - 0.5).T
    return size**2 * np.exp(-0.5 * np.maximum(squares, 0.0)) + trend**2 * linear
