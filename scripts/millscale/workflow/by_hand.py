"""Engine stages that were run by hand: by mpirun.sh, or by lines typed in a case folder.

Their results lie in the case folder without a record in provenance.json. They are used only if
`results_check` shows that they are whole and of this case.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from millscale.runs.case_file import Case
from millscale.runs.current import unfinished
from millscale.runs.digests import Digests
from millscale.runs.layout import STAGES, Stage
from millscale.runs.lock import LOCK_FILE, is_gone
from millscale.runs.provenance import read_provenance
from millscale.runs.untrusted import read_head
from millscale.runs.writing import new_folder, write_json
from millscale.workflow.results_check import HandRun, NotUsedError, examine
from millscale.workflow.stage_work import Task, bed_part

BY_HAND = "hand"
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


def is_there(folder: Path, stage: Stage) -> bool:
    """Whether a case folder holds results of an engine stage that the stage has not made.

    Results that the stage has recorded are its own; they may be damaged or of an earlier case.json.
    """
    made, record = stage.products[0], stage.products[-1]
    if not stage.deck or not (folder / made).exists():
        return False
    stages = read_provenance(folder)
    found, known = Digests(folder), stages.get(stage.name)
    if known is None:
        return not (folder / record).exists()
    if found.of(made) == known["products"].get(made):
        return False
    inputs = known["inputs"].items()
    return not (folder / record).exists() or any(found.of(x) != digest for x, digest in inputs)


def is_recorded(folder: Path, stage: Stage) -> bool:
    """Whether provenance.json says that a stage was run by hand."""
    return read_provenance(folder).get(stage.name, {}).get("by") == BY_HAND


def find(folder: Path, case: Case, left: Sequence[Stage]) -> Found:
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


def note(folder: Path, case: Case) -> str:
    """What the next run does about stages that were run by hand; empty if there are none."""
    left = [stage for stage, _ in unfinished(folder, case.kind)]
    found = find(folder, case, left)
    names = " and ".join(stage.name for stage in found.stages)
    return f"{names} run by hand: taken over, only what is missing is run" if names else ""


def is_rotated(folder: Path, case: Case) -> bool:
    """Whether the engine has nothing left to do in a case, some of it by hand."""
    left = [stage for stage, _ in unfinished(folder, case.kind)]
    found = find(folder, case, left)
    return bool(found.stages) and not any(x.deck for x in left[len(found.stages) :])


def _problem(folder: Path, case: Case, stage: Stage) -> str:
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


def check_replaced(folder: Path, case: Case, stage: Stage) -> None:
    """Refuse to make again what a run by hand may have read in another form.

    Raises:
        NotUsedError: a product is not what the stage has made of this case.json, and there are
            results made by hand.
    """
    record = read_provenance(folder).get(stage.name)
    if stage.deck or record is None or record.get("case") != case.digest:
        return
    found = Digests(folder)
    made = {x: record["products"].get(x) for x in stage.products if not x.endswith(".in")}
    changed = [x for x, digest in made.items() if found.of(x) not in (None, digest)]
    later = [x for x in STAGES[case.kind] if x.deck and is_there(folder, x)]
    if changed and later:
        cause = f"{changed[0]} is not the file that stage {stage.name} made"
        raise NotUsedError(f"{later[0].products[0]} made by hand is not used: {cause}")


def take_over(task: Task) -> HandRun:
    """Write the records of a stage that was run by hand into its part folder.

    Raises:
        NotUsedError: what was run by hand cannot be used.
    """
    try:
        run = examine(task.folder, task.case, task.stage)
    except NotUsedError as error:
        print(error, flush=True)
        raise
    print(f"run by hand on {run.ranks} MPI ranks: taken over", flush=True)
    record = dict(run.timing)
    if task.stage.name == "settle":
        record |= bed_part(task.case, task.folder)
    new_folder(task.part)
    write_json(task.part / task.stage.products[-1], record)
    return run


def hand_provenance(record: Mapping[str, Any], run: HandRun, name: str) -> dict[str, Any]:
    """The record of a stage as made by hand, on a machine that nobody knows."""
    unknown = ("hardware", "host", "system", "command")
    kept = {key: value for key, value in record.items() if key not in unknown}
    return kept | {
        "by": BY_HAND,
        "engine": {"version": run.engine},
        "ranks": run.ranks,
        "stage_command": f"recognised by log.{name}",
    }
