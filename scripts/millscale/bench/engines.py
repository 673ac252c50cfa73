"""One timed run of a state in one engine."""

from __future__ import annotations

import math
import re
import shutil
from dataclasses import dataclass, replace
from pathlib import Path

from millscale.bench.case_step import write_case_step
from millscale.bench.peers import PEERS, Timed
from millscale.bench.running import engine_output
from millscale.bench.state import State
from millscale.campaign.contacts import ContactOptions
from millscale.cases.wall_panels import panels_of
from millscale.engine.deck_run import find_engine, mpirun_line
from millscale.engine.log import loop_timing
from millscale.engine.material_block import material_block
from millscale.errors import CampaignError, EngineError
from millscale.mesh import curvature_deg
from millscale.runs.atom_types import atom_types
from millscale.runs.case_file import Case
from millscale.runs.liner import liner_of
from millscale.runs.writing import write_text

DECKS = Path(__file__).parent / "decks"
SKIN_RADIUS = 0.020
_TIME_LOOP = re.compile(r"^Time loop: (.+)$", re.M)


@dataclass(frozen=True)
class Variant:
    """An engine and the options of its deck.

    Attributes:
        engine: millscale or liggghts.
        wall: analytic or mesh.
        pair: a key of CONTACTS; of another engine, the name of its contact model.
        skin: of the neighbour list [m], of balls of `SKIN_RADIUS`; by default the optimum of stock
            contacts. Other balls take it in proportion to the smallest radius.
        step: scene, a deck of the bench; or bare and campaign, steps of the decks of the case.
    """

    engine: str
    wall: str
    pair: str
    skin: float = 0.015
    step: str = "scene"


LAMMPS = Variant("lammps", "analytic", "granular")
YADE = Variant("yade", "mesh", "mindlin")
MILLSCALE = Variant("millscale", "analytic", "fast", skin=0.020)
MIXED = Variant("millscale", "analytic", "mixed", skin=0.020)
LIGGGHTS = Variant("liggghts", "mesh", "stock")
ANALYTIC_WALL_ONLY = Variant("millscale", "analytic", "stock")
# Skin and damping of these are those of the case.
BARE, BARE_MIXED, CAMPAIGN, CAMPAIGN_MIXED = (
    replace(variant, step=step) for step in ("bare", "campaign") for variant in (MILLSCALE, MIXED)
)

CONTACTS = {
    "fast": ContactOptions(damping="plain"),
    "mixed": ContactOptions(damping="plain", precision="mixed"),
    "stock": ContactOptions("stock", "plain"),
}


@dataclass(frozen=True)
class Phases:
    """Time of the parts of a run [ns per ball, step and core]; None if the engine lacks it.

    Attributes:
        time_loop: the loop that ran, in the words of the log; None if the log names none.
    """

    total: float
    pair: float | None
    neigh: float | None
    comm: float | None
    other: float | None
    time_loop: str | None = None

    @property
    def outside_pair_and_neigh(self) -> float:
        """Time of all other parts."""
        if self.pair is None or self.neigh is None:
            raise ValueError("the engine reports no time of pair and neighbour list")
        return self.total - self.pair - self.neigh


def engine_of(variant: Variant) -> Path:
    """Return the executable; Debian's for stock LIGGGHTS."""
    if variant.engine == "millscale":
        return find_engine()
    stock = shutil.which("liggghts")
    if stock is None:
        raise CampaignError("liggghts", "", "not found on the PATH", "run scripts/setup")
    return Path(stock)


def time_run(
    variant: Variant, state: State, ranks: int, warm_steps: int, steps: int, folder: Path
) -> Phases:
    """Run a state in an engine and return its own timing of the last `steps`.

    Raises:
        EngineError: the engine did not finish; states why.
    """
    folder.mkdir(parents=True, exist_ok=True)
    values = _values(variant, state) | {"warm_steps": warm_steps, "steps": steps}
    if variant.engine in PEERS:
        timed = PEERS[variant.engine](state, values, ranks, folder)
        return _phases_of_peer(timed, 1e9 * ranks / (steps * state.balls))
    contacts = CONTACTS[variant.pair]
    for path in DECKS.glob("*.in"):
        shutil.copyfile(path, folder / path.name)
    if variant.step == "scene":
        models = "hertz tangential history rolling_friction ${rolling}"
        words = contacts.pair_style_words()
        write_text(folder / "pair.in", f"pair_style gran model {models} {words}\n")
        lines = [f"variable {name} string {value}\n" for name, value in values.items()]
        write_text(folder / "values.in", "".join(lines))
        write_text(folder / "properties.in", _properties(state.case))
        deck = "bench.in"
    else:
        deck = write_case_step(variant.step, contacts.precision, state, (warm_steps, steps), folder)
    text = engine_output(mpirun_line(engine_of(variant), deck, "log.bench", ranks), folder)
    loop = _TIME_LOOP.findall(text)
    return _phases(text[text.rindex("Loop time of") :], loop[-1].strip() if loop else None)


def _phases_of_peer(timed: Timed, each: float) -> Phases:
    """Return phases from times [s]; `each` converts them to ns per ball, step and core."""
    if timed.pair is None or timed.neigh is None or timed.comm is None:
        return Phases(timed.total * each, None, None, None, None)
    parts = (timed.pair, timed.neigh, timed.comm)
    pair, neigh, comm, other = (each * t for t in (*parts, timed.total - sum(parts)))
    return Phases(each * timed.total, pair, neigh, comm, other)


def _phases(text: str, time_loop: str | None = None) -> Phases:
    loop = loop_timing(text)
    if loop is None:
        raise EngineError("the engine's output has no timing of its steps")
    each = loop.loop_time * loop.ranks / loop.particle_steps * 1e9
    share = loop.share
    return Phases(
        each,
        each * share["pair"],
        each * share["neigh"],
        each * share["comm"],
        each * (share["other"] + share["output"]),
        time_loop,
    )


def _values(variant: Variant, state: State) -> dict[str, object]:
    case = state.case
    mill, material = case.mill, case.material
    names = ("restitution", "static_friction", "rolling_friction")
    return {
        "state": state.data,
        "liner_file": state.liner,
        "wall": variant.wall,
        "skin": variant.skin * smallest_radius(case) / SKIN_RADIUS,
        "liner_type": atom_types(case).liner_type,
        "time_step": case.time.step_s,
        "youngs_modulus": material.youngs_modulus_pa,
        "poisson_ratio": material.poisson_ratio,
        **{f"{n}_{p}": getattr(material, f"{n}_{p}") for n in names for p in ("pp", "pw")},
        **({"curvature_deg": _curvature(case)} if variant.wall == "mesh" else {}),
        "turned": mill.phase_rad + state.mill_angle,
        "turned_deg": math.degrees(state.mill_angle),
        "period": 2.0 * math.pi / mill.omega_rad_s,
        "rolling": case.deck.rolling_model_pp,
        "gravity": mill.gravity_m_s2,
        "omega": mill.omega_rad_s,
        "mill_radius": mill.radius_m,
        "ball_radius": case.ball.radius_m,
        "lifters": mill.lifters,
        "lifter_top_radius": mill.lifter_top_radius_m,
        "lifter_top_width": mill.lifter_top_width_m,
        "groove_width": mill.groove_width_m,
    }


def smallest_radius(case: Case) -> float:
    """Return the radius of the smallest class [m]."""
    return min((one.radius_m for one in case.ball.classes), default=case.ball.radius_m)


def _properties(case: Case) -> str:
    """Return the lines of a deck with the properties of all types."""
    types = atom_types(case)
    return material_block(
        [one.youngs_modulus_pa for one in types.all],
        [one.poisson_ratio for one in types.all],
        restitution=types.matrix("restitution"),
        friction=types.matrix("static_friction"),
        rolling_friction=types.matrix("rolling_friction"),
    )


def _curvature(case: Case) -> float:
    """Return `curvature` for the mesh of a case [degrees], also of one with an analytic wall."""
    wall, length = case.wall, case.mill.simulated_length_m
    return curvature_deg(
        panels_of(liner_of(case.mill), length, wall.chord_error_m, wall.axial_divisions)
    )
