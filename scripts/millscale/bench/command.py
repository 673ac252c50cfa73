"""`millscale bench`: prepare the mill, time the engines, tabulate the results."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.table import Table

from millscale.bench.ball import ball_speedup, mesh_convergence
from millscale.bench.charge_means import SLICES, WALLS
from millscale.bench.charge_means import compared as means_of
from millscale.bench.earlier import compared, read_earlier
from millscale.bench.engines import (
    ANALYTIC_WALL_ONLY,
    BARE,
    BARE_MIXED,
    CAMPAIGN,
    CAMPAIGN_MIXED,
    LAMMPS,
    LIGGGHTS,
    MILLSCALE,
    MIXED,
    YADE,
    Phases,
    Variant,
)
from millscale.bench.machine_kind import machine_kind
from millscale.bench.rounds import Plan, interleaved, ratio_of_medians, rows
from millscale.bench.scenes import CASE, SCENES, SIZES, Scene, prepare
from millscale.bench.size_figure import draw_sizes
from millscale.engine.record import provenance
from millscale.errors import CampaignError

WARM_STEPS = 200
REPEATS = 3  # of one ball
QUICK_ROUNDS = 5
DRUM_SCENE = "drum"
WALL, SLICE, SIZE = "wall", "slices", "size"


def bench(
    scene_name: str, quick: bool, runs: Path, console: Console, earlier: Path | None = None
) -> dict:
    """Return rows and provenance of one scene.

    Args:
        earlier: result to compare with.

    Raises:
        CampaignError: no such scene, or none that can be compared.
        RunFolderError: the earlier result is damaged, or of another scene or kind of machine.
    """
    if earlier is None:
        return _measured(scene_name, quick, runs, console)
    if scene_name not in (*SCENES, SIZE):
        known = ", ".join((*SCENES, SIZE))
        raise CampaignError("millscale bench", "--compare", f"got scene {scene_name}", known)
    before = read_earlier(earlier, scene_name)
    result = _measured(scene_name, quick, runs, console)
    return result | {"compared": compared(result["rows"], before, earlier)}


def _measured(scene_name: str, quick: bool, runs: Path, console: Console) -> dict:
    if scene_name == WALL:
        return _walls(runs, console)
    if scene_name == SLICE:
        return {
            "schema": 1,
            "slices": means_of(SLICES, runs, console),
            "provenance": provenance(),
        }
    if scene_name == SIZE:
        return _sizes(runs, console)
    if scene_name == CASE.name:
        return _campaign_step(quick, runs, console)
    if scene_name not in SCENES:
        known = ", ".join((*SCENES, WALL, SLICE, SIZE, CASE.name))
        raise CampaignError("millscale bench", "--scene", f"got {scene_name}", known)
    scene = SCENES[scene_name]
    state = prepare(scene, runs, console)
    variants: tuple[Variant, ...] = (MILLSCALE, MIXED, LIGGGHTS)
    if scene.name == DRUM_SCENE and not quick:
        variants += (LAMMPS, YADE)
    plan = _plan(scene, quick)
    timed = interleaved(variants, state, plan, runs / "timed", console.print)
    return {
        "schema": 1,
        "machine_kind": machine_kind(),
        "rows": rows(scene.name, variants, state, plan, timed),
        "provenance": provenance(),
    }


def _campaign_step(quick: bool, runs: Path, console: Console) -> dict:
    """Return the time of a step of a campaign over that of the bare step, for each precision."""
    state = prepare(CASE, runs, console)
    plan = _plan(CASE, quick)
    variants = (BARE, CAMPAIGN, BARE_MIXED, CAMPAIGN_MIXED)
    timed = interleaved(variants, state, plan, runs / "timed", console.print)
    pairs = {"double": timed[:2], "mixed": timed[2:]}
    return {
        "schema": 1,
        "machine_kind": machine_kind(),
        "balls": state.balls,
        "ranks": plan.ranks,
        "steps": plan.steps,
        "campaign_step": {
            precision: campaign_over_bare(bare, campaign)
            for precision, (bare, campaign) in pairs.items()
        },
        "provenance": provenance(),
    }


def campaign_over_bare(bare: Sequence[Phases], campaign: Sequence[Phases]) -> dict:
    """Return the ratio of the times of both steps, round by round [ns per ball, step and core]."""
    times = [[phases.total for phases in runs] for runs in (bare, campaign)]
    return {
        "ratio": ratio_of_medians(times[1], times[0]),
        "bare_ns": times[0],
        "campaign_ns": times[1],
        "bare_time_loop": bare[0].time_loop,
        "campaign_time_loop": campaign[0].time_loop,
    }


def _sizes(runs: Path, console: Console) -> dict:
    """Return the cost against the number of balls on one and two ranks; draw its figure."""
    variants = (MILLSCALE, MIXED, LIGGGHTS)
    table = []
    for size in SIZES:
        state = prepare(size, runs, console)
        # Both numbers of ranks in each round: the pace of the machine changes between rounds.
        plans = [Plan(ranks, WARM_STEPS, size.steps, 1) for ranks in (1, 2)]
        timed: list[list[list[Phases]]] = [[[] for _ in variants] for _ in plans]
        for turn in range(size.rounds):
            console.print(f"{size.case}: round {turn + 1}/{size.rounds}")
            for plan, so_far in zip(plans, timed, strict=True):
                once = interleaved(variants, state, plan, runs / "timed", console.print)
                for runs_of_one, (phases,) in zip(so_far, once, strict=True):
                    runs_of_one.append(phases)
        for plan, found in zip(plans, timed, strict=True):
            table += rows(SIZE, variants, state, plan, found)
    picture = runs / "cost-against-size.png"
    draw_sizes(table, picture)
    console.print(f"picture: {picture}")
    return {
        "schema": 1,
        "machine_kind": machine_kind(),
        "rows": table,
        "provenance": provenance(),
    }


def _walls(runs: Path, console: Console) -> dict:
    """Return the speed-up by the analytic wall, for a single ball and the mill at S = 2.6."""
    scene = SCENES["s2.6"]
    state = prepare(scene, runs, console)
    variants = (LIGGGHTS, MILLSCALE, ANALYTIC_WALL_ONLY)
    plan = _plan(scene, quick=False)
    mesh, ours, wall_only = timed = interleaved(
        variants, state, plan, runs / "timed", console.print
    )
    return {
        "schema": 1,
        "single_ball_speedup": ball_speedup(REPEATS, runs, console),
        "multi_ball_wall_speedup": {
            "of": "time outside pair and neighbour list, ns per ball, step and core",
            **_wall_speedup(ours, mesh),
            "with_stock_contacts": _wall_speedup(wall_only, mesh),
        },
        "mesh_convergence": mesh_convergence(runs, console),
        "charge_on_both_walls": means_of(WALLS, runs, console),
        "rows": rows(scene.name, variants, state, plan, timed),
        "provenance": provenance(),
    }


def _plan(scene: Scene, quick: bool) -> Plan:
    if quick:
        return Plan(scene.ranks, WARM_STEPS, scene.quick_steps, QUICK_ROUNDS)
    return Plan(scene.ranks, WARM_STEPS, scene.steps, scene.rounds)


def _wall_speedup(analytic, mesh) -> dict:
    """Return the ratio of times outside pair and neighbour list, mesh over analytic wall."""
    of_mesh = [phases.outside_pair_and_neigh for phases in mesh]
    of_analytic = [phases.outside_pair_and_neigh for phases in analytic]
    return {
        "ratio": ratio_of_medians(of_mesh, of_analytic),
        "mesh_ns": of_mesh,
        "analytic_ns": of_analytic,
    }


def table(result: dict) -> Table:
    """Return the rows as a table for a terminal."""
    shown = Table(
        "engine",
        "wall",
        "pair",
        "balls",
        "ranks",
        "ns per ball, step, core",
        "of stock",
        "split",
        "time loop",
    )
    for row in result["rows"]:
        each = row["ns_per_particle_step_core"]
        shown.add_row(
            row["engine"],
            row["wall"],
            row["pair"],
            f"{row['balls']:,}",
            str(row["ranks"]),
            f"{each['median']:.0f} ({each['min']:.0f} to {each['max']:.0f})",
            f"{row['ratio_to_liggghts']:.2f} x",
            ", ".join(f"{name} {ns:.0f}" for name, ns in row["split_ns"].items()),
            row["time_loop"] or "",
        )
    return shown


def text(result: dict) -> str:
    return json.dumps(result, indent=1, allow_nan=False)
