"""timing.json: what a run cost, on which hardware, and where the time went."""

from __future__ import annotations

from dataclasses import dataclass

from millscale.engine.attempts import Cost
from millscale.engine.deck_run import Spent
from millscale.engine.log import LoopTiming
from millscale.engine.machine import hardware


@dataclass(frozen=True)
class Before:
    """The steps that earlier starts of the engine made: how many, in how many attempts, at what
    cost."""

    steps: int
    attempts: int
    cost: Cost


def timing_record(stage: str, spent: Spent, loop: LoopTiming, before: Before) -> dict:
    """The content of timing.json.

    Args:
        spent: time from the start of mpirun to its end.
        loop: what the engine's log says of its time loop.
        before: the same of the steps before the last start of the engine.
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
