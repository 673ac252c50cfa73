"""Begin of an engine stage: the newest whole restart file of earlier attempts, or the first step.

An interrupted attempt leaves its part folder with restart files, series, dumps, and attempts.json,
which records the inputs they were made from.
"""

from __future__ import annotations

import shutil
import time
from dataclasses import dataclass
from pathlib import Path

from millscale.engine.attempts import (
    ATTEMPTS_FILE,
    Attempt,
    Attempts,
    Cost,
    read_attempts,
    write_attempts,
)
from millscale.engine.output_files import SERIES, check_output, series_length
from millscale.engine.restart_file import NotWholeError, RestartFile, read_restart
from millscale.runs.writing import write_copy
from millscale.terminal import one_line

RESUME_FILE = "resume.restart"
RESTART_FILES = ("mill.1.restart", "mill.2.restart", RESUME_FILE)
# Files that only attempts need.
OF_ATTEMPTS = {ATTEMPTS_FILE, RESUME_FILE}


@dataclass(frozen=True)
class Run:
    """The engine run of a stage.

    Attributes:
        inputs: SHA-256 of each input, by file.
        first: step of the engine at which it begins.
        steps: number of steps from there to its end.
        of_case: number of steps of all engine runs of the case.
    """

    part: Path
    inputs: dict[str, str]
    first: int
    steps: int
    of_case: int
    ranks: int


@dataclass(frozen=True)
class Beginning:
    """The begin of an engine run.

    Attributes:
        restart: file to continue from, RESUME_FILE; None to start at the first step.
        note: what happens, for people; empty at the first attempt.
        attempts: starts of the engine, including this one.
    """

    restart: RestartFile | None
    note: str
    attempts: Attempts

    @property
    def before(self) -> Cost:
        """Cost of the steps before this start."""
        return self.attempts.starts[-1].before


def look(run: Run) -> tuple[RestartFile | None, str]:
    """Return the restart file to continue from, and a note for people; changes no file."""
    earlier = read_attempts(run.part)
    if earlier is None:
        return None, ""
    changed = sorted(
        name
        for name in {*earlier.inputs, *run.inputs}
        if earlier.inputs.get(name) != run.inputs.get(name)
    )
    if changed:
        names = one_line(", ".join(changed))
        return None, f"starts over: {names} changed since the last attempt"
    restart, problems = _newest_whole(run)
    if restart and not any(start.step < restart.step for start in earlier.starts):
        problems.append(f"{ATTEMPTS_FILE} has no attempt that wrote {restart.path.name}")
        restart = None
    if restart:
        action = f"goes on from step {restart.step:,} of {run.of_case:,} ({restart.path.name})"
    else:
        action = "begins anew: no restart file to go on from"
    return restart, "; ".join([action, *problems])


class OtherRanksError(RuntimeError):
    """A run would continue on another number of ranks than it began with."""


def begin(run: Run) -> Beginning:
    """Record a start of the engine, and prepare the part folder for it.

    Raises:
        OtherRanksError: the attempt to continue had another number of ranks.
    """
    restart, note = look(run)
    earlier = read_attempts(run.part) if restart else None
    if restart and earlier:
        ranks = earlier.starts[-1].ranks
        if ranks != run.ranks:
            raise OtherRanksError(
                f"the attempt to continue ran on {ranks} ranks, not on {run.ranks}: set --ranks "
                f"{ranks}, or start again with millscale run --start-over"
            )
        before, starts = earlier.cost_until(restart), earlier.starts
        # Before any step that can fail, so that the next attempt finds the same files.
        attempts = _record(run, restart.step, before, starts)
        restart = _put_aside(restart)
        _cut(run, restart.step)
        # The engine writes these when a signal ends it, at a step from which the run would not be
        # bit-identical.
        for path in run.part.glob("restart_forced_liggghts_*"):
            path.unlink()
    else:
        # First: a record of new inputs beside files of old ones would be wrong.
        shutil.rmtree(run.part, ignore_errors=True)
        run.part.mkdir()
        attempts = _record(run, run.first, Cost(), ())
    return Beginning(restart, note, attempts)


def _record(run: Run, step: int, before: Cost, starts: tuple[Attempt, ...]) -> Attempts:
    attempts = Attempts(run.inputs, (*starts, Attempt(step, time.time(), run.ranks, before)))
    write_attempts(run.part, attempts)
    return attempts


def _newest_whole(run: Run) -> tuple[RestartFile | None, list[str]]:
    """Return the newest restart file that is whole and has whole output; why others are not."""
    found, problems = [], []
    for name in RESTART_FILES:
        try:
            found.append(read_restart(run.part / name))
        except FileNotFoundError:
            continue
        except (NotWholeError, OSError) as error:
            problems.append(str(error))
    for restart in sorted(found, key=lambda file: file.step, reverse=True):
        try:
            check_output(run.part, run.first, restart.step)
            return restart, problems
        except (NotWholeError, OSError) as error:
            problems.append(f"{restart.path.name} cannot be used: {error}")
    return None, problems


def _put_aside(restart: RestartFile) -> RestartFile:
    """Rename a restart file, so that new ones do not replace the only whole one."""
    aside = restart.path.with_name(RESUME_FILE)
    restart.path.replace(aside)
    return RestartFile(
        aside, restart.step, restart.written, restart.loop_time, restart.processor_time
    )


def _cut(run: Run, step: int) -> None:
    """Delete the rows after a step; the engine appends new ones."""
    for series in (run.part / name for name in SERIES):
        if not series.exists():
            continue
        length = series_length(series, run.first, step)
        if length < series.stat().st_size:
            write_copy(series, series, length)
