"""Progress of an engine stage, read from the files it writes while it runs."""

from __future__ import annotations

import math
import os
import re
import time
from dataclasses import dataclass
from pathlib import Path

from millscale.engine.attempts import read_attempts
from millscale.runs.case_file import Case
from millscale.runs.layout import Stage
from millscale.runs.untrusted import open_regular, read_head, read_tail

_THERMO = re.compile(r"^\s+(\d{1,19})\s+\d+\s", re.M)
_TAIL_BYTES = 8192
_HEAD_BYTES = 65536
# The engine writes this line before its first step.
_SET_UP = re.compile(r"^Setting up run at (.+)$", re.M)


@dataclass(frozen=True)
class Progress:
    """Steps done at a time [s since 1970]; the engine writes its files with a delay.

    Attributes:
        begun: steps of earlier attempts that the running one did not repeat.
        since: time of the first step of the running attempt, to the second; 0 if unknown.
    """

    step: int
    at: float
    begun: int = 0
    since: float = 0.0


def stage_steps(case: Case, stage: Stage) -> int:
    """Return the steps of the engine in a stage; 0 for a stage without engine."""
    if not stage.deck:
        return 0
    return case.time.settle_steps if stage.name == "settle" else case.time.steps


def stage_progress(folder: Path, case: Case, stage: Stage, by_hand: bool = False) -> Progress:
    """Return the progress of an engine stage that runs or was interrupted.

    Args:
        folder: case folder; the stage works in its part folder, or by hand in the case folder.
    """
    part = folder if by_hand else folder / f"{stage.name}.part"
    attempts = read_attempts(part)
    begun = attempts.starts[-1].step - attempts.starts[0].step if attempts else 0
    if stage.name == "settle":
        file = part / f"log.{stage.name}"
        step = _last_thermo_step(file)
    else:
        file = part / "series.csv"
        step = int(last_value(file, "step")) - _steps_before(case, part)
    step = min(max(step, 0), stage_steps(case, stage))
    since = _stepping_since(part / f"log.{stage.name}")
    try:
        return Progress(step, file.stat().st_mtime, begun, since) if step else Progress(0, 0.0)
    except OSError:
        # The stage has ended or started again since its file was read.
        return Progress(0, 0.0)


def last_value(path: Path, column: str) -> float:
    """Return the last value of a column of a growing series; 0 before the first full line."""
    try:
        with open_regular(path) as file:
            names = file.readline(_TAIL_BYTES).decode(errors="replace").strip().split(",")
            header_end = file.tell()
            file.seek(max(header_end, os.fstat(file.fileno()).st_size - _TAIL_BYTES))
            lines = file.read(_TAIL_BYTES).decode(errors="replace").split("\n")[:-1]
    except OSError:
        return 0.0
    rows = [row for row in (line.split(",") for line in lines) if len(row) == len(names)]
    if not rows or column not in names:
        return 0.0
    try:
        value = float(rows[-1][names.index(column)])
    except ValueError:
        return 0.0
    return value if math.isfinite(value) else 0.0


def _last_thermo_step(log: Path) -> int:
    steps = _THERMO.findall(read_tail(log, _TAIL_BYTES))
    return int(steps[-1]) if steps else 0


def _stepping_since(log: Path) -> float:
    """Return the time at which the run of a log began [s since 1970]; 0 if it has not."""
    try:
        found = _SET_UP.search(read_head(log, _HEAD_BYTES))
        return time.mktime(time.strptime(found[1].strip())) if found else 0.0
    except (ValueError, OverflowError):
        return 0.0


def _steps_before(case: Case, part: Path) -> int:
    """Return the step at which the rotation began: a run from a restart file continues to count."""
    settled = case.time.settle_steps
    try:
        first = int(read_head(part / "series.csv", _TAIL_BYTES).split("\n")[1].split(",")[0])
    except (IndexError, ValueError):
        return 0
    return settled if first >= settled else 0
