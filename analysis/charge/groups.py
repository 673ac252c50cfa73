"""Agreement of two groups of multi-ball cases that differ in one setting, with several seeds each.

Every case of one group is compared with every case of the other. The differences between the seeds
of a group are the scale for the result.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from millscale.analysis.charge.measured import Measured, measure
from millscale.analysis.charge.pair import check_whole
from millscale.analysis.charge.scaled_mills import Pair
from millscale.analysis.finished import Charge
from millscale.analysis.measures import ERRORS, NUMBERS, ErrorColumn
from millscale.runs.untrusted import RunFolderError

Group = Sequence[Charge]


def compare_groups(first: Group, second: Group) -> dict[str, Any]:
    """Return distances between the groups and within them, and differences of their means.

    A distance is an error of docs/reference/files.md, or 1 minus an overlap or correlation.
    The groups agree in a distance if its mean between them is no larger than the largest within
    one group. They agree in a mean if the groups differ by no more than the range of one group.

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


def agreement(first: Group, second: Group, measured: Measured) -> dict[str, Any]:
    """Return the result of `compare_groups` for charges that are measured."""

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
    return {
        "first": [charge.id for charge in first],
        "second": [charge.id for charge in second],
        "distances": {name: _verdict(*both) for name, both in compared.items() if all(both)},
        "means": {name: _means(*both) for name, both in numbers.items() if all(both)},
    }


def _between(first: Group, second: Group) -> list[Pair]:
    return list(itertools.product(first, second))


def _within(first: Group, second: Group) -> list[Pair]:
    return [pair for group in (first, second) for pair in itertools.combinations(group, 2)]


def _known(values: Iterable[float | None]) -> list[float]:
    return [value for value in values if value is not None]


def _verdict(between: Sequence[float], within: Sequence[float]) -> dict[str, Any]:
    mean = sum(between) / len(between)
    return {
        "between": mean,
        "within_mean": sum(within) / len(within),
        "within_largest": max(within),
        "agree": mean <= max(within),
    }


def _means(first: Sequence[float], second: Sequence[float]) -> dict[str, Any]:
    a, b = (sum(values) / len(values) for values in (first, second))
    largest = max(max(values) - min(values) for values in (first, second))
    return {
        "first": a,
        "second": b,
        "difference": a - b,
        "range_of_seeds": largest,
        "agree": abs(a - b) <= largest,
    }


def markdown(compared: Mapping[str, Any]) -> str:
    """Return both parts as one table."""
    lines = ["| quantity | between groups | between seeds, largest | agree |", "|---|---|---|---|"]
    for name, found in compared["distances"].items():
        lines.append(_line(name, found["between"], found["within_largest"], found["agree"]))
    for name, found in compared["means"].items():
        lines.append(_line(name, found["difference"], found["range_of_seeds"], found["agree"]))
    return "\n".join(lines)


def _line(name: str, between: float, largest: float, agree: bool) -> str:
    return f"| {name} | {between:.4f} | {largest:.4f} | {'yes' if agree else 'no'} |"
