"""When the cases that are left will be done."""

from __future__ import annotations

from collections.abc import Iterable

from millscale.engine.machine import Allocation
from millscale.runs.case_file import Case
from millscale.workflow.placement import makespan
from millscale.workflow.status import CaseStatus


def time_left(
    statuses: Iterable[CaseStatus], cases: dict[str, Case], allocation: Allocation
) -> float:
    """Wall time until the last case is done [s].

    A running case goes on at its rate. One that waits goes at the mean rate of those of its kind
    that run, or else as case.json predicts. Cases share the cores as they will.

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
    """Particle-steps per second that case.json expects."""
    return case["predicted"]["particle_steps"] / case["predicted"]["wall_time_s"]
