"""Fineness of the fragments of one impact: t10 of the JK drop-weight test."""

from __future__ import annotations

import math

import numpy as np

# 1 kWh/t in J/kg.
JOULE_PER_KG = 3600.0


def t10(specific_energy: float | np.ndarray, largest: float, rate: float) -> float | np.ndarray:
    """Return the mass of the fragments finer than a tenth of the particle [%].

        t10 = A (1 - exp(-b E_cs))

    Args:
        specific_energy: E_cs, energy of the impact over the mass of the particle [kWh/t].
        largest: A, t10 of an impact of unlimited energy [%].
        rate: b [t/kWh]. A b is the slope at small energies, a measure of softness.

    Valid for the sizes and energies of the test that A and b were fitted to: particles of 13 to 63
    mm, 0.1 to 2.5 kWh/t (from memory). It has no size: smaller particles are stronger, so A and b
    of the test overrate the fineness of ball mill feed.

    Source: S. S. Narayanan, W. J. Whiten, Trans. IMM C 97 (1988) C115-C124, as public programs
    quote it. The original was not seen.

    Raises:
        ValueError: A or b that no ore has.
    """
    if not (0.0 < largest <= 100.0 and rate > 0.0):
        raise ValueError(f"A = {largest!r} %, b = {rate!r} t/kWh; accepted: 0 < A <= 100, b > 0")
    return -largest * np.expm1(-rate * specific_energy)


def specific_energy_for(fineness: float, largest: float, rate: float) -> float:
    """Return the specific energy [kWh/t] of an impact that gives a t10 [%]; the arguments are those
    of `t10`.

    Raises:
        ValueError: a fineness that no impact reaches.
    """
    if not 0.0 <= fineness < largest:
        raise ValueError(f"t10 = {fineness!r} %; accepted: 0 to below A = {largest:g} %")
    return -math.log1p(-fineness / largest) / rate
