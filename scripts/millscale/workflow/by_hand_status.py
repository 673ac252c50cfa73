"""What was run by hand of a case, for the status and the next run; writes nothing."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from millscale.runs.current import unfinished
from millscale.runs.layout import Stage
from millscale.runs.lock import LOCK_FILE, is_gone
from millscale.runs.untrusted import read_head
from millscale.workflow.by_hand import NotUsedError, examine, is_there

_LONGEST_HOLDER = 200


@dataclass(frozen=True)
class Found:
    """What was run by hand among the engine stages left of a case.

    Attributes:
        stages: those that were run by hand and can be used, from the first one left on.
        problem: why the next one cannot be used; empty if nothing of it is there.
        running: whether mpirun.sh is at work in the folder.
    """

    stages: tuple[Stage, ...] = ()
    problem: str = ""
    running: bool = False


# Results of `find` by case folder and stage, with the state of the files that they are of.
_KNOWN: dict[tuple[Path, str], tuple[object, str]] = {}


def find(folder: Path, case: Mapping[str, Any], left: Sequence[Stage]) -> Found:
    """What was run by hand of the stages left of a case; reads no dumps, writes nothing."""
    running = _is_running(folder)
    usable: list[Stage] = []
    for stage in left:
        if not is_there(folder, stage):
            break
        if problem := _problem(folder, case, stage):
            return Found(tuple(usable), "" if running else problem, running)
        usable.append(stage)
    return Found(tuple(usable), "", running)


def note(folder: Path, case: Mapping[str, Any]) -> str:
    """What the next run does about stages that were run by hand; empty if there are none."""
    left = [stage for stage, _ in unfinished(folder, case["kind"])]
    found = find(folder, case, left)
    names = " and ".join(stage.name for stage in found.stages)
    return f"{names} run by hand: taken over, only what is missing is run" if names else ""


def is_rotated(folder: Path, case: Mapping[str, Any]) -> bool:
    """Whether the engine has nothing left to do in a case, some of it by hand."""
    left = [stage for stage, _ in unfinished(folder, case["kind"])]
    found = find(folder, case, left)
    return bool(found.stages) and not any(x.deck for x in left[len(found.stages) :])


def _problem(folder: Path, case: Mapping[str, Any], stage: Stage) -> str:
    """Why a stage that was run by hand cannot be used; known until a file changes."""
    with os.scandir(folder) as entries:
        found = [(x.name, x.stat(follow_symlinks=False)) for x in entries]
    state = sorted((name, x.st_size, x.st_mtime_ns) for name, x in found)
    key = (folder, stage.name)
    if key not in _KNOWN or _KNOWN[key][0] != state:
        problem = ""
        try:
            examine(folder, case, stage, dumps=False)
        except NotUsedError as error:
            problem = str(error)
        _KNOWN[key] = state, problem
    return _KNOWN[key][1]


def _is_running(folder: Path) -> bool:
    """Whether mpirun.sh holds the lock of a case folder."""
    holder = read_head(folder / LOCK_FILE, _LONGEST_HOLDER)
    return holder.rstrip().endswith("by mpirun.sh") and not is_gone(holder)
