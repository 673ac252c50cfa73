"""The plan of a campaign in a terminal: the mill, its cases, their cost, warnings, details."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence

from rich.console import Group, RenderableType
from rich.markup import escape
from rich.table import Table

from millscale import _core
from millscale.campaign.campaign import Campaign
from millscale.cases.law import physical_liner
from millscale.cases.output_size import size_text
from millscale.cases.sections import physical_part
from millscale.engine.machine import available_cores
from millscale.formats import counted, duration
from millscale.packing.ball_sizes import mean_volume
from millscale.workflow.placement import makespan
from millscale.workflow.plan import Row

# A longer table is not readable in a terminal.
MOST_ROWS = 200
Columns = Sequence[tuple[str, Callable[[Row], str]]]
_NUMBER = re.compile(r"\d[\d.,e+-]*")
_SEED = re.compile(r"-seed\d+$")


def render_plan(
    campaign: Campaign, rows: list[Row], details: bool = False, jobs: int | None = None
) -> Group:
    """Return the plan for a terminal of 80 columns: the mill, its cases, their cost, warnings.

    Args:
        rows: of `plan_rows`.
        details: add every derived number, and what is modelled and left out.
        jobs: the most cases at a time; None for the campaign's.
    """
    shown: list[RenderableType] = [_mill(campaign, rows), ""]
    shown += _all_columns(rows) if details else _few_columns(rows)
    shown += ["", *_cost(rows, jobs or campaign.jobs)]
    if warned := _warnings(rows):
        shown += ["", warned]
    if details:
        shown += [*_power_models(rows), "", *_modelled(rows)]
    else:
        shown += ["", "--details: limits of the step, what is modelled and left out"]
    return Group(*shown)


def _mill(campaign: Campaign, rows: list[Row]) -> Table:
    """Return the physical mill: its size, speed and charge."""
    mill = physical_part(campaign)
    size = f"D {2.0 * mill.radius_m:.4g} m, L {mill.length_m:.4g} m inside the liner"
    if mill.lifters:
        height = 1e3 * (mill.radius_m - mill.lifter_top_radius_m)
        parts = (
            "lifters" if isinstance(physical_liner(campaign), _core.Lifters) else "pitches up to"
        )
        size += f"; {mill.lifters} {parts} {height:.3g} mm high"
    standing = _core.OperatingPoint(mill.radius_m, mill.ball_radius_m, mill.gravity_m_s2, 0.0)
    speed = (
        f"{mill.omega_rad_s * 30.0 / math.pi:.4g} rpm, "
        f"{100.0 * mill.omega_rad_s / _core.critical_speed(standing):.3g} % of critical, Fr "
        f"{_core.froude_number(mill.radius_m, mill.gravity_m_s2, mill.omega_rad_s):.3g}"
    )
    return _pairs([("mill", size), ("speed", speed), ("charge", _charge(campaign, rows))])


def _charge(campaign: Campaign, rows: list[Row]) -> str:
    size = f"{2e3 * campaign.ball.radius:.4g}"
    charges = [row for row in rows if row["kind"] == "multi-ball"]
    if charges and campaign.ball.classes:
        size = " + ".join(f"{2e3 * one.radius:.4g}" for one in campaign.ball.classes)
    ball = f"{size} mm, {campaign.ball.density:,.0f} kg/m^3"
    if not charges:
        return f"a single ball of {ball}"
    # The physical mill is filled as the largest of its scaled mills is.
    row = min(charges, key=lambda row: row["S"])
    part = next(part for part in campaign.parts if part.charge)
    assert part.charge  # as was asked for
    whole = row["length_m"] / row["simulated_length_m"] * row["S"] ** 3
    count = row["balls"] * whole
    if part.charge.counts:
        # A slice has whole balls, which `count` need not divide into.
        count = part.charge.counts[part.ratios.index(row["S"])] * row["S"] ** 3
    volume = physical_liner(campaign).area * campaign.mill.length
    solid = count * mean_volume(campaign.ball) / volume
    filling = part.charge.filling or solid / (1.0 - part.charge.porosity)
    mass = count * row["total_mass_kg"] / row["balls"]
    return f"J {filling:.3g}: {count:,.0f} balls, {1e-3 * mass:.4g} t, of {ball}"


def _pairs(pairs: Sequence[tuple[str, str]]) -> Table:
    """Return lines with a word before them; a long line continues below its begin."""
    grid = Table.grid(padding=(0, 2, 0, 0))
    for word, text in pairs:
        grid.add_row(word, escape(text))
    return grid


def _few_columns(rows: list[Row]) -> list[RenderableType]:
    """Return a row for all seeds of a mill; times are those of a case."""
    alike: dict[str, list[Row]] = {}
    for row in rows:
        alike.setdefault(_SEED.sub("", row["id"]), []).append(row)
    several = len(alike) < len(rows)
    columns: Columns = (
        ("case", lambda row: _SEED.sub("", row["id"])),
        *((("seeds", lambda row: str(len(alike[_SEED.sub("", row["id"])]))),) if several else ()),
        ("balls", lambda row: f"{row['balls']:,}"),
        ("step s", lambda row: f"{row['time_step_s']:.2g}"),
        ("steps", lambda row: _short_count(row["steps"])),
        ("ranks", lambda row: str(row["ranks"])),
        ("time", lambda row: duration(row["predicted_wall_time_s"])),
    )
    return _table([some[0] for some in alike.values()], columns)


def _short_count(count: int) -> str:
    for unit, factor in (("G", 1e9), ("M", 1e6), ("k", 1e3)):
        if count >= factor:
            return f"{count / factor:.3g} {unit}"
    return str(count)


def _all_columns(rows: list[Row]) -> list[RenderableType]:
    caption = (
        "dt/T_R: step over Rayleigh time; dt/limit: over the damping limit of the bed; "
        "dE: predicted energy ratio; time, disk: predicted"
    )
    return [*_table(rows, COLUMNS), caption]


def _table(rows: list[Row], columns: Columns) -> list[RenderableType]:
    table = Table(box=None, pad_edge=False)
    for heading, _ in columns:
        table.add_column(heading, justify="left" if heading == "case" else "right", no_wrap=True)
    for row in rows[:MOST_ROWS]:
        table.add_row(*(escape(text(row)) for _, text in columns))
    more = len(rows) - MOST_ROWS
    return [table, f"and {more:,} more cases: --json lists all"] if more > 0 else [table]


COLUMNS: Columns = (
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


def _cost(rows: list[Row], jobs: int | None) -> list[RenderableType]:
    """Return time, memory and disk of all cases, and how the step was chosen."""
    lines = []
    for kind in dict.fromkeys(row["kind"] for row in rows):
        some = [row for row in rows if row["kind"] == kind]
        total = duration(sum(row["predicted_wall_time_s"] for row in some))
        widths = sorted({row["ranks"] for row in some})
        on = f" on {' or '.join(map(str, widths))} ranks" if widths != [1] else ""
        choices = ", ".join(dict.fromkeys(row["time_step_choice"] for row in some))
        lines.append(f"{kind}: {counted(len(some), 'case')}, sum of their times {total}{on}")
        lines.append(f"  time step {choices}")
    loads = [(row["predicted_wall_time_s"], row["ranks"]) for row in rows]
    cores = available_cores()
    at_a_time = "" if jobs is None else f", {'one' if jobs == 1 else f'at most {jobs}'} at a time"
    together = duration(makespan(loads, cores, jobs or cores))
    disk = size_text(sum(row["output_bytes"] for row in rows))
    memory = size_text(1e6 * _memory_mb(rows, cores, jobs or cores))
    on = f"{counted(cores, 'core')} of this machine"
    lines.append(f"together about {together} on {on}{at_a_time}")
    lines.append(f"{memory} of memory at most, {disk} of disk")
    return [escape(line) for line in lines]


def _memory_mb(rows: list[Row], cores: int, jobs: int) -> float:
    """Return the memory of the largest cases that run at a time [MB]."""
    memory, free, running = 0.0, cores, 0
    for row in sorted(rows, key=lambda row: row["predicted_memory_mb"], reverse=True):
        if row["ranks"] <= free or free == cores:
            memory, free = memory + row["predicted_memory_mb"], free - row["ranks"]
            running += 1
        if free <= 0 or running == jobs:
            break
    return memory


def _warnings(rows: list[Row]) -> Table | None:
    """Return each warning once; those that differ in their numbers alone by the first of them."""
    alike: dict[str, dict[str, list[str]]] = {}
    for row in rows:
        for text in row["warnings"]:
            wording = _NUMBER.sub("", text)
            alike.setdefault(wording, {}).setdefault(text, []).append(row["id"])
    if not alike:
        return None
    grid = Table.grid(padding=(0, 1, 0, 0))
    for warned in alike.values():
        text, first = next(iter(warned.items()))
        concerned = sum(map(len, warned.values()))
        who = "" if len(first) == len(rows) else f"{first[0]}: "
        if concerned > 1 and who:
            who = f"{first[0]} and {concerned - 1} more: "
        grid.add_row("[yellow]warning[/yellow]", escape(f"{who}{text}"))
    return grid


def _power_models(rows: list[Row]) -> list[RenderableType]:
    """Return the power of the physical mill by published models; nothing for a single ball."""
    charged = [row for row in rows if row["power_models"]]
    if not charged:
        return []
    grid = Table.grid(padding=(0, 2, 0, 0))
    for model in min(charged, key=lambda row: row["S"])["power_models"]:
        power = "none" if model["power_w"] is None else f"{1e-3 * model['power_w']:.4g} kW"
        outside = "; ".join(model["outside_of"])
        at = f"at the {model['measured_at']}" + (f"; outside: {outside}" if outside else "")
        grid.add_row("", model["name"], power, escape(at))
    return ["", "power of the physical mill by published models:", grid]


def _modelled(rows: list[Row]) -> list[RenderableType]:
    shown: list[RenderableType] = []
    for side, title in (("in", "modelled"), ("out", "left out")):
        statements = dict.fromkeys(
            (entry["what"], entry["reason"]) for row in rows for entry in row["model"][side]
        )
        shown.append(f"{title}:")
        grid = Table.grid(padding=(0, 2, 0, 0))
        for what, reason in statements:
            grid.add_row("", escape(f"{what}: {reason}"))
        shown.append(grid)
    return shown
