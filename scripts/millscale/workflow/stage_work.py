"""The work of each stage: functions that write the products of a stage into `task.part`."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from millscale.cases.decks import copy_decks, with_included
from millscale.engine.attempts import digests, read_attempts
from millscale.engine.deck_run import DeckRun, find_engine, run_deck
from millscale.engine.log import loop_timing, read_log
from millscale.engine.machine import Spread
from millscale.engine.output_files import check_output
from millscale.engine.provenance import stage_provenance
from millscale.engine.restart_file import read_restart
from millscale.engine.resume import RESTART_FILES, Run, begin, look
from millscale.engine.timing import Before, timing_record
from millscale.runs.case_file import Case
from millscale.runs.current import unfinished
from millscale.runs.layout import (
    BED_DUMP,
    DUMP_FOLDER,
    IMPACTS_FILES,
    LEDGER_FILES,
    LOADS_FILES,
    PROFILE_FILE,
    RESULT_FILE,
    STAGES,
    Stage,
)
from millscale.runs.writing import write_json

if TYPE_CHECKING:
    from millscale.mesh import LinerMesh, LintReport


@dataclass(frozen=True)
class Task:
    """A stage of one case to run.

    Attributes:
        case: content of case.json.
        folder: case folder, to read from.
        ranks: MPI ranks of the engine.
        lock: descriptor of the lock of the folder; the engine inherits it.
        spread: nodes of a batch job for the ranks; None for ranks on this machine.
    """

    stage: Stage
    case: Case
    folder: Path
    ranks: int
    lock: int
    spread: Spread | None = None

    @property
    def part(self) -> Path:
        """Folder to write to."""
        return self.folder / f"{self.stage.name}.part"

    @property
    def screen(self) -> Path:
        """File for the output of the stage."""
        return self.folder / f"out.{self.stage.name}"

    @property
    def log(self) -> str:
        """Name of the engine's log."""
        return f"log.{self.stage.name}"


def mesh(task: Task) -> None:
    write_mesh(task.case, task.part)


def write_mesh(case: Case, folder: Path) -> None:
    """Write the mesh of the liner: by gmsh for the engine, as plain panels for an analytic wall.

    Faults of a mesh that the engine does not read are noted in mesh.json and are no errors.
    """
    from millscale.cases.wall_panels import panels_of
    from millscale.mesh import build_liner_mesh, lint, write_stl, write_vtp
    from millscale.runs.liner import liner_of

    liner, wall = liner_of(case.mill), case.wall
    length = case.mill.simulated_length_m
    meshed = wall.kind == "mesh"
    build = build_liner_mesh if meshed else panels_of
    surface = build(liner, length, wall.chord_error_m, wall.axial_divisions)
    report = lint(surface, liner, length, wall.chord_error_m, for_engine=meshed)
    if meshed:
        assert wall.curvature_deg is not None  # as load_case has checked
        _check_mesh(surface, report, wall.curvature_deg)
    write_json(folder / "mesh.json", {"schema": 1, **asdict(report)})
    write_stl(folder / "liner.stl", surface)
    if case.kind == "multi-ball":
        write_vtp(folder / "liner.vtp", surface)


def _check_mesh(surface: LinerMesh, report: LintReport, curvature: float) -> None:
    """Refuse a mesh on which the engine would compute wrong contacts."""
    from millscale.mesh.curvature import curvature_range_deg

    if not report.ok:
        raise RuntimeError(f"liner mesh not fit for use: {'; '.join(report.problems)}")
    low, high = curvature_range_deg(surface)
    if not low < curvature < high:
        raise RuntimeError(
            f"wall.curvature_deg is {curvature:g}, the mesh needs {low:g} to {high:g}"
        )


def charge(task: Task) -> None:
    from millscale.packing.charge import write_charge

    write_charge(task.case, task.part)


def deck(task: Task) -> None:
    from millscale.cases.mpirun_script import write_script
    from millscale.cases.parameters import write_parameters

    copy_decks(tuple(x for x in task.stage.products if x != "parameters.in"), task.part)
    write_parameters(task.case, task.part)
    write_script(task.case, task.ranks, task.part)
    if task.case.deck.dumps == "on" and not (task.folder / DUMP_FOLDER).exists():
        # The engine makes no folders; this one is for a run by hand.
        (task.part / DUMP_FOLDER).mkdir()


def rotate(task: Task) -> None:
    write_json(task.part / task.stage.products[-1], engine(task))


def engine(task: Task) -> dict:
    """Run the deck of a stage, resuming an earlier attempt; return its timing record.

    The deck runs on links to the files of the case folder.
    """
    run = run_of(task.stage, task.case, task.folder, task.ranks)
    beginning = begin(run)
    if beginning.note:
        print(beginning.note, flush=True)
    for path in _engine_inputs(task.stage, task.folder):
        link = task.part / path.name
        link.unlink(missing_ok=True)
        link.symlink_to(Path("..") / path.name)
    (task.part / DUMP_FOLDER).mkdir(exist_ok=True)
    resume = beginning.restart is not None
    deck = DeckRun(task.stage.deck, task.part, task.log, task.screen, resume)
    spent = run_deck(deck, task.ranks, task.lock, task.spread)
    loop = loop_timing(read_log(task.part / task.log))
    if loop is None:
        raise RuntimeError(f"{task.log} holds no finished run")
    step = beginning.attempts.starts[-1].step
    check_output(task.part, run.first, step + loop.steps)
    if not any((task.part / DUMP_FOLDER).iterdir()):
        (task.part / DUMP_FOLDER).rmdir()
    before = Before(step - run.first, len(beginning.attempts.starts) - 1, beginning.before)
    return timing_record(task.stage.name, spent, loop, before)


def is_complete(task: Task) -> bool:
    """Return whether an earlier attempt was killed while it moved its finished products."""
    if not (task.part / task.stage.products[-1]).exists():
        return False
    earlier = read_attempts(task.part)
    run = run_of(task.stage, task.case, task.folder, task.ranks)
    return earlier is not None and earlier.inputs == run.inputs


@dataclass(frozen=True)
class EarlierAttempt:
    """An engine stage that was interrupted.

    Attributes:
        note: what the next run will do.
        ranks: MPI ranks on which it resumes; 0 if it starts again.
    """

    stage: str
    note: str
    ranks: int


def attempt_of(folder: Path, case: Case) -> EarlierAttempt | None:
    """Return the interrupted attempt of the stage that comes next; None if there is none."""
    stages = [stage for stage in STAGES[case.kind] if stage.deck]
    if not any((folder / f"{stage.name}.part").exists() for stage in stages):
        return None
    left = unfinished(folder, case.kind)
    stage = left[0][0] if left else None
    if stage is None or not (folder / f"{stage.name}.part").exists():
        return None
    run = run_of(stage, case, folder, ranks=1)
    restart, note = look(run)
    earlier = read_attempts(run.part)
    if not earlier:
        return None
    return EarlierAttempt(stage.name, note, earlier.starts[-1].ranks if restart else 0)


def run_of(stage: Stage, case: Case, folder: Path, ranks: int) -> Run:
    """Return the engine run of a stage: inputs, first step, number of steps, ranks."""
    inputs = digests([*_engine_inputs(stage, folder), find_engine()])
    time = case.time
    settled = time.settle_steps if stage.name == "rotate" else 0
    steps = time.settle_steps if stage.name == "settle" else time.steps
    of_case = time.settle_steps + time.steps
    return Run(folder / f"{stage.name}.part", inputs, settled, steps, of_case, ranks)


def inputs_of(stage: Stage, folder: Path) -> list[str]:
    """Return the files that a stage reads, with those its deck includes, the energy budget, the
    impacts and the loads on the liner."""
    included = with_included((stage.deck,), folder) if stage.deck else []
    profile = _profile(folder) if stage.deck else []
    more = (*LEDGER_FILES, *IMPACTS_FILES, *LOADS_FILES) if stage.name == "result" else ()
    return sorted({*stage.inputs, *included, *profile, *more})


def _engine_inputs(stage: Stage, folder: Path) -> list[Path]:
    given = [*stage.inputs, *_profile(folder)]
    return sorted({*folder.glob("*.in"), *(folder / name for name in given)})


def _profile(folder: Path) -> list[str]:
    """Return the file of a liner that is not of trapezoidal lifters, if the case has one."""
    return [PROFILE_FILE] if (folder / PROFILE_FILE).exists() else []


def settle(task: Task) -> None:
    """Settle the charge, or copy the bed of a case whose charge settles in the same way."""
    from millscale.workflow.shared_settling import give, shared_bed, take

    products = task.stage.products
    with shared_bed(task.case, task.folder) as shared:
        if shared and take(shared, task.part, products):
            print(f"bed taken from {shared.folder}")
            # The log of a bed that this case settled itself before.
            (task.folder / task.log).unlink(missing_ok=True)
            _drop_all_but(products, task.part)
            return
        record = engine(task)
        for name in RESTART_FILES:
            (task.part / name).unlink(missing_ok=True)
        write_json(task.part / products[-1], record | bed_part(task.case, task.part))
        (task.part / BED_DUMP).unlink()
        # On a full disk the engine truncates files without an error.
        read_restart(task.part / products[0])
        if shared:
            made = {name: task.part / name for name in products}
            give(shared, task.part, products, provenance_of(task, made, task.part / task.log))


def provenance_of(task: Task, made: Mapping[str, Path], log: Path) -> dict[str, Any]:
    """Return the record for provenance.json of a stage that has made these files, by name."""
    inputs = inputs_of(task.stage, task.folder)
    return stage_provenance(task.folder, task.case, inputs, made, log, task.ranks)


def _drop_all_but(products: tuple[str, ...], part: Path) -> None:
    """Delete all files in a part folder but the products."""
    for path in part.iterdir():
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        elif path.name not in products:
            path.unlink()


def bed_part(case: Case, folder: Path) -> dict[str, Any]:
    """Return the part of settled.json that describes the bed whose dump is in a folder."""
    from millscale.packing import bed
    from millscale.packing.charge import room_of

    gravity, meshed = case.mill.gravity_m_s2, case.wall.kind == "mesh"
    measured = bed.bed_record(folder / BED_DUMP, room_of(case), gravity, meshed)
    return {"settled_by": case.id, **measured}


def result(task: Task) -> None:
    from millscale.analysis.case import analyse_case

    write_json(task.part / RESULT_FILE, analyse_case(task.folder))


WORK: dict[str, Callable[[Task], None]] = {
    "mesh": mesh,
    "charge": charge,
    "deck": deck,
    "settle": settle,
    "rotate": rotate,
    "result": result,
}
