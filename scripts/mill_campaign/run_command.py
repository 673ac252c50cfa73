"""`millscale run`: which cases and stages, on which cores, and what came of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path

from rich.console import Console

from mill_campaign.case import Case, cases_of
from mill_campaign.config_build import load_campaign
from mill_campaign.cost import most_ranks
from mill_campaign.display import status_table, watching
from mill_campaign.engine_run import ENGINE, find_engine, mpirun_line, mpirun_text
from mill_campaign.errors import CampaignError, nearest
from mill_campaign.folder_lock import hold
from mill_campaign.generate import changed_cases, generate
from mill_campaign.machine import Allocation, CoreWish, allocate
from mill_campaign.stage_table import CASES_FOLDER, Stage, unfinished
from mill_campaign.stage_work import attempt_note
from mill_campaign.status import CaseStatus, case_status
from mill_campaign.workflow import WORKFLOW_LOG, last_problem, run_workflow


@dataclass(frozen=True)
class Request:
    """What to run where: a checked campaign file, the cases chosen of it, and the cores."""

    file: Path
    cases: tuple[Case, ...]
    runs: Path
    allocation: Allocation


def request(file: Path, runs: Path, only: list[str], cores: CoreWish) -> Request:
    """Check everything that can be wrong before anything is written.

    Args:
        only: ids or patterns with `*`; empty for every case.

    Raises:
        CampaignError: wrong campaign, unknown id, more cores than there are.
    """
    campaign = load_campaign(file)
    cases = _chosen(cases_of(campaign), only)
    usual = CoreWish(campaign.ranks or most_ranks(cases), campaign.jobs)
    allocation = allocate({case.kind for case in cases}, cores, usual)
    return Request(file, tuple(cases), runs, allocation)


def _chosen(cases: list[Case], only: list[str]) -> list[Case]:
    for pattern in only:
        if not any(fnmatchcase(case.id, pattern) for case in cases):
            ids = [case.id for case in cases]
            near = nearest(pattern, ids) or ids[0]
            raise CampaignError(
                "millscale run", "--only", f"no case {pattern}", f"{near}, ...; see millscale plan"
            )
    return [x for x in cases if not only or any(fnmatchcase(x.id, pattern) for pattern in only)]


def dry_run_campaign(asked: Request) -> str:
    """The stages that would run and the exact mpirun lines, as text; writes nothing."""
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
        for stage, reason in left:
            lines.append(f"  {stage.name:<7} ({reason})")
            if stage.deck:
                lines.append(f"    in {folder}: {_command(engine, stage, case, asked.allocation)}")
    use = asked.allocation
    lines.append(
        f"{waiting} of {len(asked.cases)} cases to do, at most {use.jobs} at a time "
        f"on {use.cores} cores; nothing written"
    )
    return "\n".join(lines)


def _command(engine: str, stage: Stage, case: Case, allocation: Allocation) -> str:
    ranks = allocation.ranks if case.kind == "multi-ball" else 1
    return mpirun_text(mpirun_line(engine, stage.deck, f"log.{stage.name}", ranks))


def run_campaign(asked: Request, console: Console) -> bool:
    """Generate the campaign and run what is missing; True if every chosen case has its result."""
    find_engine()
    with hold(asked.runs) as lock:
        generate(asked.file, asked.runs)
        for case in asked.cases:
            if note := attempt_note(asked.runs / CASES_FOLDER / case.id, case.document):
                console.print(f"{case.id}: {note}", markup=False, highlight=False, soft_wrap=True)
        with watching(console, asked.runs, asked.cases, asked.allocation) as watch:
            code = run_workflow(asked.runs, asked.cases, asked.allocation, lock, watch)
    statuses = [case_status(asked.runs / CASES_FOLDER / x.id, x) for x in asked.cases]
    console.print(status_table(statuses))
    for line in problems(asked.runs, statuses):
        console.print(line, markup=False, highlight=False, soft_wrap=True)
    done = all(status.state == "done" for status in statuses)
    if done:
        console.print(f"next: millscale report {asked.runs}", markup=False, highlight=False)
    elif code and not any(status.problem for status in statuses):
        log = asked.runs / WORKFLOW_LOG
        console.print(f"workflow failed: {last_problem(asked.runs)}; see {log}", markup=False)
    return done


def problems(runs: Path, statuses: Sequence[CaseStatus]) -> list[str]:
    """A line per failed case: stage, cause, and the log that tells more."""
    return [
        f"{x.id}: {x.stage} failed: {x.problem}; see {runs / CASES_FOLDER / x.id / x.log}"
        for x in statuses
        if x.problem
    ]
