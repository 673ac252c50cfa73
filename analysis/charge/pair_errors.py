"""Errors of one charge against another, in every quantity of `measures`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from millscale.analysis.means import mean_known
from millscale.analysis.measures import ERRORS, QUANTITIES, Taken, Value

# Errors of one dump; their means over the mill angles are shown.
OF_DUMPS = tuple(
    error.name
    for quantity in QUANTITIES
    if quantity.taken is Taken.AT_DUMPS
    for error in quantity.errors
    if not error.by_curtain
)


@dataclass(frozen=True)
class Dumps:
    """Mill angles of the dumps that two charges share [rad].

    Attributes:
        last: the last of all.
        first: the first in the steady part of both.
        count: of those in the steady part.
    """

    last: float | None
    first: float | None
    count: int


@dataclass(frozen=True)
class PairErrors:
    """Errors by the name of their `measures.ErrorColumn`; None where a run lacks what is compared.

    Attributes:
        values: of the whole run; those of dumps at the last mill angle that both charges have.
        over_angles: of the names in OF_DUMPS: mean over the steady part; None of a reference, which
            is not compared.
        dumps: None for means over several pairs.
    """

    values: Mapping[str, Value]
    over_angles: Mapping[str, float | None] | None
    dumps: Dumps | None = None

    def steady(self, name: str) -> float | None:
        """Return an error in the mean over the steady part of the rotation."""
        if name in OF_DUMPS:
            return self.over_angles[name] if self.over_angles else None
        return self.values[name]

    def document(self) -> dict[str, Any]:
        """Return its keys in a row of results.json."""
        content, means = dict(self.values), self.over_angles
        if self.dumps is not None:
            content = {"mill_angle_rad": self.dumps.last, **content}
            if means is not None:
                steady = {"from_rad": self.dumps.first, "to_rad": self.dumps.last}
                means = {**steady, "angles": self.dumps.count, **means}
        return {**content, "mean_over_angles": None if means is None else dict(means)}


def no_errors(mill_angle: float | None) -> PairErrors:
    """Return the errors of a reference, which is not compared.

    Args:
        mill_angle: of its last dump [rad].
    """
    values = dict.fromkeys(error.name for error in ERRORS)
    return PairErrors(values, None, Dumps(mill_angle, None, 0))


def errors_of_dumps(ours: Any, theirs: Any) -> dict[str, Value]:
    """Return the errors of one shape against another at the same mill angle."""
    found = {}
    for quantity in QUANTITIES:
        if quantity.taken is Taken.AT_DUMPS:
            found |= quantity.compared(quantity.read(ours), quantity.read(theirs))
    return found


def mean_of_pairs(pairs: Sequence[PairErrors]) -> PairErrors:
    """Return the mean over several pairs; of signed errors that of their magnitudes."""

    def size(value: Value, signed: bool) -> Value:
        return abs(value) if signed and isinstance(value, float) else value

    values = {
        error.name: mean_known(size(pair.values[error.name], error.signed) for pair in pairs)
        for error in ERRORS
    }
    over_angles = {name: mean_known(pair.steady(name) for pair in pairs) for name in OF_DUMPS}
    return PairErrors(values, over_angles)
