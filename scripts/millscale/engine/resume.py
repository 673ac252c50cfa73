"""Where an engine stage begins: at the newest whole restart file of earlier attempts, or anew.

An attempt that ends early leaves its part folder. The next one finds there restart files, series
and dumps, and attempts.json, which says what they were made of.
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
# What no later stage needs.
OF_ATTEMPTS = {ATTEMPTS_FILE, RESUME_FILE}


@dataclass(frozen=True)
class Run:
    """What an engine stage is to do.

    Attributes:
        inputs: file -> SHA-256 of what decides it.
        first: step of the engine at which it begins.
        steps: from there to its end.
    """

    part: Path
    inputs: dict[str, str]
    first: int
    steps: int
    ranks: int


@dataclass(frozen=True)
class Beginning:
    """Where the engine begins.

    Attributes:
        restart: file to go on from, RESUME_FILE; None to begin anew.
        note: what happened, for people; empty at the first attempt.
        attempts: starts of the engine, this one included.
    """

    restart: RestartFile | None
    note: str
    attempts: Attempts

    @property
    def before(self) -> Cost:
        """Cost of the steps before this beginning."""
        return self.attempts.starts[-1].before


def look(run: Run) -> tuple[RestartFile | None, str]:
    """The restart file an attempt would go on from, and what to tell; changes nothing."""
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
        problems.append(f"{ATTEMPTS_FILE} does not hold who wrote {restart.path.name}")
        restart = None
    if restart:
        told = f"goes on from step {restart.step - run.first} of {run.steps} ({restart.path.name})"
    else:
        told = "begins anew: no restart file to go on from"
    return restart, "; ".join([told, *problems])


class OtherRanksError(RuntimeError):
    """A run would go on with another number of ranks than it began with."""


def begin(run: Run) -> Beginning:
    """Record that the engine begins, and make the part folder ready for it.

    Raises:
        OtherRanksError: the attempt to go on from had another number of ranks.
    """
    restart, note = look(run)
    earlier = read_attempts(run.part) if restart else None
    if restart and earlier:
        ranks = earlier.starts[-1].ranks
        if ranks != run.ranks:
            raise OtherRanksError(
                f"the attempt to go on from ran on {ranks} ranks, not on {run.ranks}: take --ranks "
                f"{ranks}, or millscale run --start-over to begin it anew"
            )
        before, starts = earlier.cost_until(restart), earlier.starts
        # Before anything that can fail: if it does, the next attempt finds the same files.
        attempts = _record(run, restart.step, before, starts)
        restart = _put_aside(restart)
        _cut(run, restart.step)
        # Written by the engine when it is told to end: at a step where the run would not be the
        # same bit by bit.
        for path in run.part.glob("restart_forced_liggghts_*"):
            path.unlink()
    else:
        # First of all: a record of new inputs beside files of old ones would be a wrong one.
        shutil.rmtree(run.part, ignore_errors=True)
        run.part.mkdir()
        attempts = _record(run, run.first, Cost(), ())
    return Beginning(restart, note, attempts)


def _record(run: Run, step: int, before: Cost, starts: tuple[Attempt, ...]) -> Attempts:
    attempts = Attempts(run.inputs, (*starts, Attempt(step, time.time(), run.ranks, before)))
    write_attempts(run.part, attempts)
    return attempts


def _newest_whole(run: Run) -> tuple[RestartFile | None, list[str]]:
    """The newest restart file that is whole, as is the output up to it; why others are not."""
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
            problems.append(f"{restart.path.name} is of no use: {error}")
    return None, problems


def _put_aside(restart: RestartFile) -> RestartFile:
    """Out of the way of the files to come, so that there is a whole one at any moment."""
    aside = restart.path.with_name(RESUME_FILE)
    restart.path.replace(aside)
    return RestartFile(
        aside, restart.step, restart.written, restart.loop_time, restart.processor_time
    )


def _cut(run: Run, step: int) -> None:
    """Drop the rows after the step: the engine appends those to come."""
    for series in (run.part / name for name in SERIES):
        if not series.exists():
            continue
        length = series_length(series, run.first, step)
        if length < series.stat().st_size:
            write_copy(series, series, length)
