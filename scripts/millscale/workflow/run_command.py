"""`millscale run`: choose cases, stages and cores, run them, report the outcome."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path

from rich.console import Console

from millscale.campaign.build import load_campaign
from millscale.cases.case import cases_of
from millscale.cases.cost import Rates, learned
from millscale.cases.generate import as_written, changed_cases, check_owner, generate
from millscale.cases.output_size import check_disk
from millscale.engine.deck_run import ENGINE, find_engine, mpirun_line, mpirun_text
from millscale.engine.machine import Allocation, CoreWish, hardware, ranks_per_node
from millscale.errors import CampaignError, nearest
from millscale.formats import counted, duration
from millscale.runs import digests
from millscale.runs.case_file import Case
from millscale.runs.current import unfinished
from millscale.runs.layout import CASES_FOLDER, Stage
from millscale.runs.lock import hold
from millscale.workflow import by_hand, failures
from millscale.workflow.display import Watching, problems, status_table, watching
from millscale.workflow.jobs import jobs_of, write_jobs
from millscale.workflow.kept_ranks import drop_attempts, keep_ranks
from millscale.workflow.placement import campaign_time
from millscale.workflow.predictions import error_line, record_predictions
from millscale.workflow.snakemake_run import (
    ENDING_S,
    WORKFLOW_LOG,
    last_problem,
    run_workflow,
    snakemake_line,
)
from millscale.workflow.stage_work import attempt_of
from millscale.workflow.status import CaseStatus, case_status
from millscale.workflow.targets import Local, Target


@dataclass(frozen=True)
class Request:
    """What to run and where: a checked campaign file, some of its cases, ranks, target."""

    file: Path
    cases: tuple[Case, ...]
    runs: Path
    allocation: Allocation
    rates: Rates
    target: Target
    start_over: bool = False


def request(
    file: Path,
    runs: Path,
    only: list[str],
    cores: CoreWish,
    target: Target | None = None,
    start_over: bool = False,
) -> Request:
    """Check the campaign and all options before any file is written.

    Args:
        only: ids or patterns with `*`; empty for every case.
        target: where the jobs run; None for this machine.
        start_over: delete what interrupted attempts of the cases have left.

    Raises:
        CampaignError: wrong campaign, unknown id, a folder of another campaign, too many cores,
            or other ranks than those of an attempt to resume.
    """
    campaign = load_campaign(file)
    every = as_written(cases_of(campaign), runs)
    cases = _chosen(every, only)
    check_owner(campaign, every, runs)
    rates = learned((runs / CASES_FOLDER).glob("*"), str(hardware()["cpu"]))
    usual = CoreWish(campaign.ranks, campaign.jobs)
    place = target or Local()
    allocation = place.allocate(cases, cores, usual, rates)
    if not start_over:
        allocation = keep_ranks(allocation, cases, changed_cases(cases, runs), runs, cores)
    return Request(file, tuple(cases), runs, allocation, rates, place, start_over)


def _chosen(cases: list[Case], only: list[str]) -> list[Case]:
    for pattern in only:
        if not any(fnmatchcase(case.id, pattern) for case in cases):
            ids = [case.id for case in cases]
            near = nearest(pattern, ids) or ids[0]
            raise CampaignError(
                "millscale run", "--only", f"no case {pattern}", f"{near}, ...; see millscale plan"
            )
    return [x for x in cases if not only or any(fnmatchcase(x.id, pattern) for pattern in only)]


def check_free_disk(asked: Request) -> None:
    """Refuse cases whose output would not fit on the disk; those that are rotated count nothing.

    Raises:
        CampaignError: states what is needed and what is free.
    """
    changed = changed_cases(list(asked.cases), asked.runs)
    done = []
    for case in asked.cases:
        folder = asked.runs / CASES_FOLDER / case.id
        left = unfinished(folder, case.kind, case_changed=case.id in changed)
        done.append(not any(stage.deck for stage, _ in left))
    check_disk(asked.runs, list(asked.cases), done)


def dry_run_campaign(asked: Request) -> str:
    """Return the stages that would run and the exact mpirun commands; writes no file."""
    try:
        engine = str(find_engine())
    except CampaignError:
        engine = ENGINE
    changed = changed_cases(list(asked.cases), asked.runs)
    lines, waiting = [], 0
    for case in asked.cases:
        folder = asked.runs / CASES_FOLDER / case.id
        left = unfinished(folder, case.kind, case_changed=case.id in changed)
        waiting += bool(left)
        lines.append(case.id if left else f"{case.id}: done")
        found = by_hand.find(folder, case, [stage for stage, _ in left])
        for stage, reason in left:
            if stage in found.stages:
                reason = "run by hand: taken over"
            elif found.problem and stage.products[0] in found.problem:
                reason = found.problem
            lines.append(f"  {stage.name:<7} ({reason})")
            if stage.deck and stage not in found.stages:
                lines.append(f"    in {folder}: {_command(engine, stage, case, asked.allocation)}")
    use = asked.allocation
    lines.append(
        f"{waiting} of {counted(len(asked.cases), 'case')} to do, at most {use.jobs} at a time "
        f"on {counted(use.cores, 'core')}; no file written"
    )
    return "\n".join(lines)


def _command(engine: str, stage: Stage, case: Case, allocation: Allocation) -> str:
    ranks, nodes = allocation.ranks[case.id], allocation.nodes_of(case.id)
    per_node = ranks_per_node(ranks, nodes) if nodes > 1 else None
    return mpirun_text(mpirun_line(engine, stage.deck, f"log.{stage.name}", ranks, per_node))


def run_campaign(asked: Request, console: Console, show: Watching = watching) -> bool:
    """Generate the campaign and run what is missing; return whether all cases have results.

    Args:
        show: shows the progress while the cases run.
    """
    find_engine()
    kills = failures.memory_kills()
    with hold(asked.runs) as lock:
        generate(asked.file, asked.runs, [case.id for case in asked.cases])
        for note in asked.allocation.notes:
            console.print(note, markup=False, highlight=False, soft_wrap=True)
        for case in asked.cases:
            folder = asked.runs / CASES_FOLDER / case.id
            if asked.start_over:
                drop_attempts(folder, case.kind)
            attempt = attempt_of(folder, case)
            note = (attempt and attempt.note) or by_hand.note(folder, case)
            if note:
                note = f"{case.id}: {note}"
                console.print(note, markup=False, highlight=False, soft_wrap=True)
        code = _run_jobs(asked, console, lock, show)
    statuses = [case_status(asked.runs / CASES_FOLDER / x.id, x) for x in asked.cases]
    for case in asked.cases:
        digests.keep(asked.runs / CASES_FOLDER / case.id)
    console.print(status_table(statuses, console))
    for line in problems(asked.runs, statuses):
        console.print(line, markup=False, highlight=False, soft_wrap=True)
    if line := error_line(asked.runs):
        console.print(line, markup=False, highlight=False, soft_wrap=True)
    done = all(status.state == "done" for status in statuses)
    if done:
        line = shlex.join(["millscale", "report", str(asked.runs)])
        console.print(f"next: {line}", markup=False, highlight=False, soft_wrap=True)
    for line in unexplained(asked.runs, statuses, code, failures.memory_kills() - kills):
        console.print(line, markup=False, highlight=False, soft_wrap=True)
    return done


def unexplained(
    runs: Path, statuses: Sequence[CaseStatus], code: int, memory_kills: int = 0
) -> list[str]:
    """Return why cases without a result or a problem of their own were not run, and what to do.

    Args:
        code: exit code of the workflow, or minus the signal that ended it.
        memory_kills: processes that the system killed for lack of memory meanwhile.
    """
    left = [x for x in statuses if x.state != "done" and not x.problem]
    if not left:
        return []
    ended = f"with exit code {code}" if code >= 0 else f"by signal {-code}"
    first, more = left[0], f" and {len(left) - 1} more" if len(left) > 1 else ""
    stage = first.stage or "its stages"
    module, folder = "millscale.workflow.run_stage", str(runs / CASES_FOLDER / first.id)
    line = shlex.join([sys.executable, "-m", module, first.stage, folder])
    cause, advice = f"the workflow ended {ended}: {last_problem(runs)}", "repeat the command"
    if memory_kills > 0:
        cause += f"; {failures.MEMORY}: processes killed by the system meanwhile: {memory_kills}"
        advice = failures.advice_of(failures.MEMORY)
    return [
        f"{first.id}{more}: {stage} not run: {cause}; see {runs / WORKFLOW_LOG}",
        f"  to do: {advice}; if this message comes again: {line}",
    ]


def _beginning(left: Sequence[Case], asked: Request) -> str:
    """Return how many cases run at a time, on which cores, and their predicted time."""
    time, use = campaign_time(left, asked.allocation, asked.rates), asked.allocation
    at_a_time = "one" if use.jobs == 1 else f"at most {use.jobs}"
    return (
        f"{counted(len(left), 'case')} to run, {at_a_time} at a time on "
        f"{counted(use.cores, 'core')}, about {duration(time)} predicted"
    )


def _run_jobs(asked: Request, console: Console, lock: int, show: Watching) -> int:
    """Run the cases that are not done; return Snakemake's exit code, 0 without any case."""
    folders = {x.id: asked.runs / CASES_FOLDER / x.id for x in asked.cases}
    left = [x for x in asked.cases if unfinished(folders[x.id], x.kind)]
    jobs = jobs_of(left, asked.allocation, asked.rates, asked.target.shared_job_s)
    if not jobs:
        return 0
    engines = [x for x in left if not by_hand.is_rotated(folders[x.id], x)]
    record_predictions(asked.runs, engines, asked.allocation, asked.rates)
    console.print(_beginning(left, asked), markup=False, highlight=False, soft_wrap=True)
    for request in asked.target.request_lines(jobs):
        console.print(request, markup=False, highlight=False, soft_wrap=True)
    line = snakemake_line(
        write_jobs(asked.runs, jobs).relative_to(asked.runs),
        asked.target.snakemake_options(asked.allocation),
    )

    def ending() -> None:
        console.print(f"ending the running cases, within {ENDING_S:.0f} s", highlight=False)

    with (
        asked.target.waiting(),
        show(console, asked.runs, asked.cases, asked.allocation) as watch,
    ):
        return run_workflow(asked.runs, line, lock, watch, ending)
