"""Plan of a campaign: its cases, their derived numbers and their cost."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from msgspec import to_builtins
from rich.console import Group
from rich.markup import escape
from rich.table import Table

from millscale.campaign.campaign import Campaign
from millscale.cases.case import cases_of
from millscale.cases.cost import wall_time
from millscale.cases.output_size import size_text
from millscale.engine.machine import CoreWish, available_cores
from millscale.formats import counted, duration
from millscale.runs.case_file import Case
from millscale.workflow.placement import makespan, place

Row = dict[str, Any]
# A longer table is not readable in a terminal.
MOST_ROWS = 200


def plan_rows(campaign: Campaign, ranks: int | None = None) -> list[Row]:
    """Return a row for each case; SI units, the unit at the end of each key.

    Args:
        ranks: MPI ranks of multi-ball cases, on any machine; None for those that `millscale run`
            would use on this one.
    """
    cases = cases_of(campaign)
    if ranks:
        return [_row(case, ranks if case.kind == "multi-ball" else 1) for case in cases]
    return rows_of(cases, campaign)


def rows_of(cases: Sequence[Case], campaign: Campaign) -> list[Row]:
    """Return `plan_rows` of some cases of a campaign, with the ranks of `millscale run` here."""
    usual = CoreWish(campaign.ranks, campaign.jobs)
    chosen = place(cases, CoreWish(), usual)
    return [_row(case, chosen.ranks[case.id], chosen.notes) for case in cases]


def _row(case: Case, ranks: int, notes: tuple[str, ...] = ()) -> Row:
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
        "predicted_wall_time_s": wall_time(case, ranks),
        "output_bytes": case.predicted.output_bytes,
        "warnings": [*case.warnings, *(notes if case.kind == "multi-ball" else ())],
        "model": to_builtins(case.model),
    }


def render_plan(rows: list[Row]) -> Group:
    """Return the plan for a terminal: cases, cost, warnings, what is modelled and left out."""
    table = Table(
        title=counted(len(rows), "case"),
        title_justify="left",
        caption_justify="left",
        box=None,
        pad_edge=False,
    )
    table.caption = (
        "dt/T_R: step over Rayleigh time; dt/limit: over the damping limit of the bed; "
        "dE: predicted energy ratio; time, disk: predicted"
    )
    for heading, _ in COLUMNS:
        table.add_column(heading, justify="left" if heading == "case" else "right", no_wrap=True)
    for row in rows[:MOST_ROWS]:
        table.add_row(*(escape(text(row)) for _, text in COLUMNS))
    more = len(rows) - MOST_ROWS
    return Group(
        table, f"and {more:,} more cases: --json lists all" if more > 0 else "", *_notes(rows)
    )


COLUMNS = (
    ("case", lambda row: row["id"]),
    ("R m", lambda row: f"{row['radius_m']:.4g}"),
    ("g m/s2", lambda row: f"{row['gravity_m_s2']:.4g}"),
    ("rad/s", lambda row: f"{row['omega_rad_s']:.4g}"),
    ("Fr", lambda row: f"{row['froude']:.3g}"),
    ("% crit", lambda row: f"{row['percent_of_critical']:.3g}"),
    ("dE", lambda row: f"{row['predicted_energy_ratio']:.3g}"),
    ("balls", lambda row: f"{row['balls']:,}"),
    ("dt s", lambda row: f"{row['time_step_s']:.2e}"),
    ("dt/T_R", lambda row: f"{row['rayleigh_fraction']:.3f}"),
    ("dt/limit", lambda row: f"{row['limit_fraction']:.2f}"),
    ("steps", lambda row: f"{row['steps']:,}"),
    ("ranks", lambda row: str(row["ranks"])),
    ("time", lambda row: duration(row["predicted_wall_time_s"])),
    ("disk", lambda row: size_text(row["output_bytes"])),
)


def _notes(rows: list[Row]) -> list[str]:
    """Return the lines below the table, which concern several cases."""
    notes = []
    for kind in dict.fromkeys(row["kind"] for row in rows):
        some = [row for row in rows if row["kind"] == kind]
        total = duration(sum(row["predicted_wall_time_s"] for row in some))
        widths = sorted({row["ranks"] for row in some})
        on = f", on {' or '.join(map(str, widths))} ranks" if widths != [1] else ""
        choices = ", ".join(dict.fromkeys(row["time_step_choice"] for row in some))
        disk = size_text(sum(row["output_bytes"] for row in some))
        notes.append(
            f"{kind}: {counted(len(some), 'case')}, {total} one after the other{on}, {disk}"
        )
        notes.append(escape(f"  time step {choices}"))
    loads = [(row["predicted_wall_time_s"], row["ranks"]) for row in rows]
    cores = available_cores()
    together = duration(makespan(loads, cores, cores))
    notes.append(f"together about {together} on {counted(cores, 'core')} of this machine")
    warned: dict[str, list[str]] = {}
    for row in rows:
        for text in row["warnings"]:
            warned.setdefault(text, []).append(row["id"])
    for warning, ids in warned.items():
        more = f" and {len(ids) - 1} more" if len(ids) > 1 else ""
        notes.append(f"[yellow]warning[/yellow] {escape(f'{ids[0]}{more}: {warning}')}")
    for side, title in (("in", "modelled"), ("out", "left out")):
        statements = dict.fromkeys(
            (entry["what"], entry["reason"]) for row in rows for entry in row["model"][side]
        )
        notes.append(f"{title}:")
        notes += [escape(f"  {what}: {reason}") for what, reason in statements]
    return notes
