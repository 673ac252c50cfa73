"""The smooth drum in other engines than LIGGGHTS: LAMMPS and Yade, as Debian packages them."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from millscale import _core
from millscale.bench.running import engine_output
from millscale.bench.state import State, read_data
from millscale.engine.deck_run import mpirun_line
from millscale.errors import CampaignError
from millscale.runs.writing import write_json, write_text

DECKS = Path(__file__).parent / "decks"
_LOOP = re.compile(r"^Loop time of (\S+) on \d+ procs", re.M)
_SECTION = re.compile(r"^(Pair|Neigh|Comm)\s*\|\s*\S+\s*\|\s*(\S+)", re.M)


@dataclass(frozen=True)
class Timed:
    """Wall time of the timed steps [s], and of its parts if the engine reports them."""

    total: float
    pair: float | None = None
    neigh: float | None = None
    comm: float | None = None


def lammps(state: State, values: Mapping[str, object], ranks: int, folder: Path) -> Timed:
    """Run a state in LAMMPS; raise EngineError if it fails."""
    lines = [f"variable {name} string {value}\n" for name, value in values.items()]
    write_text(folder / "values.in", "".join(lines))
    shutil.copyfile(DECKS / "lammps.in", folder / "lammps.in")
    line = mpirun_line(_installed("lmp", "lammps"), "lammps.in", "log.lammps", ranks)
    text = engine_output(line, folder)
    total = _LOOP.findall(text)[-1]
    parts = _SECTION.findall(text[text.rindex("Loop time of") :])
    return Timed(float(total), **{name.lower(): float(seconds) for name, seconds in parts})


def yade(state: State, values: Mapping[str, object], ranks: int, folder: Path) -> Timed:
    """Run a state in Yade on `ranks` threads; raise an error if it fails."""
    ball, mill = state.case.ball, state.case.mill
    of_yade = {
        **{k: v for k, v in values.items() if isinstance(v, (int, float))},
        "density": ball.density_kg_m3,
        "friction": state.case.material.static_friction_pp,
        "damping_ratio": _core.damping_ratio(state.case.material.restitution_pp),
        "length": mill.simulated_length_m,
    }
    write_json(folder / "values.json", of_yade)
    balls = read_data(state.data)
    rows = np.column_stack([balls["place"], balls["radius"], balls["velocity"], balls["spin"]])
    write_json(folder / "balls.json", rows.tolist())
    shutil.copyfile(DECKS / "yade_drum.py", folder / "yade_drum.py")
    line = [_installed("yade", "yade"), "-n", "-x", "-j", str(ranks), "yade_drum.py"]
    text = engine_output(line, folder)
    found = re.search(r"^TIMED (.*)$", text, re.M)
    if not found:
        raise RuntimeError(f"yade in {folder} printed no time: {text[-500:]}")
    timed = json.loads(found[1])
    if timed["balls"] != state.balls or not timed["fastest"] < 50.0:
        raise RuntimeError(f"yade in {folder}: {timed}; expected {state.balls} balls below 50 m/s")
    return Timed(timed["seconds"])


def _installed(command: str, package: str) -> Path:
    path = shutil.which(command)
    if path is None:
        raise CampaignError(
            "millscale bench --scene drum", command, "not found on the PATH",
            f"apt-get install {package}: only this scene needs it",
        )  # fmt: skip
    return Path(path)


PEERS = {"lammps": lammps, "yade": yade}
