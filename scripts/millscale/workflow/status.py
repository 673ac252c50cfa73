"""Status of every case of a runs folder, from its files only."""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from millscale.cases.generate import read_summary
from millscale.runs.case_file import Case, is_outdated, load_case
from millscale.runs.current import unfinished
from millscale.runs.layout import CASE_FILE, CASES_FOLDER, DUMP_FOLDER, STAGES, Stage
from millscale.runs.untrusted import RunFolderError
from millscale.workflow.by_hand import Found, find, is_recorded
from millscale.workflow.failures import (
    BY_HAND,
    DAMAGED,
    KILLED,
    KINDS,
    NO_PROGRESS,
    SILENCE,
    UNKNOWN,
    Failure,
    advice_of,
)
from millscale.workflow.jobs import STAGES_S
from millscale.workflow.progress import Progress, stage_progress, stage_steps
from millscale.workflow.stage_record import StageRecord, read_record

# Of cases that are not all done.
LARGEST_SHARE = 0.99
# Lines of its log by which an engine may be late before it counts as silent.
_FEW_ROWS = 5.0


@dataclass(frozen=True)
class CaseStatus:
    """Status of a case.

    Attributes:
        state: waiting, running, failed, interrupted, done, or damaged if case.json is not usable.
        stage: the stage that runs, has failed or comes next; empty when done.
        stages_left: number of stages that still have to run, `stage` included.
        step, steps: engine steps done, and of the whole case.
        simulated_s: simulated time of the steps done [s].
        particle_steps_per_s: mean since the running stage began to step; None if no engine runs.
        time_left_s: time of the remaining engine steps at that rate; None if no engine runs.
        silent_s: time since a running engine has written a file; None if no engine runs.
        predicted_wall_time_s: of all engine steps, on one core.
        failure: kind of the last problem, as in `failures`; empty if there is none.
        problem: its cause, one line.
        advice: what to do, one line.
        log: file that explains the problem, relative to the case folder.
        by_hand: stages that were run by hand, including those that the next run takes over.
    """

    id: str
    kind: str
    state: str
    stage: str
    stages_left: int
    balls: int
    step: int
    steps: int
    percent: float
    simulated_s: float
    particle_steps_per_s: float | None
    time_left_s: float | None
    silent_s: float | None
    predicted_wall_time_s: float
    failure: str
    problem: str
    advice: str
    log: str
    by_hand: tuple[str, ...] = ()

    @property
    def is_starting(self) -> bool:
        """Whether an engine runs that has not reported a step yet."""
        return self.silent_s is not None and self.particle_steps_per_s is None


def share_done(statuses: Sequence[CaseStatus]) -> float:
    """Return the share of the predicted time of all cases that is done; 1 only if all are."""
    times = [(x, x.predicted_wall_time_s + STAGES_S) for x in statuses]
    done = sum(time if x.state == "done" else time * x.step / max(x.steps, 1) for x, time in times)
    whole = sum(time for _, time in times)
    is_all = all(x.state == "done" for x in statuses)
    return 1.0 if is_all else min(done / whole, LARGEST_SHARE)


def campaign_cases(runs: Path) -> list[Path]:
    """Return the case folders of a runs folder, in the order of the campaign.

    Raises:
        CampaignError: the folder holds no generated campaign.
    """
    return [runs / CASES_FOLDER / case_id for case_id in read_summary(runs)["cases"]]


def campaign_status(runs: Path, silence: float = SILENCE) -> list[CaseStatus]:
    """Return the status of every case of a runs folder; `silence` as in `case_status`."""
    summary = read_summary(runs)
    statuses = []
    for case_id in summary["cases"]:
        folder = runs / CASES_FOLDER / case_id
        try:
            case = load_case(folder)
        except RunFolderError as error:
            statuses.append(_damaged(case_id, error.cause))
            continue
        statuses.append(case_status(folder, case, silence, is_outdated(summary, case)))
    return statuses


def _damaged(case_id: str, cause: str) -> CaseStatus:
    """Return the status of a case whose case.json cannot be used."""
    return CaseStatus(
        id=case_id,
        kind="",
        state="damaged",
        stage="",
        stages_left=0,
        balls=0,
        step=0,
        steps=0,
        percent=0.0,
        simulated_s=0.0,
        particle_steps_per_s=None,
        time_left_s=None,
        silent_s=None,
        predicted_wall_time_s=0.0,
        failure=DAMAGED,
        problem=f"{DAMAGED}: {CASE_FILE}: {cause}",
        advice=advice_of(DAMAGED),
        log=CASE_FILE,
    )


def case_status(
    folder: Path, case: Case, silence: float = SILENCE, outdated: bool = False
) -> CaseStatus:
    """Return the status of one case.

    Args:
        folder: case folder.
        silence: an engine that writes nothing for this time makes no progress [s].
        outdated: whether the next run will write another case.json.
    """
    kind, balls = case.kind, case.ball.count
    left = [stage for stage, _ in unfinished(folder, kind, case_changed=outdated)]
    found = Found() if outdated else find(folder, case, left)
    made = [x.name for x in STAGES[kind] if is_recorded(folder, x) or x in found.stages]
    left = left[len(found.stages) :]
    by_hand = bool(left) and left[0].deck != "" and (found.running or found.problem != "")
    record = None if outdated or by_hand else _record_of_next(folder, left, case)
    state = ("running" if found.running else "failed") if by_hand else _state(left, record)
    now = Progress(0, 0.0)
    if left and left[0].deck and state in ("running", "failed", "interrupted"):
        now = stage_progress(folder, case, left[0], by_hand)
    steps_of = {stage.name: stage_steps(case, stage) for stage in STAGES[kind]}
    steps = sum(steps_of.values())
    step = steps - sum(steps_of[stage.name] for stage in left) + now.step
    rate = None
    began = max(record.started if record else 0.0, now.since)
    if state == "running" and now.at > began > 0.0:
        rate = balls * (now.step - now.begun) / (now.at - began)
    silent = _silent(folder, record) if state == "running" and left[0].deck and record else None
    problem = _problem(state, record, silent, max(silence, _FEW_ROWS * _row_time(case, rate)))
    if by_hand and found.problem:
        problem = Failure(BY_HAND, f"{BY_HAND}: {found.problem}", advice_of(BY_HAND, found.problem))
    return CaseStatus(
        id=case.id,
        kind=kind,
        state=state,
        stage=left[0].name if left else "",
        stages_left=len(left),
        balls=balls,
        step=step,
        steps=steps,
        percent=min(99.0, 100.0 * step / steps) if left else 100.0,
        simulated_s=step * case.time.step_s,
        particle_steps_per_s=rate,
        time_left_s=_time_left((steps - step) * balls, rate, now),
        silent_s=silent,
        predicted_wall_time_s=case.predicted.wall_time_s,
        failure=problem.kind if problem else "",
        problem=problem.cause if problem else "",
        advice=problem.advice if problem else "",
        log=_log(left, record, by_hand) if problem else "",
        by_hand=tuple(made),
    )


def _log(left: list[Stage], record: StageRecord | None, by_hand: bool) -> str:
    """Return the name of the file that explains a problem."""
    if by_hand:
        return f"log.{left[0].name}"
    return (record.log or f"out.{record.stage}") if record else ""


def _problem(
    state: str, record: StageRecord | None, silent: float | None, silence: float
) -> Failure | None:
    """Return what is wrong with the stage of a record; None if nothing is."""
    if record is None:
        return None
    if state == "failed":
        kind = record.kind if record.kind in KINDS else UNKNOWN
        return Failure(kind, record.cause, record.advice or advice_of(kind, record.cause))
    if state == "interrupted" and record.state == "running":
        cause = f"{KILLED}: the process ended without an error message, or the machine stopped"
        return Failure(KILLED, cause, advice_of(KILLED))
    if silent is not None and silent > silence:
        cause = f"{NO_PROGRESS}: nothing written for {silent:.0f} s"
        return Failure(NO_PROGRESS, cause, advice_of(NO_PROGRESS))
    return None


def _silent(folder: Path, record: StageRecord | None) -> float:
    """Return the time since the running stage has last written a file [s]."""
    part = folder / f"{record.stage}.part" if record else folder
    times = [record.started if record else 0.0]
    for place in (part, part / DUMP_FOLDER):
        with suppress(OSError), os.scandir(place) as entries:
            times += [x.stat(follow_symlinks=False).st_mtime for x in entries]
    return max(0.0, time.time() - max(times))


def _row_time(case: Case, rate: float | None) -> float:
    """Return the wall time between two lines of the engine's log [s]."""
    return case.output.thermo_steps * case.ball.count / rate if rate else 0.0


def _time_left(particle_steps: int, rate: float | None, now: Progress) -> float | None:
    """Return the remaining time at a rate, from now [s]."""
    return max(0.0, particle_steps / rate - (time.time() - now.at)) if rate else None


def _record_of_next(folder: Path, left: list[Stage], case: Case) -> StageRecord | None:
    """Return the record of the stage that comes next; None if the case has changed since."""
    record = read_record(folder)
    if not left or not record or record.stage != left[0].name:
        return None
    changed = record.case and record.case != case.digest
    return None if changed else record


def _state(left: list[Stage], record: StageRecord | None) -> str:
    if not left:
        return "done"
    if record is None:
        return "waiting"
    if record.state == "running" and not record.alive():
        return "interrupted"
    # A stage that is done and is still left has lost its products since.
    return "waiting" if record.state == "done" else record.state
