"""attempts.json of a part folder: the starts of the engine, their inputs and their cost."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path

from millscale.engine.restart_file import RestartFile
from millscale.runs.case_file import MOST_RANKS, MOST_STEPS
from millscale.runs.digests import digest_of
from millscale.runs.typed import read_typed
from millscale.runs.untrusted import RunFolderError
from millscale.runs.writing import write_json

ATTEMPTS_FILE = "attempts.json"


@dataclass(frozen=True)
class Cost:
    """Cost of some steps [s]: wall time, processor time of all ranks, wall time of the time loop,
    and that times the ranks."""

    wall_time: float = 0.0
    processor_time: float = 0.0
    loop_time: float = 0.0
    core_time: float = 0.0

    def __add__(self, other: Cost) -> Cost:
        return Cost(*(a + b for a, b in zip(_values(self), _values(other), strict=True)))


@dataclass(frozen=True)
class Attempt:
    """One start of the engine.

    Attributes:
        step: step of the engine at which it began.
        began: time at which it began [s since 1970].
        before: cost of the steps before `step`.
    """

    step: int
    began: float
    ranks: int
    before: Cost


@dataclass(frozen=True)
class Attempts:
    """All starts of the engine for one run, in order.

    Attributes:
        inputs: file -> SHA-256 of what decides the run.
    """

    inputs: dict[str, str]
    starts: tuple[Attempt, ...] = ()

    def cost_until(self, restart: RestartFile) -> Cost:
        """Return the cost of the steps before a restart file, without repeated steps."""
        writer = [attempt for attempt in self.starts if attempt.step < restart.step][-1]
        wall, loop = restart.written - writer.began, restart.loop_time
        return writer.before + Cost(wall, restart.processor_time, loop, loop * writer.ranks)


def digests(files: Iterable[Path]) -> dict[str, str]:
    """Return the SHA-256 of each file that exists, by name."""
    return {
        path.name: digest_of(path, follow=True) for path in sorted(set(files)) if path.is_file()
    }


def read_attempts(part: Path) -> Attempts | None:
    """Return the record of a part folder; None if there is none that can be read."""
    try:
        attempts = read_typed(part / ATTEMPTS_FILE, Attempts, "")
    except RunFolderError:
        return None
    fits = all(0 <= x.step <= MOST_STEPS and 0 < x.ranks <= MOST_RANKS for x in attempts.starts)
    return attempts if attempts.starts and fits else None


def write_attempts(part: Path, attempts: Attempts) -> None:
    write_json(part / ATTEMPTS_FILE, {"schema": 1, **asdict(attempts)})


def _values(cost: Cost) -> tuple[float, ...]:
    return cost.wall_time, cost.processor_time, cost.loop_time, cost.core_time
