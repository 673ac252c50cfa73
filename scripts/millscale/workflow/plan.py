"""Plan of a campaign: its cases, their derived numbers and their cost."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from msgspec import to_builtins

from millscale.campaign.campaign import Campaign
from millscale.cases.case import cases_of
from millscale.cases.cost import memory_mb, wall_time
from millscale.cases.slips import slips_of
from millscale.engine.machine import CoreWish
from millscale.power_models import models_for
from millscale.runs.case_file import Case
from millscale.runs.soft_balls import impact_overlap
from millscale.workflow.placement import OPEN, place

Row = dict[str, Any]


def plan_rows(campaign: Campaign, asked: CoreWish = OPEN) -> list[Row]:
    """Return a row for each case; SI units, the unit at the end of each key.

    Args:
        asked: as options of `millscale run`, which decide the ranks.
    """
    return rows_of(cases_of(campaign), campaign, asked)


def rows_of(cases: Sequence[Case], campaign: Campaign, asked: CoreWish = OPEN) -> list[Row]:
    """Return `plan_rows` of some cases of a campaign, with the ranks of `millscale run` here."""
    usual = CoreWish(campaign.ranks, campaign.jobs)
    chosen = place(cases, asked, usual)
    return _rows(cases, [chosen.ranks[case.id] for case in cases], chosen.notes)


def _rows(cases: Sequence[Case], ranks: Sequence[int], notes: tuple[str, ...] = ()) -> list[Row]:
    times = [wall_time(case, some) for case, some in zip(cases, ranks, strict=True)]
    slips = slips_of(cases, times)
    rows = []
    for case, some, time in zip(cases, ranks, times, strict=True):
        row = _row(case, some, time)
        row["warnings"] += slips.get(case.id, [])
        row["warnings"] += notes if case.kind == "multi-ball" else ()
        rows.append(row)
    return rows


def _row(case: Case, ranks: int, wall_time_s: float) -> Row:
    mill, time, ball = case.mill, case.time, case.ball
    steps = time.settle_steps + time.steps
    same_in_mill = (
        "radius_m", "lifter_top_radius_m", "lifter_top_width_m", "groove_width_m", "length_m",
        "simulated_length_m", "face_angle_deg", "gravity_m_s2", "omega_rad_s", "froude",
        "percent_of_critical", "detach_angle_deg", "regime",
    )  # fmt: skip
    same_in_time = (
        "rotation_angle_rad", "rayleigh_fraction", "limit_fraction", "steps_per_contact",
    )  # fmt: skip
    return {
        **{key: getattr(case, key) for key in ("id", "kind", "scheme", "policy", "S", "seed")},
        **{key: getattr(mill, key) for key in same_in_mill},
        "balls": ball.count,
        "total_mass_kg": ball.count * ball.mass_kg,
        "youngs_modulus_pa": case.material.youngs_modulus_pa,
        "time_step_s": time.step_s,
        "time_step_choice": time.step_choice,
        "steps": steps,
        **{key: getattr(time, key) for key in same_in_time},
        "predicted_energy_ratio": case.predicted_energy_ratio,
        "centre_path_energy_ratio": case.centre_path_energy_ratio,
        "groups": to_builtins(case.groups),
        "particle_steps": ball.count * steps,
        "ranks": ranks,
        "predicted_wall_time_s": wall_time_s,
        "predicted_memory_mb": memory_mb(case, ranks),
        "impact_overlap_over_ball_radius": impact_overlap(case),
        "output_bytes": case.predicted.output_bytes,
        "power_models": [asdict(row) for row in models_for(case)],
        "warnings": [*case.warnings],
        "model": to_builtins(case.model),
    }
