"""attempts.json of a stage's part folder: from what, how often and where from the engine began."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path

from mill_campaign.restart_file import RestartFile

ATTEMPTS_FILE = "attempts.json"


@dataclass(frozen=True)
class Cost:
    """What steps took [s]: from start to end, on all processors, in the time loop, and the latter
    times the ranks."""

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
        step: of the engine, where it began.
        began: when it did [s since 1970].
        before: cost of the steps before `step`.
    """

    step: int
    began: float
    ranks: int
    before: Cost


@dataclass(frozen=True)
class Attempts:
    """All starts of the engine for one run, the first one first.

    Attributes:
        inputs: file -> SHA-256 of what decides the run.
    """

    inputs: dict[str, str]
    starts: tuple[Attempt, ...] = ()

    def cost_until(self, restart: RestartFile) -> Cost:
        """Of the steps that led to a restart file; those that had to be made again not counted."""
        writer = [attempt for attempt in self.starts if attempt.step < restart.step][-1]
        wall, loop = restart.written - writer.began, restart.loop_time
        return writer.before + Cost(wall, restart.processor_time, loop, loop * writer.ranks)


def digests(files: Iterable[Path]) -> dict[str, str]:
    """Name -> SHA-256 of each file that is there."""
    found = {}
    for path in sorted(set(files)):
        if path.is_file():
            with path.open("rb") as file:
                found[path.name] = hashlib.file_digest(file, "sha256").hexdigest()
    return found


def read_attempts(part: Path) -> Attempts | None:
    """The record of a part folder; None if there is none that can be read."""
    try:
        record = json.loads((part / ATTEMPTS_FILE).read_text())
        starts = [Attempt(**x | {"before": Cost(**x["before"])}) for x in record["starts"]]
        return Attempts(dict(record["inputs"]), tuple(starts)) if starts else None
    except (OSError, ValueError, TypeError, KeyError):
        return None


def write_attempts(part: Path, attempts: Attempts) -> None:
    copy = part / f"{ATTEMPTS_FILE}.part"
    copy.write_text(json.dumps({"schema": 1, **asdict(attempts)}, indent=1) + "\n")
    copy.replace(part / ATTEMPTS_FILE)


def _values(cost: Cost) -> tuple[float, ...]:
    return cost.wall_time, cost.processor_time, cost.loop_time, cost.core_time
