"""Selection function of Austin, and its fit to rates of any origin."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

MILLIMETRE = 1e-3


@dataclass(frozen=True)
class AustinSelection:
    """Specific rate of breakage by size in a ball mill.

        S = a (x / 1 mm)^alpha / (1 + (x / mu)^Lambda)

    Attributes:
        rate: a, in the unit of S; usually per minute.
        exponent: alpha.
        size: mu, where S is half of the power law [m].
        fall: Lambda, above alpha if large particles break slower.

    Valid for one ore, one size of balls and one filling; a and mu change with them. Breakage of
    first order: the rate does not depend on time.

    Source: L. G. Austin, R. R. Klimpel, P. T. Luckie, Process Engineering of Size Reduction: Ball
    Milling, SME 1984, as public programs quote it. The original was not seen.

    Raises:
        ValueError: a constant that is not above 0.
    """

    rate: float
    exponent: float
    size: float
    fall: float

    def __post_init__(self) -> None:
        if not min(self.rate, self.exponent, self.size, self.fall) > 0.0:
            raise ValueError(f"{self}; accepted: constants above 0")

    def at(self, sizes: np.ndarray) -> np.ndarray:
        """Return S at sizes [m], (n,) float."""
        sizes = np.asarray(sizes, float)
        power = self.rate * (sizes / MILLIMETRE) ** self.exponent
        return power / (1.0 + (sizes / self.size) ** self.fall)

    @property
    def fastest(self) -> float | None:
        """Size that breaks fastest [m]: mu (alpha / (Lambda - alpha))^(1 / Lambda), derived here;
        None if larger particles always break faster."""
        if self.fall <= self.exponent:
            return None
        return self.size * (self.exponent / (self.fall - self.exponent)) ** (1.0 / self.fall)


def fit_austin(sizes: np.ndarray, rates: np.ndarray) -> tuple[AustinSelection, float]:
    """Return the selection function nearest to some rates, and the root mean square of the
    logarithm of the ratio.

    Args:
        sizes: (n,) float [m]. rates: (n,) float, above 0.

    Raises:
        ValueError: fewer than five rates above 0.
    """
    sizes, rates = np.asarray(sizes, float), np.asarray(rates, float)
    used = rates > 0.0
    if used.sum() < 5:
        raise ValueError(f"{used.sum()} rates above 0; accepted: 5 or more")
    x, y = np.log(sizes[used] / MILLIMETRE), np.log(rates[used])

    def errors(logs: np.ndarray) -> np.ndarray:
        rate, exponent, size, fall = logs[0], math.exp(logs[1]), logs[2], math.exp(logs[3])
        return rate + exponent * x - np.logaddexp(0.0, fall * (x - size)) - y

    best = min(
        (
            least_squares(errors, [y.max(), 0.0, start, math.log(3.0)], max_nfev=2000)
            for start in np.quantile(x, [0.3, 0.7, 1.0])
        ),
        key=lambda found: found.cost,
    )
    rate, exponent, size, fall = best.x
    made = AustinSelection(
        math.exp(rate), math.exp(exponent), MILLIMETRE * math.exp(size), math.exp(fall)
    )
    return made, math.sqrt(float(np.mean(best.fun**2)))
