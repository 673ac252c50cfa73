"""How long a case will take: ghost balls counted, rates measured here or taken from runs that were.

A rank that owns a slab of the charge also works on the balls of its neighbours that reach into it:
    time of a step = c(N) N / ranks (1 + GHOST_SHARE * 2 reach / slab),  reach = 2 a + skin,
c being the time of a ball and step in a slab without ends, N the balls, slab = length / ranks. The
skin counts up to a ball radius: a longer one, for fast balls, saves more lists than it costs.
Derived here; a charge on one rank has the same ends, as it is periodic along the axis.
Large charges do not fit the cache, and their balls fall further and faster: c(N) = c where
N <= IN_CACHE, else c (1 + growth ln(N / IN_CACHE)), fitted to `millscale bench --scene size`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median
from typing import Any

from millscale.runs.case_file import Case, load_case
from millscale.runs.untrusted import read_object

# Time of a ball and step without ghost balls [s], one core of a Xeon with AVX-512, by contacts and
# wall: a fourth above the bare step of docs/results/cost-against-size.json, whose machine was fast
# on that day, and for what a campaign measures. Stock contacts on the analytic wall take 0.78 of
# their time on a mesh, and our contacts on a mesh 40 ns more (liner-wall.json, at this pace).
BALL_STEP = {
    ("fast", "analytic"): 55e-9,
    ("default", "analytic"): 226e-9,
    ("default", "mesh"): 290e-9,
    ("fast", "mesh"): 95e-9,
}
IN_CACHE = 13_370
GROWTH = {"fast": 0.27, "default": 0.17}
# The same with an account of the energy over that without: the mill of S = 2.6, a radian in 50 s
# where a rotation of 8 took 126 s. Settling keeps none and is predicted too long.
LEDGER = 3.2
# The same with spectra of impacts: 13,370 balls of S = 2.6, 1.3 to 1.5 in both precisions by
# processor time beside other work, which is no benchmark.
IMPACTS = 1.4
# Work on a ghost ball over that on an own one: at 2.3 ball diameters a slab a step takes 1.6 times
# as long per ball as at 9.6 (quick.toml on two ranks, the scene above on one).
GHOST_SHARE = 0.85
# A single ball: time of a step on the analytic wall, with a sample every 0.005 rad (1.0 to 1.7 us
# in quick.toml); on a mesh, where the engine turns every triangle at every step.
ANALYTIC_STEP = 1.5e-6
MESH_STEP, TRIANGLE_STEP = 24e-6, 0.38e-6
# mpirun's start and end, which is what a short run takes [s].
START = 0.45
# Slabs thinner than this, in mean ball diameters, hold more ghost balls than balls of their own.
THINNEST_SLAB = 2.0
# Memory of a rank without balls, and of a ball with its lists and contacts [MB], twice what balls
# take (docs/results/performance.md, Memory); the stages in Python, above all the analysis of a
# charge [MB].
RANK_MB, BALL_MB, STAGES_MB = 100.0, 0.005, 500.0


@dataclass(frozen=True)
class Rates:
    """Measured over predicted time, by `path_of` a case; 1 where nothing was measured."""

    corrections: Mapping[str, float] = field(default_factory=dict)

    def correction(self, case: Case) -> float:
        return self.corrections.get(path_of(case), 1.0)


BUILT_IN = Rates()


def path_of(case: Case) -> str:
    """Return what decides the rate of a case: kind, wall and contact backend."""
    surface = f" {case.deck.surface}" if case.kind == "multi-ball" else ""
    mixed = " mixed" if surface and case.deck.precision == "mixed" else ""
    ledger = " ledger" if _keeps_ledger(case) else ""
    impacts = " impacts" if _records_impacts(case) else ""
    return f"{case.kind} {case.wall.kind}{surface}{mixed}{ledger}{impacts}"


def _records_impacts(case: Case) -> bool:
    return case.kind == "multi-ball" and case.deck.impacts == "on"


def _keeps_ledger(case: Case) -> bool:
    return case.kind == "multi-ball" and case.deck.ledger == "on"


def most_ranks(case: Case) -> int:
    """Return the most ranks along the axis: each has a slab of at least two ball diameters."""
    if case.kind == "single-ball":
        return 1
    thinnest = 2.0 * THINNEST_SLAB * case.ball.radius_m
    return max(1, math.floor(case.mill.simulated_length_m / thinnest))


def ghost_factor(case: Case, ranks: int) -> float:
    """Return the work of a step over that without ghost balls, as the module derives it."""
    radius = case.ball.radius_m
    reach = 2.0 * radius + min(case.domain.skin_m, radius)
    return 1.0 + GHOST_SHARE * 2.0 * reach * ranks / case.mill.simulated_length_m


def step_time(case: Case, ranks: int) -> float:
    """Return the wall time of one step of a case on free cores [s], without correction."""
    wall = case.wall
    if case.kind == "single-ball":
        if wall.kind == "analytic":
            return ANALYTIC_STEP
        return MESH_STEP + TRIANGLE_STEP * wall.triangles
    ball_step = BALL_STEP[case.deck.surface, wall.kind]
    ball_step *= LEDGER if _keeps_ledger(case) else 1.0
    ball_step *= IMPACTS if _records_impacts(case) else 1.0
    beyond = max(1.0, case.ball.count / IN_CACHE)
    ball_step *= 1.0 + GROWTH[case.deck.surface] * math.log(beyond)
    return ball_step * case.ball.count * ghost_factor(case, ranks) / ranks


def run_time(case: Case, steps: int, ranks: int, rates: Rates = BUILT_IN) -> float:
    """Return the wall time of one run of the engine on free cores [s]."""
    return START + steps * step_time(case, ranks) * rates.correction(case)


def wall_time(case: Case, ranks: int, rates: Rates = BUILT_IN) -> float:
    """Return the wall time of a case on free cores, settling included [s].

    Args:
        ranks: MPI ranks, one core each; a single ball runs on one.
    """
    settle = case.time.settle_steps
    settling = run_time(case, settle, ranks, rates) if settle else 0.0
    return settling + run_time(case, case.time.steps, ranks, rates)


def memory_mb(case: Case, ranks: int, nodes: int = 1) -> int:
    """Return the memory that a case needs on each node [MB], in the engine or in the analysis."""
    balls = case.ball.count * ghost_factor(case, ranks)
    return math.ceil(STAGES_MB + (RANK_MB * ranks + BALL_MB * balls) / nodes)


def learned(folders: Iterable[Path], cpu: str) -> Rates:
    """Return the rates of the runs in these case folders that this processor made.

    What cannot be read counts for nothing: a prediction must not stop a run.
    """
    ratios: dict[str, list[float]] = {}
    for folder in folders:
        try:
            timing = read_object(folder / "timing.json", "")
            if timing["hardware"]["cpu"] == cpu:
                case = load_case(folder)
                path, ratio = path_of(case), _ratio(case, timing)
                ratios.setdefault(path, []).append(ratio)
        except (ValueError, KeyError, TypeError, ArithmeticError):
            continue
    return Rates({path: median(some) for path, some in ratios.items()})


def _ratio(case: Case, timing: Mapping[str, Any]) -> float:
    """Return the measured over predicted time of a particle-step."""
    ranks, rate = int(timing["ranks"]), float(timing["particle_steps_per_s_core"])
    ratio = case.ball.count / (step_time(case, ranks) * ranks * rate)
    if not 0.0 < ratio < math.inf:
        raise ValueError(f"no rate: {ratio}")
    return ratio
