"""timing.json: what a run cost, on which hardware, and where the time went."""

from __future__ import annotations

from mill_campaign.engine_log import LoopTiming
from mill_campaign.engine_run import Spent
from mill_campaign.machine import hardware


def timing_record(stage: str, spent: Spent, loop: LoopTiming) -> dict:
    """The content of timing.json.

    Args:
        spent: time from the start of mpirun to its end.
        loop: what the engine's log says of its time loop.
    """
    core_seconds = loop.loop_time * loop.ranks
    return {
        "schema": 1,
        "stage": stage,
        "hardware": hardware(),
        "ranks": loop.ranks,
        "balls": loop.balls,
        "steps": loop.steps,
        "particle_steps": loop.particle_steps,
        "wall_time_s": spent.wall_time,
        "processor_time_s": spent.processor_time,
        "loop_time_s": loop.loop_time,
        "particle_steps_per_s_core": loop.particle_steps / core_seconds if core_seconds else 0.0,
        "share": loop.share,
    }
