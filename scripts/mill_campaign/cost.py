"""How long a case will take, from measured costs of the stock engine on one EPYC Zen 4 core."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

# A single ball in a turning mesh: the engine moves every triangle at every step. Time of a step,
# and of each triangle in it [s], fitted to 300, 350, 450 and 750 triangles.
SINGLE_BALL_STEP = 24e-6
TRIANGLE_STEP = 0.38e-6
# With the analytic wall and a sample every 0.005 rad; 1.5e-6 without samples, on a free core [s].
ANALYTIC_STEP = 4.6e-6
# A settled, rotating charge of 13,370 to 231,461 balls in axis-long panels, skin 15 mm [s per
# particle-step and core]: on one rank, and on ranks cut along the axis.
PARTICLE_STEP_ALONE = 351e-9
PARTICLE_STEP_SHARED = 434e-9
# Whole runs, with filling, output and a bed in motion, over the rates above: 258 to 267 ns per
# particle-step on two ranks instead of 217.
WHOLE_RUN = 1.2


# Slabs thinner than this, in mean ball diameters, hold more ghost balls than balls of their own.
THINNEST_SLAB = 2.0


def most_ranks(cases: Iterable[Mapping[str, Any]]) -> int:
    """Ranks that every charge among the cases can be cut into along the axis; 1 without charges."""
    slabs = [
        case["mill"]["simulated_length_m"] / (2.0 * THINNEST_SLAB * case["ball"]["radius_m"])
        for case in cases
        if case["kind"] == "multi-ball"
    ]
    return max(1, math.floor(min(slabs, default=1.0)))


def wall_time(kind: str, balls: int, triangles: int, steps: int, ranks: int) -> float:
    """Predicted wall time of a case on free cores [s].

    Args:
        kind: "single-ball" (runs on one rank, whatever `ranks`) or "multi-ball".
        balls: in the case.
        triangles: the engine turns; 0 with the analytic wall.
        steps: time steps in all.
        ranks: MPI ranks, one core each.
    """
    if kind == "single-ball":
        step = SINGLE_BALL_STEP + TRIANGLE_STEP * triangles if triangles else ANALYTIC_STEP
        return steps * step
    particle_step = PARTICLE_STEP_ALONE if ranks == 1 else PARTICLE_STEP_SHARED
    return WHOLE_RUN * particle_step * balls * steps / ranks
