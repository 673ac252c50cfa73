"""Predicted wall times of the cases that are left, and of finished ones against measured times.

The latter are in predicted.json of a runs folder.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from pathlib import Path

from millscale.cases.cost import Rates, run_time
from millscale.engine.machine import Allocation
from millscale.formats import counted, duration
from millscale.runs.case_file import Case
from millscale.runs.layout import CASES_FOLDER
from millscale.runs.untrusted import RunFolderError, is_id, read_object
from millscale.runs.writing import write_json
from millscale.workflow.placement import makespan
from millscale.workflow.status import CaseStatus

PREDICTED_FILE = "predicted.json"


def record_predictions(
    runs: Path, cases: Sequence[Case], allocation: Allocation, rates: Rates
) -> None:
    """Add the predicted wall times of cases that are about to run to predicted.json."""
    ranks = allocation.ranks
    entries = {
        x.id: {
            "ranks": ranks[x.id],
            "steps": x.time.steps,
            "wall_time_s": run_time(x, x.time.steps, ranks[x.id], rates),
        }
        for x in cases
    }
    write_json(runs / PREDICTED_FILE, _read(runs) | entries)


def errors(runs: Path) -> dict[str, tuple[float, float]]:
    """Return predicted and measured wall time of finished rotations [s], by case id.

    A run that resumed from a restart file timed only part of the steps; its time is scaled up.
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
    """Return measured over predicted times as a line; empty if nothing can be compared."""
    pairs = errors(runs)
    if not pairs:
        return ""
    predicted = sum(x for x, _ in pairs.values())
    measured = sum(x for _, x in pairs.values())
    farthest = max(pairs, key=lambda x: abs(math.log(pairs[x][0] / pairs[x][1])))
    line = f"rotation of {counted(len(pairs), 'case')}: {_compared(predicted, measured)}"
    if len(pairs) == 1:
        return line
    return f"{line}; farthest {farthest}: {_compared(*pairs[farthest])}"


def _compared(predicted: float, measured: float) -> str:
    times = f"{duration(predicted)} predicted, {duration(measured)} measured"
    return f"{times} ({measured / predicted:.2g} times)"


def _read(runs: Path) -> dict:
    try:
        return read_object(runs / PREDICTED_FILE, "")
    except RunFolderError:
        return {}


def time_left(
    statuses: Iterable[CaseStatus], cases: dict[str, Case], allocation: Allocation
) -> float:
    """Return the wall time until the last case is done [s].

    A running case keeps its rate. A waiting case gets the mean rate of the running cases of its
    kind, or the rate that case.json predicts. Cases share the cores as in the run.

    Args:
        cases: case by id.
    """
    waiting = [x for x in statuses if x.state not in ("done", "failed")]
    loads = []
    for kind in dict.fromkeys(x.kind for x in waiting):
        of_kind = [x for x in waiting if x.kind == kind]
        rates = [x.particle_steps_per_s for x in of_kind if x.particle_steps_per_s]
        mean = sum(rates) / len(rates) if rates else None
        for x in of_kind:
            rate = x.particle_steps_per_s or mean or _predicted(cases[x.id])
            loads.append(((x.steps - x.step) * x.balls / rate, allocation.ranks[x.id]))
    return makespan(loads, allocation.cores, allocation.jobs)


def _predicted(case: Case) -> float:
    """Return the particle-steps per second that case.json predicts."""
    return case.predicted.particle_steps / case.predicted.wall_time_s
