"""Where every case of a runs folder stands, from its files alone."""

from __future__ import annotations

import json
import time
from dataclasses import dataclass
from pathlib import Path

from mill_campaign.case import Case
from mill_campaign.errors import CampaignError
from mill_campaign.progress import Progress, stage_progress, stage_steps
from mill_campaign.stage_record import StageRecord, read_record
from mill_campaign.stage_table import (
    CAMPAIGN_FILE,
    CASE_FILE,
    CASES_FOLDER,
    STAGES,
    Stage,
    unfinished,
)


@dataclass(frozen=True)
class CaseStatus:
    """Where a case stands.

    Attributes:
        state: waiting, running, failed, interrupted or done.
        stage: the stage that runs, failed or comes next; empty when done.
        stages_left: stages that still have to run, the one named by `stage` included.
        step, steps: engine steps of the whole case done, and in all.
        simulated_s: simulated time of the steps done [s].
        particle_steps_per_s: mean since the running stage began; None if no engine runs.
        time_left_s: for the engine steps to come at that rate; None if no engine runs.
        problem: cause of the last failure, one line, empty if there is none.
        log: the file that tells more, relative to the case folder.
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
    problem: str
    log: str


def campaign_cases(runs: Path) -> list[Path]:
    """The case folders of a runs folder, in the order of the campaign.

    Raises:
        CampaignError: the folder holds no generated campaign.
    """
    accepted = "a folder made by `millscale generate` or `run`"
    try:
        ids = json.loads((runs / CAMPAIGN_FILE).read_text())["cases"]
    except OSError:
        raise CampaignError(runs, "", f"no {CAMPAIGN_FILE} in it", accepted) from None
    except (ValueError, TypeError, KeyError):
        raise CampaignError(runs / CAMPAIGN_FILE, "", "not understood", accepted) from None
    return [runs / CASES_FOLDER / case_id for case_id in ids]


def campaign_status(runs: Path) -> list[CaseStatus]:
    """Status of every case of a runs folder."""
    return [case_status(folder, Case.load(folder / CASE_FILE)) for folder in campaign_cases(runs)]


def case_status(folder: Path, case: Case) -> CaseStatus:
    """Status of one case.

    Args:
        folder: case folder.
    """
    kind, balls = case.kind, case["ball"]["count"]
    left = [stage for stage, _ in unfinished(folder, kind)]
    record = _record_of_next(folder, left)
    state = _state(left, record)
    now = Progress(0, 0.0)
    if left and left[0].deck and state in ("running", "failed", "interrupted"):
        now = stage_progress(folder, case, left[0])
    steps_of = {stage.name: stage_steps(case, stage) for stage in STAGES[kind]}
    steps = sum(steps_of.values())
    step = steps - sum(steps_of[stage.name] for stage in left) + now.step
    rate = None
    if state == "running" and record and now.at > record.started:
        rate = balls * (now.step - now.begun) / (now.at - record.started)
    failed = record if state == "failed" else None
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
        simulated_s=step * case["time"]["step_s"],
        particle_steps_per_s=rate,
        time_left_s=_time_left((steps - step) * balls, rate, now),
        problem=failed.cause if failed else "",
        log=failed.log if failed else "",
    )


def _time_left(particle_steps: int, rate: float | None, now: Progress) -> float | None:
    """Time to go at a rate, counted from now [s]."""
    return max(0.0, particle_steps / rate - (time.time() - now.at)) if rate else None


def _record_of_next(folder: Path, left: list[Stage]) -> StageRecord | None:
    """The record of the stage that comes next, unless the case has changed since."""
    record = read_record(folder)
    if not left or not record or record.stage != left[0].name:
        return None
    changed = (folder / CASE_FILE).stat().st_mtime > max(record.started, record.ended)
    return None if changed else record


def _state(left: list[Stage], record: StageRecord | None) -> str:
    if not left:
        return "done"
    if record is None:
        return "waiting"
    if record.state == "running" and not record.alive():
        return "interrupted"
    # Done, and yet its products are not there: they were removed since.
    return "waiting" if record.state == "done" else record.state
