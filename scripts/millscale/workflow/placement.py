"""MPI ranks of each case, and the wall time of a campaign with them.

Ghost balls make each further rank less efficient, so running cases at the same time comes first.
All cases start with one rank. While the longest case takes longer than all work spread over all
cores, it gets one rank more (Belkhale and Banerjee, ICPP 1990, for tasks that can be divided). The
best allocation found is used. The longest case starts first.
"""

from __future__ import annotations

import heapq
from collections import deque
from collections.abc import Iterable, Sequence

from millscale.cases.cost import BUILT_IN, Rates, most_ranks, wall_time
from millscale.engine.machine import Allocation, CoreWish, allowed, available_cores
from millscale.runs.case_file import Case

# On a cluster, the least speed-up that a further rank must give, in cores.
LEAST_EFFICIENCY = 0.6
OPEN = CoreWish()


def place(
    cases: Sequence[Case], asked: CoreWish, usual: CoreWish = OPEN, rates: Rates = BUILT_IN
) -> Allocation:
    """Share the cores of this machine.

    Args:
        cases: cases to run.
        asked: options of the command, which are met exactly.
        usual: values of the campaign, used without an option as far as the machine allows.

    Raises:
        CampaignError: more cores are asked for than there are, without `oversubscribe`.
    """
    cores = available_cores()
    charges = any(case.kind == "multi-ball" for case in cases)
    wanted = allowed(asked, cores, charges)
    jobs = asked.jobs or (min(usual.jobs, cores) if usual.jobs else None)
    share = max(1, cores // (jobs or 1))
    given = asked.ranks or (min(usual.ranks, share) if usual.ranks else None)
    if given or jobs:
        ranks = {x.id: _within(x, given, share, rates) for x in cases}
    else:
        ranks = _balanced(cases, cores, rates)
    notes = _lowered(asked, usual, cores, jobs, share) if charges else ()
    return Allocation(ranks, jobs or cores, max(cores, wanted), notes)


def _lowered(
    asked: CoreWish, usual: CoreWish, cores: int, jobs: int | None, share: int
) -> tuple[str, ...]:
    """Return a note for each number of the campaign that is too large for this machine."""
    notes = []
    offered = f"this machine offers {cores} core{'s' if cores > 1 else ''}"
    if usual.jobs and not asked.jobs and usual.jobs > cores:
        notes.append(f"run.jobs = {usual.jobs} lowered to {cores}: {offered}")
    if usual.ranks and not asked.ranks and usual.ranks > share:
        beside = f" for {jobs} cases at a time" if jobs and jobs > 1 else ""
        notes.append(f"run.ranks = {usual.ranks} lowered to {share}: {offered}{beside}")
    return tuple(notes)


def ranks_on_nodes(cases: Sequence[Case], given: int | None, cores: int) -> dict[str, int]:
    """Return the ranks of cases that do not wait for one another, by id.

    Args:
        given: ranks of every multi-ball case; None for as many as are worth their cores.
        cores: of the nodes that a case may use.
    """
    return {x.id: 1 if x.kind == "single-ball" else given or _worth(x, cores) for x in cases}


def makespan(loads: Iterable[tuple[float, int]], cores: int, jobs: int) -> float:
    """Return the time until the last load is done [s]; the longest that fits starts first.

    Args:
        loads: wall time [s] and cores of each.
        jobs: loads at a time.
    """
    queues: dict[int, deque[float]] = {}
    for time, width in sorted(loads, reverse=True):
        queues.setdefault(min(width, cores), deque()).append(time)
    running: list[tuple[float, int]] = []
    now, free = 0.0, cores
    while queues or running:
        fitting = [width for width in queues if width <= free and len(running) < jobs]
        if fitting:
            width = max(fitting, key=lambda x: queues[x][0])
            heapq.heappush(running, (now + queues[width].popleft(), width))
            free -= width
            if not queues[width]:
                del queues[width]
        else:
            now, width = heapq.heappop(running)
            free += width
    return now


def campaign_time(cases: Sequence[Case], allocation: Allocation, rates: Rates = BUILT_IN) -> float:
    """Return the predicted wall time of all cases on the cores they share [s]."""
    loads = ((wall_time(x, allocation.ranks[x.id], rates), allocation.ranks[x.id]) for x in cases)
    return makespan(loads, allocation.cores, allocation.jobs)


def _within(case: Case, given: int | None, share: int, rates: Rates) -> int:
    """Return the given ranks, or the fastest number that fits beside the other jobs."""
    if case.kind == "single-ball":
        return 1
    return given or min(_choices(case, share), key=lambda ranks: wall_time(case, ranks, rates))


def _worth(case: Case, cores: int) -> int:
    alone = wall_time(case, 1)
    choices = _choices(case, cores)
    return max(x for x in choices if x == 1 or alone / wall_time(case, x) > LEAST_EFFICIENCY * x)


def _choices(case: Case, cores: int) -> range:
    return range(1, min(cores, most_ranks(case)) + 1)


def _balanced(cases: Sequence[Case], cores: int, rates: Rates) -> dict[str, int]:
    """Return ranks by the rule in the module's docstring."""
    ranks = {case.id: 1 for case in cases}
    times = {case.id: wall_time(case, 1, rates) for case in cases}
    by_id = {case.id: case for case in cases}
    work = sum(times.values())
    best = dict(ranks)
    shortest = makespan(((times[x], 1) for x in ranks), cores, cores)
    while times:
        longest = max(times, key=times.__getitem__)
        more = ranks[longest] + 1
        if times[longest] <= work / cores or more not in _choices(by_id[longest], cores):
            break
        work -= times[longest] * ranks[longest]
        ranks[longest], times[longest] = more, wall_time(by_id[longest], more, rates)
        work += times[longest] * more
        whole = makespan(((times[x], ranks[x]) for x in ranks), cores, cores)
        if whole < shortest:
            best, shortest = dict(ranks), whole
    return best
