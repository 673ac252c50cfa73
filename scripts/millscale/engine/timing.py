"""timing.json: cost, hardware and shares of the time of a run."""

from __future__ import annotations

from dataclasses import dataclass

from millscale.engine.attempts import Cost
from millscale.engine.deck_run import Spent
from millscale.engine.log import LoopTiming
from millscale.engine.machine import hardware


@dataclass(frozen=True)
class Before:
    """Steps of earlier starts of the engine: their number, their attempts, their cost."""

    steps: int
    attempts: int
    cost: Cost


def timing_record(stage: str, spent: Spent, loop: LoopTiming, before: Before) -> dict:
    """Return the content of timing.json.

    Args:
        spent: time from the start of mpirun to its end.
        loop: timing of the time loop in the engine's log.
        before: the steps before the last start of the engine.
    """
    cost = before.cost + Cost(
        spent.wall_time, spent.processor_time, loop.loop_time, loop.loop_time * loop.ranks
    )
    particle_steps = loop.particle_steps + before.steps * loop.balls
    return {
        "schema": 1,
        "stage": stage,
        "hardware": hardware(),
        "ranks": loop.ranks,
        "balls": loop.balls,
        "attempts": before.attempts + 1,
        "steps": loop.steps + before.steps,
        "particle_steps": particle_steps,
        "wall_time_s": cost.wall_time,
        "processor_time_s": cost.processor_time,
        "loop_time_s": cost.loop_time,
        "particle_steps_per_s_core": particle_steps / cost.core_time if cost.core_time else 0.0,
        "share": loop.share,
    }
