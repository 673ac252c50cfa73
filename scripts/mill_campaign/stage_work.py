"""What each stage does. Every function makes its products in `task.part`."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from mill_campaign.decks import copy_decks
from mill_campaign.engine_log import loop_timing, read_log
from mill_campaign.engine_run import run_deck
from mill_campaign.stage_table import DUMP_FOLDER, Stage
from mill_campaign.timing import timing_record


@dataclass(frozen=True)
class Task:
    """A stage of one case, and where it works.

    Attributes:
        case: content of case.json.
        folder: case folder, to read from.
        part: folder to write to.
        ranks: MPI ranks.
        lock: descriptor of the folder's lock, for the engine to inherit.
        screen: file where the output of the stage goes.
    """

    stage: Stage
    case: Mapping[str, Any]
    folder: Path
    part: Path
    ranks: int
    lock: int
    screen: Path

    @property
    def log(self) -> str:
        """Name of the engine's log."""
        return f"log.{self.stage.name}"


def mesh(task: Task) -> None:
    """Mesh the liner: by gmsh if the engine takes the mesh, as bare panels if people look at it."""
    from liner_mesh import build_liner_mesh, lint, write_stl, write_vtp
    from liner_mesh.curvature import curvature_range_deg
    from mill_campaign.charge import liner_of
    from mill_campaign.wall_panels import panels_of

    liner, wall = liner_of(task.case), task.case["wall"]
    length = task.case["mill"]["simulated_length_m"]
    build = build_liner_mesh if wall["kind"] == "mesh" else panels_of
    surface = build(liner, length, wall["chord_error_m"], wall["axial_divisions"])
    report = lint(surface, liner, length, wall["chord_error_m"])
    if not report.ok:
        raise RuntimeError(f"liner mesh not fit for use: {'; '.join(report.problems)}")
    low, high = curvature_range_deg(surface)
    if not low < wall["curvature_deg"] < high:
        raise RuntimeError(
            f"wall.curvature_deg is {wall['curvature_deg']:g}, the mesh needs {low:g} to {high:g}"
        )
    _write_json(task.part / "mesh.json", {"schema": 1, **asdict(report)})
    write_stl(task.part / "liner.stl", surface)
    if task.case["kind"] == "multi-ball":
        write_vtp(task.part / "liner.vtp", surface)


def charge(task: Task) -> None:
    from mill_campaign.charge import write_charge

    write_charge(task.case, task.part)


def deck(task: Task) -> None:
    from mill_campaign.parameters import write_parameters

    copy_decks(tuple(x for x in task.stage.products if x != "parameters.in"), task.part)
    write_parameters(task.case, task.part)
    if task.case["deck"]["dumps"] == "on":
        # The engine makes no folders: here for those who run the deck by hand.
        (task.part / DUMP_FOLDER).mkdir()


def engine(task: Task) -> None:
    """Run the stage's deck on links to the files of the case folder, and time it."""
    for path in {*task.folder.glob("*.in"), *(task.folder / x for x in task.stage.inputs)}:
        (task.part / path.name).symlink_to(Path("..") / path.name)
    (task.part / DUMP_FOLDER).mkdir()
    spent = run_deck(task.stage.deck, task.part, task.ranks, task.lock, task.log, task.screen)
    loop = loop_timing(read_log(task.part / task.log))
    if loop is None:
        raise RuntimeError(f"{task.log} holds no finished run")
    record = timing_record(task.stage.name, spent, loop)
    completion = task.stage.products[-1]
    _write_json(task.part / completion, record)
    if not any((task.part / DUMP_FOLDER).iterdir()):
        (task.part / DUMP_FOLDER).rmdir()


def settle(task: Task) -> None:
    """Settle the charge, or take the bed of a case whose charge settles the same way."""
    from mill_campaign.shared_settling import give, shared_bed, take

    products = task.stage.products
    with shared_bed(task.case, task.folder) as shared:
        if shared and take(shared, task.part, products):
            print(f"bed taken from {shared}")
            return
        engine(task)
        _measure_bed(task)
        if shared:
            give(shared, task.part, products)


def _measure_bed(task: Task) -> None:
    """Add to settled.json what the bed is like."""
    from mill_campaign import bed
    from mill_campaign.charge import room_of

    path, dump = task.part / task.stage.products[-1], task.part / bed.DUMP
    record = json.loads(path.read_text())
    _write_json(
        path, record | {"settled_by": task.case["id"]} | bed.bed_record(dump, room_of(task.case))
    )
    dump.unlink()


def result(task: Task) -> None:
    from mill_analysis import analyse_case

    analyse_case(task.folder)
    (task.folder / "result.json").replace(task.part / "result.json")


def _write_json(path: Path, content: dict) -> None:
    path.write_text(json.dumps(content, indent=1, allow_nan=False) + "\n")


WORK: dict[str, Callable[[Task], None]] = {
    "mesh": mesh,
    "charge": charge,
    "deck": deck,
    "settle": settle,
    "rotate": engine,
    "result": result,
}
