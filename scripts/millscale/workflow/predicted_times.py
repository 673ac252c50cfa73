"""predicted.json of a runs folder: what rotations were expected to take, against timing.json."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from millscale.cases.cost import Rates, run_time
from millscale.engine.machine import Allocation
from millscale.formats import duration
from millscale.runs.case_file import Case
from millscale.runs.layout import CASES_FOLDER
from millscale.runs.untrusted import RunFolderError, is_id, read_object
from millscale.runs.writing import write_json

PREDICTED_FILE = "predicted.json"


def record_predictions(
    runs: Path, cases: Sequence[Case], allocation: Allocation, rates: Rates
) -> None:
    """Add to predicted.json what the cases about to run are expected to take."""
    ranks = allocation.ranks
    entries = {
        x.id: {
            "ranks": ranks[x.id],
            "steps": x["time"]["steps"],
            "wall_time_s": run_time(x, x["time"]["steps"], ranks[x.id], rates),
        }
        for x in cases
    }
    write_json(runs / PREDICTED_FILE, _read(runs) | entries)


def errors(runs: Path) -> dict[str, tuple[float, float]]:
    """Predicted and measured wall time of the rotations that are done [s], by case id.

    A run that went on from a restart file timed part of the steps, and counts in proportion.
    """
    pairs = {}
    for case_id, entry in _read(runs).items():
        try:
            if not is_id(case_id):
                continue
            timing = read_object(runs / CASES_FOLDER / case_id / "timing.json", "")
            of_all = float(entry["steps"]) / float(timing["steps"])
            measured = float(timing["wall_time_s"]) * of_all
            predicted = float(entry["wall_time_s"])
        except (ValueError, KeyError, TypeError, ArithmeticError):
            continue
        if 0.0 < predicted < math.inf and 0.0 < measured < math.inf:
            pairs[case_id] = predicted, measured
    return pairs


def error_line(runs: Path) -> str:
    """The error of the predictions in a line; empty if nothing can be compared."""
    pairs = errors(runs)
    if not pairs:
        return ""
    predicted = sum(x for x, _ in pairs.values())
    measured = sum(x for _, x in pairs.values())
    farthest = max(pairs, key=lambda x: abs(math.log(pairs[x][0] / pairs[x][1])))
    one, other = pairs[farthest]
    return (
        f"rotation of {len(pairs)} cases: {duration(predicted)} predicted, {duration(measured)} "
        f"taken, error {predicted / measured - 1.0:+.0%}; farthest off {farthest}: "
        f"{duration(one)} predicted, {duration(other)} taken"
    )


def _read(runs: Path) -> dict:
    try:
        return read_object(runs / PREDICTED_FILE, "")
    except RunFolderError:
        return {}
