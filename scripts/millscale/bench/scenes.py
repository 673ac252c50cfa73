"""The mills that are timed; each is rotated once, and its state is kept."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console

from millscale.bench.running import engine_output, finish_campaign
from millscale.bench.state import STATE_FILE, State, write_data
from millscale.engine.deck_run import find_engine
from millscale.mesh import build_liner_mesh, write_stl
from millscale.runs.atom_types import atom_types
from millscale.runs.case_file import load_case
from millscale.runs.liner import liner_of
from millscale.runs.untrusted import read_object
from millscale.runs.writing import write_json

MILLS = Path(__file__).parent / "mills.toml"
DRUM = Path(__file__).parent / "drum.toml"
MIXTURE = Path(__file__).parent / "mixture.toml"
SLICE_OF_MILL = Path(__file__).parent / "slice.toml"
_ANGLE = re.compile(r"^ *\d+ +\d+ +\S+ +(\S+)", re.M)


@dataclass(frozen=True)
class Scene:
    """A rotating mill to time.

    Attributes:
        campaign: its file.
        case: its id.
        ranks: MPI ranks it is timed on.
        steps: of one timed run, and of one with --quick.
        rounds: of timed runs, one of each engine. Shared machines change their pace within seconds,
            so many short rounds and their median tell more than few long ones.
    """

    name: str
    campaign: Path
    case: str
    ranks: int
    steps: int
    quick_steps: int
    rounds: int


SCENES = {
    scene.name: scene
    for scene in (
        Scene("s2.6", MILLS, "mb-cg-paper-S2.600", 1, 1000, 500, 11),
        Scene("s1", MILLS, "mb-cg-paper-S1.000", 2, 400, 200, 5),
        Scene("drum", DRUM, "mb-cg-paper-S1.000", 1, 500, 400, 5),
        Scene("mixture", MIXTURE, "mb-cg-paper-S1.000", 1, 500, 200, 5),
    )
}

# For the step of a campaign over the bare one.
CASE = Scene("campaign", SLICE_OF_MILL, "mb-cg-paper-S2.600", 1, 2000, 1000, 11)

# For the cost against size: about equal ball-steps.
SIZES = tuple(
    Scene("size", MILLS, f"mb-cg-paper-S{S:.3f}", 1, steps, steps, 3)
    for S, steps in ((6.1, 10000), (4.2, 4000), (2.6, 1000), (1.696, 300), (1.0, 100))
)


def prepare(scene: Scene, folder: Path, console: Console) -> State:
    """Return the state of a scene; the first call makes it in minutes (S = 1: ten or more)."""
    folder = folder if scene.campaign == MILLS else folder / scene.name
    case_folder = folder / "cases" / scene.case
    kept = case_folder / "state.json"
    if not kept.exists():
        finish_campaign(scene.campaign, folder, [scene.case], console)
        _write_state(case_folder)
    about = read_object(kept, "delete it: millscale bench writes it again")
    case = load_case(case_folder)
    return State(
        case,
        (case_folder / STATE_FILE).absolute(),
        (case_folder / "liner.stl").absolute(),
        about["mill_angle_rad"],
        about["balls"],
    )


def _write_state(case_folder: Path) -> None:
    """Write the state from the last restart file of a case."""
    restarts = sorted(case_folder.glob("mill.*.restart"), key=lambda p: p.stat().st_mtime)
    deck = Path(__file__).parent / "decks" / "state.in"
    line = [find_engine(), "-in", deck.absolute(), "-log", "log.state"]
    text = engine_output([*line, "-var", "restart", restarts[-1].name], case_folder)
    angle = _ANGLE.findall(text)
    if not angle:
        raise RuntimeError(f"{deck.name} in {case_folder}: {text[-500:]}")
    case = load_case(case_folder)
    box = (case.domain.half_box_m, case.mill.simulated_length_m)
    dump = case_folder / "state.dump"
    types = len(atom_types(case).all)
    balls = write_data(dump, box, case_folder / STATE_FILE, types)
    dump.unlink()
    surface = build_liner_mesh(
        liner_of(case.mill), box[1], case.wall.chord_error_m, case.wall.axial_divisions
    )
    write_stl(case_folder / "liner.stl", surface)
    write_json(case_folder / "state.json", {"mill_angle_rad": float(angle[-1]), "balls": balls})
