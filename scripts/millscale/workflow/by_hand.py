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

from millscale.formats import counted
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
    """Which of the stages left of a case were run by hand.

    Attributes:
        stages: those whose results can be used, from the first stage left on.
        problem: why the results of the next stage cannot be used; empty if it has none.
        running: whether mpirun.sh runs in the folder.
    """

    stages: tuple[Stage, ...] = ()
    problem: str = ""
    running: bool = False


# Problems by case folder and stage, with the state of the files they were found in.
_KNOWN: dict[tuple[Path, str], tuple[object, str]] = {}


def is_there(folder: Path, stage: Stage) -> bool:
    """Return whether a case folder holds results of an engine stage that the stage did not make.

    Results with a record are those of the stage; they may be damaged or of an earlier case.json.
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
    """Return whether provenance.json records that a stage was run by hand."""
    return read_provenance(folder).get(stage.name, {}).get("by") == BY_HAND


def find(folder: Path, case: Case, left: Sequence[Stage]) -> Found:
    """Return which of the stages left were run by hand; reads no dumps, writes no file."""
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
    """Return what the next run does with stages run by hand; empty if there are none."""
    left = [stage for stage, _ in unfinished(folder, case.kind)]
    found = find(folder, case, left)
    names = " and ".join(stage.name for stage in found.stages)
    return f"{names} run by hand: taken over, only missing stages run" if names else ""


def is_rotated(folder: Path, case: Case) -> bool:
    """Return whether all engine stages of a case are done and some were run by hand."""
    left = [stage for stage, _ in unfinished(folder, case.kind)]
    found = find(folder, case, left)
    return bool(found.stages) and not any(x.deck for x in left[len(found.stages) :])


def _problem(folder: Path, case: Case, stage: Stage) -> str:
    """Return why a stage run by hand cannot be used; remembered until a file changes."""
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
    """Return whether mpirun.sh holds the lock of a case folder."""
    holder = read_head(folder / LOCK_FILE, _LONGEST_HOLDER)
    return holder.rstrip().endswith("by mpirun.sh") and not is_gone(holder)


def check_replaced(folder: Path, case: Case, stage: Stage) -> None:
    """Refuse to write a product again that a run by hand may have read in another form.

    Raises:
        NotUsedError: a product was edited, and there are results made by hand.
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
        NotUsedError: its results cannot be used.
    """
    try:
        run = examine(task.folder, task.case, task.stage)
    except NotUsedError as error:
        print(error, flush=True)
        raise
    print(f"run by hand on {counted(run.ranks, 'MPI rank')}: taken over", flush=True)
    record = dict(run.timing)
    if task.stage.name == "settle":
        record |= bed_part(task.case, task.folder)
    new_folder(task.part)
    write_json(task.part / task.stage.products[-1], record)
    return run


def hand_provenance(record: Mapping[str, Any], run: HandRun, name: str) -> dict[str, Any]:
    """Return the record of a stage as one run by hand on an unknown machine."""
    unknown = ("hardware", "host", "system", "command")
    kept = {key: value for key, value in record.items() if key not in unknown}
    return kept | {
        "by": BY_HAND,
        "engine": {"version": run.engine},
        "ranks": run.ranks,
        "stage_command": f"recognised by log.{name}",
    }
