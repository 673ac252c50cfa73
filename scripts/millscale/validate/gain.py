"""Cost of a prediction against that of the single scaled mill of equal error.

The error of single scaled mills is known at a few S, and is zero at S = 1. Between two S it is
interpolated linearly in (S^p - 1) / p at p = 1/2, and the logarithm of the cost linearly in ln S.
An error that changes its sign is small near that S by chance, which nobody knows before S = 1 is
run. So a mill counts with the largest error of all mills of its S or a smaller one.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from millscale.prediction.error_model import EXPONENT
from millscale.prediction.extrapolation import scale_function


@dataclass(frozen=True)
class Single:
    """A single scaled mill, or S = 1, which has no error.

    Attributes:
        cost_s: processor time of one run [s].
        error: its size, in any unit.
    """

    S: float
    cost_s: float
    error: float


def cost_at_equal_error(mills: Sequence[Single], error: float) -> float:
    """Return the cost of the largest S whose error is at most `error` [s].

    An error larger than that of every mill costs as much as the largest S.

    Args:
        mills: S = 1 and one or more others.
    """
    mills = sorted(mills, key=lambda mill: mill.S)
    largest = itertools.accumulate((mill.error for mill in mills), max)
    mills = [replace(mill, error=e) for mill, e in zip(mills, largest, strict=True)][::-1]
    if mills[0].error <= error:
        return mills[0].cost_s
    for larger, smaller in itertools.pairwise(mills):
        if smaller.error <= error:
            return _cost_between(smaller, larger, error)
    return mills[-1].cost_s


def _cost_between(smaller: Single, larger: Single, error: float) -> float:
    """Return the cost at the S between two where the error is `error`."""
    places = [float(scale_function(mill.S, EXPONENT)) for mill in (smaller, larger)]
    at = float(np.interp(error, [smaller.error, larger.error], places))
    S = (1.0 + EXPONENT * at) ** (1.0 / EXPONENT)
    logarithm = np.interp(
        math.log(S),
        [math.log(smaller.S), math.log(larger.S)],
        [math.log(smaller.cost_s), math.log(larger.cost_s)],
    )
    return math.exp(float(logarithm))
