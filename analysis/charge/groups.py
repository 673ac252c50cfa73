"""Two groups of multi-ball cases that differ in one thing, each in several seeds: do they agree?

Every case of one group is compared with every case of the other. The differences between the seeds
of a group are the scale for the result.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import Any

from millscale.analysis.charge.pair import compare_two
from millscale.analysis.charge.scaled_mills import Charge
from millscale.runs.case_folder import RunFolderError

# Errors of a pair that are 0 when its members are the same; overlaps and correlations are 1 then.
DISTANCES = ("contour_error_mean", "contour_error_max", "massflow_rms_over_mean",
             "massflow_rotating_rms_over_mean", "power_error")  # fmt: skip
LIKENESSES = ("curtain_iou_whole", "curtain_iou_upper", "curtain_iou_lower",
              "massflow_correlation", "massflow_rotating_correlation")  # fmt: skip


def compare_groups(first: Sequence[Charge], second: Sequence[Charge]) -> dict[str, Any]:
    """Distances between the groups and within them, and differences of their means.

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
                group[0].finished.folder, "one case alone has no spread", "give two seeds or more"
            )
    between = [_distances(a, b) for a, b in itertools.product(first, second)]
    within = [_distances(*two) for g in (first, second) for two in itertools.combinations(g, 2)]
    return {
        "first": [charge.id for charge in first],
        "second": [charge.id for charge in second],
        "distances": {
            name: _verdict([d[name] for d in between], [d[name] for d in within])
            for name in between[0]
        },
        "means": {name: _means(name, first, second) for name in first[0].result["dimensionless"]},
    }


def _distances(a: Charge, b: Charge) -> dict[str, float]:
    pair = compare_two(a, b)
    known = pair | pair["mean_over_angles"]
    found = {name: abs(known[name]) for name in DISTANCES if known.get(name) is not None}
    return found | {
        f"1 - {name}": 1.0 - known[name] for name in LIKENESSES if known.get(name) is not None
    }


def _verdict(between: Sequence[float], within: Sequence[float]) -> dict[str, Any]:
    mean = sum(between) / len(between)
    return {
        "between": mean,
        "within_mean": sum(within) / len(within),
        "within_largest": max(within),
        "agree": mean <= max(within),
    }


def _means(name: str, first: Sequence[Charge], second: Sequence[Charge]) -> dict[str, Any]:
    values = [[charge.result["dimensionless"][name] for charge in g] for g in (first, second)]
    a, b = (sum(v) / len(v) for v in values)
    largest = max(max(v) - min(v) for v in values)
    return {
        "first": a,
        "second": b,
        "difference": a - b,
        "range_of_seeds": largest,
        "agree": abs(a - b) <= largest,
    }


def markdown(compared: Mapping[str, Any]) -> str:
    """Both parts as one table."""
    lines = ["| quantity | between groups | between seeds, largest | agree |", "|---|---|---|---|"]
    for name, found in compared["distances"].items():
        lines.append(_line(name, found["between"], found["within_largest"], found["agree"]))
    for name, found in compared["means"].items():
        lines.append(_line(name, found["difference"], found["range_of_seeds"], found["agree"]))
    return "\n".join(lines)


def _line(name: str, between: float, largest: float, agree: bool) -> str:
    return f"| {name} | {between:.4f} | {largest:.4f} | {'yes' if agree else 'no'} |"
