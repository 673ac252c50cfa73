"""Agreement of two groups of multi-ball cases that differ in one setting, with several seeds each.

Every case of one group is compared with every case of the other. The differences between the seeds
of a group are the scale for the result.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from millscale.analysis.charge.measured import Measured, measure
from millscale.analysis.charge.pair import check_whole
from millscale.analysis.charge.scaled_mills import Pair
from millscale.analysis.finished import Charge
from millscale.analysis.measures import ERRORS, NUMBERS, ErrorColumn
from millscale.runs.untrusted import RunFolderError

Group = Sequence[Charge]


@dataclass(frozen=True)
class Distance:
    """An error between the groups and within them, or 1 minus an overlap or correlation.

    Attributes:
        between: mean over the pairs of a case of each group.
        within_mean, within_largest: over the pairs of seeds of one group.
    """

    between: float
    within_mean: float
    within_largest: float
    agree: bool


@dataclass(frozen=True)
class Means:
    """A number of the charges in the mean over each group.

    Attributes:
        range_of_seeds: the larger of the ranges within a group.
    """

    first: float
    second: float
    difference: float
    range_of_seeds: float
    agree: bool


@dataclass(frozen=True)
class Agreement:
    """Two groups compared in all quantities; `first` and `second` are the ids of their cases.

    A distance agrees if its mean between the groups is no larger than the largest within one group.
    A mean agrees if the groups differ by no more than the range of one group.
    """

    first: list[str]
    second: list[str]
    distances: dict[str, Distance]
    means: dict[str, Means]

    def document(self) -> dict[str, Any]:
        """Return the content of a file; keys: docs/reference/result-files.md."""
        return asdict(self)


def compare_groups(first: Group, second: Group) -> Agreement:
    """Return whether two groups agree.

    Args:
        first, second: two seeds or more each.

    Raises:
        RunFolderError: no dumps, a damaged one, or a single case.
    """
    for group in (first, second):
        if len(group) < 2:
            raise RunFolderError(
                group[0].folder, "one case alone has no spread", "give two seeds or more"
            )
    measured = measure([*first, *second], [*_between(first, second), *_within(first, second)])
    check_whole(measured)
    return agreement(first, second, measured)


def agreement(first: Group, second: Group, measured: Measured) -> Agreement:
    """Return whether two groups agree whose charges are measured."""

    def distances(error: ErrorColumn, pairs: Iterable[Pair]) -> list[float]:
        return _known(error.distance(measured.errors[pair].steady(error.name)) for pair in pairs)

    def means(name: str, group: Group) -> list[float]:
        return _known(measured.numbers[charge][name] for charge in group)

    compared = {
        error.distance_name: (
            distances(error, _between(first, second)),
            distances(error, _within(first, second)),
        )
        for error in ERRORS
        if not error.by_curtain
    }
    numbers = {x.name: (means(x.name, first), means(x.name, second)) for x in NUMBERS}
    return Agreement(
        first=[charge.id for charge in first],
        second=[charge.id for charge in second],
        distances={name: _distance(*both) for name, both in compared.items() if all(both)},
        means={name: _means(*both) for name, both in numbers.items() if all(both)},
    )


def _between(first: Group, second: Group) -> list[Pair]:
    return list(itertools.product(first, second))


def _within(first: Group, second: Group) -> list[Pair]:
    return [pair for group in (first, second) for pair in itertools.combinations(group, 2)]


def _known(values: Iterable[float | None]) -> list[float]:
    return [value for value in values if value is not None]


def _distance(between: Sequence[float], within: Sequence[float]) -> Distance:
    mean = sum(between) / len(between)
    return Distance(mean, sum(within) / len(within), max(within), mean <= max(within))


def _means(first: Sequence[float], second: Sequence[float]) -> Means:
    a, b = (sum(values) / len(values) for values in (first, second))
    largest = max(max(values) - min(values) for values in (first, second))
    return Means(a, b, a - b, largest, abs(a - b) <= largest)


def markdown(compared: Agreement) -> str:
    """Return distances and means as one table."""
    lines = ["| quantity | between groups | between seeds, largest | agree |", "|---|---|---|---|"]
    for name, x in compared.distances.items():
        lines.append(_line(name, x.between, x.within_largest, x.agree))
    for name, mean in compared.means.items():
        lines.append(_line(name, mean.difference, mean.range_of_seeds, mean.agree))
    return "\n".join(lines)


def _line(name: str, between: float, largest: float, agree: bool) -> str:
    return f"| {name} | {between:.4f} | {largest:.4f} | {'yes' if agree else 'no'} |"
