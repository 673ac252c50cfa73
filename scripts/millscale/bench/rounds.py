"""Interleaved runs of several engines on one state, and the medians of their times."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from millscale.bench.engines import Phases, Variant, time_run
from millscale.bench.state import State


@dataclass(frozen=True)
class Plan:
    """Ranks and steps of a run, and `repeats` rounds with one run of each engine."""

    ranks: int
    warm_steps: int
    steps: int
    repeats: int


def interleaved(
    variants: Sequence[Variant],
    state: State,
    plan: Plan,
    folder: Path,
    show: Callable[[str], None] = lambda line: None,
) -> list[list[Phases]]:
    """Return the phases of every variant, `plan.repeats` each, in the order of `variants`.

    A busy machine slows all engines of a round alike, so ratios are taken within rounds.
    """
    runs: list[list[Phases]] = [[] for _ in variants]
    for turn in range(plan.repeats):
        for index, variant in enumerate(variants):
            phases = time_run(
                variant, state, plan.ranks, plan.warm_steps, plan.steps, folder / str(index)
            )
            runs[index].append(phases)
            show(
                f"round {turn + 1}/{plan.repeats} {variant.engine} ({variant.wall} wall, "
                f"{variant.pair} pair, {variant.step} step): "
                f"{phases.total:.0f} ns per ball, step and core"
            )
    return runs


def ratio_of_medians(first: Sequence[float], second: Sequence[float]) -> float:
    """Return the median over the rounds of first / second."""
    return statistics.median(a / b for a, b in zip(first, second, strict=True))


def rows(
    scene: str, variants: Sequence[Variant], state: State, plan: Plan, runs: list[list[Phases]]
) -> list[dict]:
    """Return a row for each engine; a ratio to the variant `liggghts` above 1 is faster."""
    stock = next(i for i, variant in enumerate(variants) if variant.engine == "liggghts")
    reference = [phases.total for phases in runs[stock]]
    table = []
    for variant, phases in zip(variants, runs, strict=True):
        each = [p.total for p in phases]
        table.append(
            {
                "scene": scene,
                "engine": variant.engine,
                "wall": variant.wall,
                "pair": variant.pair,
                "balls": state.balls,
                "ranks": plan.ranks,
                "steps": plan.steps,
                "ns_per_particle_step_core": {
                    "median": statistics.median(each),
                    "min": min(each),
                    "max": max(each),
                },
                "ratio_to_liggghts": ratio_of_medians(reference, each),
                "split_ns": {
                    name: statistics.median(asdict(p)[name] for p in phases)
                    for name in ("pair", "neigh", "comm", "other")
                    if phases[0].pair is not None
                },
                "time_loop": phases[0].time_loop,
                "repeats": each,
            }
        )
    return table
