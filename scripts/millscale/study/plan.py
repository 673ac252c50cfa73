"""Predicted cost of a parameter study."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from textwrap import shorten
from typing import Any

from rich.console import Group
from rich.markup import escape
from rich.table import Table

from millscale.engine.machine import available_cores
from millscale.formats import counted, duration
from millscale.study.file import StudyFile
from millscale.workflow.placement import makespan
from millscale.workflow.plan import rows_of

Row = dict[str, Any]
ABOUT_WIDTH = 48


def study_plan(study: StudyFile, found: Mapping[str, Collection[str]]) -> list[Row]:
    """Return a row for each setting: its cases, their predicted time, and the cases left.

    Args:
        found: ids of the finished cases, by setting.
    """
    cores = available_cores()
    rows = []
    for setting in study.settings:
        cases = rows_of(setting.cases, setting.campaign)
        left = [row for row in cases if row["id"] not in found.get(setting.name, ())]
        loads = [(row["predicted_wall_time_s"], row["ranks"]) for row in left]
        jobs = min(setting.campaign.jobs or cores, cores)
        rows.append(
            {
                "setting": setting.name,
                "about": setting.about,
                "is_reference": setting.name == study.reference,
                "is_default": setting.name == study.default,
                "cases": cases,
                "left": [row["id"] for row in left],
                "core_time_s": sum(time * ranks for time, ranks in loads),
                "wall_time_s": makespan(loads, cores, jobs),
                "output_bytes": sum(row["output_bytes"] for row in left),
            }
        )
    return rows


def render(rows: list[Row]) -> Group:
    """Return the plan for a terminal."""
    table = Table(
        box=None, title_justify="left", title=counted(len(rows), "setting"), pad_edge=False
    )
    for heading in ("setting", "cases", "done", "balls", "dt s", "dt/limit", "core time", "about"):
        left = heading in ("setting", "about")
        wrapped = heading == "about"
        table.add_column(heading, justify="left" if left else "right", no_wrap=not wrapped)
    for row in rows:
        table.add_row(*map(escape, _cells(row)))
    cores = available_cores()
    core_hours = sum(row["core_time_s"] for row in rows) / 3600.0
    wall = duration(sum(row["wall_time_s"] for row in rows))
    notes = [
        f"predicted: {core_hours:.2f} core hours, {wall} on {counted(cores, 'core')} of this "
        "machine, one setting after the other"
    ]
    warned: dict[str, list[str]] = {}
    for row in rows:
        texts = list(dict.fromkeys(text for case in row["cases"] for text in case["warnings"]))
        if texts:
            more = f"; and {len(texts) - 1} more: --json lists all" if len(texts) > 1 else ""
            warned.setdefault(f"{texts[0]}{more}", []).append(row["setting"])
    notes += [
        f"[yellow]warning[/yellow] {escape(', '.join(of))}: {escape(text)}"
        for text, of in warned.items()
    ]
    return Group(table, *notes)


def _cells(row: Row) -> tuple[str, ...]:
    cases = row["cases"]
    role = " (reference)" * row["is_reference"] + " (default)" * row["is_default"]
    return (
        row["setting"] + role,
        str(len(cases)),
        str(len(cases) - len(row["left"])),
        _span([case["balls"] for case in cases], "{:,}"),
        _span([case["time_step_s"] for case in cases], "{:.3g}"),
        _span([case["limit_fraction"] for case in cases], "{:.2f}"),
        duration(row["core_time_s"]),
        shorten(row["about"], ABOUT_WIDTH, placeholder=" ..."),
    )


def _span(values: list[float], form: str) -> str:
    """Return the least and the largest of some values, or their common value."""
    ends = dict.fromkeys(form.format(value) for value in (min(values), max(values)))
    return " to ".join(ends)
