"""Errors of each setting of a parameter study against its reference, without what chance adds.

Two runs that differ only in the random packing also differ. With D the root mean square distance of
two runs and V = D^2 / 2 between seeds, the variance that chance adds to a run,

    error^2  = D^2(setting, reference) - V(setting) - V(reference), at least 0
    spread^2 = V(setting) / n + V(reference) / m

of n and m seeds. The error is the distance of their means without chance. The spread is the
distance that means of so many seeds have by chance alone. For numbers and for root mean squares of
curves both are exact: the second is the standard error of a difference of means; for the first see
Szekely and Rizzo 2013, doi 10.1016/j.jspi.2013.03.018. The distance of contours and curtains is no
root mean square; for them both hold where either error or chance is small. Derived here.

Three seeds give V to a factor of two. So V is the mean over all settings of the same S and number
of balls, and a setting that scatters more has the excess in its error.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from millscale.analysis.charge.measured import Measured
from millscale.analysis.charge.scaled_mills import Pair, ScaledMill
from millscale.analysis.measures import STUDIED


@dataclass(frozen=True)
class StudyError:
    """An error of a setting; None where it is not known.

    Attributes:
        error, spread: of the docstring of the module; without any V the error is D.
        within_spread: whether the error is no larger than the spread.
        distance: D.
        scatter: what chance adds to a single run of the setting, the square root of its own V.
    """

    error: float | None = None
    spread: float | None = None
    within_spread: bool | None = None
    distance: float | None = None
    scatter: float | None = None

    @property
    def resolved(self) -> float | None:
        """Return the error, or its spread if that is larger."""
        if self.error is None or not math.isfinite(self.error):
            return None
        return max(self.error, self.spread or 0.0)

    @property
    def bound(self) -> float | None:
        """Return error plus spread, which a recommendation claims. An error without a spread still
        contains all of chance."""
        return None if self.resolved is None else self.error + (self.spread or 0.0)


def reference_for(mill: ScaledMill, mills: Sequence[ScaledMill], setting: str) -> ScaledMill:
    """Return the reference of a mill: the largest mill (smallest S) of a setting, there of its own
    scheme and policy if possible.

    Args:
        setting: name of the reference setting.

    Raises:
        ValueError: nothing of that setting is finished.
    """
    known = [other for other in mills if other.name.campaign == setting]
    if not known:
        raise ValueError(f"no finished case of the reference, setting {setting!r}")

    def unlike(other: ScaledMill) -> tuple:
        return other.name.S, *(a != b for a, b in zip(other.name[1:4], mill.name[1:4], strict=True))

    return min(known, key=unlike)


def pairs_of(first: ScaledMill, second: ScaledMill) -> list[Pair]:
    """Return the runs of two mills to compare: those of different seeds, since equal packings may
    stay alike for a while; all if there are no others. Of one mill every two seeds, once."""
    if first is second:
        return first.pairs()
    every = [(a, b) for a in first.seeds for b in second.seeds]
    return [(a, b) for a, b in every if a.seed != b.seed] or every


def compared_pairs(mills: Sequence[ScaledMill], references: Sequence[ScaledMill]) -> list[Pair]:
    """Return what has to be measured: the seeds of each mill against one another and against those
    of its reference."""
    wanted = [(mill, mill) for mill in mills]
    wanted += [(m, r) for m, r in zip(mills, references, strict=True) if m is not r]
    return list(dict.fromkeys(pair for m, r in wanted for pair in pairs_of(m, r)))


@dataclass(frozen=True)
class Distances:
    """Root mean square distances between the mills of a parameter study.

    Attributes:
        measured: of the `compared_pairs` of the mills.
    """

    mills: Sequence[ScaledMill]
    measured: Measured

    def between(self, first: ScaledMill, second: ScaledMill, name: str) -> float | None:
        """Return the root mean square distance of runs of two mills; None if nothing could be
        compared.

        Args:
            name: of an error, a key of STUDIED.
        """
        error = STUDIED[name]
        found = [
            error.distance(self.measured.errors[pair].steady(error.name))
            for pair in pairs_of(first, second)
        ]
        known = [value for value in found if value is not None]
        return math.sqrt(float(np.mean(np.square(known)))) if known else None

    def scatter(self, mill: ScaledMill, name: str) -> float | None:
        """Return the square root of the V of a mill itself; None for one seed."""
        own = self.between(mill, mill, name)
        return None if own is None else math.sqrt(0.5) * own

    def chance(self, mill: ScaledMill, name: str) -> float | None:
        """Return V for a mill: the mean over the mills of its S and number of balls; if none of
        them has several seeds, over those nearest in S, then in balls; None if no mill has."""

        def remoteness(other: ScaledMill) -> tuple[float, int]:
            return abs(other.name.S - mill.name.S), abs(other.first.balls - mill.first.balls)

        scatters = [(remoteness(other), self.scatter(other, name)) for other in self.mills]
        known = [(remote, value) for remote, value in scatters if value is not None]
        nearest = min(known, default=None)
        if nearest is None:
            return None
        return float(np.mean([value**2 for remote, value in known if remote == nearest[0]]))


def errors_of(
    mill: ScaledMill, reference: ScaledMill, distances: Distances
) -> dict[str, StudyError]:
    """Return each of STUDIED of a mill against its reference."""
    return {name: _error(mill, reference, distances, name) for name in STUDIED}


def _error(mill: ScaledMill, reference: ScaledMill, distances: Distances, name: str) -> StudyError:
    scatter = distances.scatter(mill, name)
    far = None if mill is reference else distances.between(mill, reference, name)
    if far is None:
        return StudyError(scatter=scatter)
    chance = [distances.chance(one, name) for one in (mill, reference)]
    if None in chance:
        return StudyError(error=far, distance=far, scatter=scatter)
    error = math.sqrt(max(0.0, far**2 - sum(chance)))
    counts = [len(one.seeds) for one in (mill, reference)]
    spread = math.sqrt(sum(v / n for v, n in zip(chance, counts, strict=True)))
    return StudyError(error, spread, error <= spread, far, scatter)
