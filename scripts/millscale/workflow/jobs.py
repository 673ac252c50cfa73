"""Jobs of a run: one case each, or several small ones. Their file is in DIR/.jobs/<run>/."""

from __future__ import annotations

import math
import os
import shutil
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from millscale.cases.cost import Rates, memory_mb, wall_time
from millscale.engine.machine import Allocation
from millscale.runs.case_file import MOST_RANKS, Case
from millscale.runs.typed import as_typed
from millscale.runs.untrusted import is_id, read_json, understood
from millscale.runs.writing import write_json

JOBS_FOLDER = ".jobs"
JOBS_FILE = "jobs.json"
# Stages without the engine: mesh, decks, analysis [s per case].
STAGES_S = 0.2
# Time requested of a batch system over the time predicted, and the least [s]: nodes differ, and a
# job that reaches its limit has to be queued again.
TIME_MARGIN = 2.0
LEAST_TIME_S = 600.0
_REMEDY = "written by: millscale run FILE --runs DIR"


@dataclass(frozen=True)
class Job:
    """Cases that run one after the other in one process.

    Attributes:
        name: unique within a run.
        cases: their ids.
        ranks: cores it takes.
        time_s: predicted wall time [s].
        minutes: time to request of a batch system.
        memory_mb: memory of a node to request of a batch system.
        nodes: nodes of a batch system over which the ranks are spread.
    """

    name: str
    cases: tuple[str, ...]
    ranks: int
    time_s: float
    minutes: int
    memory_mb: int
    nodes: int = 1


def jobs_of(
    cases: Sequence[Case],
    allocation: Allocation,
    rates: Rates,
    shared_job_s: Callable[[Allocation, float], float],
) -> list[Job]:
    """Return the jobs of the cases, the longest first.

    Small cases of one rank share a job, in the order of the campaign.

    Args:
        shared_job_s: how long such a job may take [s], as `Target.shared_job_s`.
    """
    times = {x.id: STAGES_S + wall_time(x, allocation.ranks[x.id], rates) for x in cases}
    longest = shared_job_s(allocation, sum(times.values()))
    groups: list[list[Case]] = []
    room: dict[str, float] = {}
    open_group: dict[str, list[Case]] = {}
    for case in cases:
        needed = times[case.id]
        small = allocation.ranks[case.id] == 1
        if not small or needed > room.get(case.kind, 0.0):
            groups.append([])
            if small:
                open_group[case.kind], room[case.kind] = groups[-1], longest
        (open_group[case.kind] if small else groups[-1]).append(case)
        room[case.kind] = room.get(case.kind, 0.0) - (needed if small else 0.0)
    made = [_job(group, allocation, times) for group in groups]
    return sorted(made, key=lambda job: -job.time_s)


def _job(group: Sequence[Case], allocation: Allocation, times: dict[str, float]) -> Job:
    ranks, nodes = allocation.ranks[group[0].id], allocation.nodes_of(group[0].id)
    total = sum(times[case.id] for case in group)
    return Job(
        name=group[0].id if len(group) == 1 else f"{group[0].id}-and-{len(group) - 1}-more",
        cases=tuple(case.id for case in group),
        ranks=ranks,
        time_s=total,
        minutes=math.ceil(max(TIME_MARGIN * total, LEAST_TIME_S) / 60.0),
        memory_mb=max(memory_mb(case, ranks, nodes) for case in group),
        nodes=nodes,
    )


def write_jobs(runs: Path, jobs: Sequence[Job]) -> Path:
    """Write the jobs of a run; return the file.

    Jobs of earlier runs are deleted, so that a job that still waits in a queue ends at once
    instead of running its cases a second time.
    """
    shutil.rmtree(runs / JOBS_FOLDER, ignore_errors=True)
    folder = runs / JOBS_FOLDER / f"{int(time.time())}-{os.getpid()}"
    folder.mkdir(parents=True)
    file = folder / JOBS_FILE
    write_json(file, [asdict(job) for job in jobs])
    return file


def read_jobs(file: Path) -> list[Job]:
    """Return the jobs of a run.

    Raises:
        RunFolderError: the file is not one of `write_jobs`.
    """
    content = read_json(file, _REMEDY)
    with understood(file, _REMEDY):
        jobs = [as_typed(Job, entry) for entry in content]
        for job in jobs:
            placed = 0 < job.nodes <= job.ranks <= MOST_RANKS
            if not (placed and all(map(is_id, job.cases))):
                placing = f"ranks {job.ranks}, nodes {job.nodes}"
                raise ValueError(f"{placing} or cases {job.cases!r:.60}")
        return jobs


def job_named(jobs: Iterable[Job], name: str) -> Job:
    """Return the job of a name; KeyError if there is none."""
    return {job.name: job for job in jobs}[name]
