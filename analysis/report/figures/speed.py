"""Run time of the models (Table 10), and what speed costs in error."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from millscale.analysis.paper import numbers as paper
from millscale.report.figures.style import STYLE, plain_log_ticks

# Colour-blind safe (Okabe and Ito), and told apart by the mark as well.
LOOKS = {
    ("constant-gravity", "fixed"): {"marker": "o", "color": "#0072b2"},
    ("constant-gravity", "overlap-matched"): {"marker": "D", "color": "#56b4e9"},
    ("constant-speed", "fixed"): {"marker": "s", "color": "#d55e00"},
    ("constant-speed", "overlap-matched"): {"marker": "^", "color": "#e69f00"},
}
OTHER_LOOK = {"marker": "v", "color": "#009e73"}
PANELS = (
    ("contour_error_mean", "contour, mean [% of R - a]", 100.0),
    ("contour_error_max", "contour, largest [% of R - a]", 100.0),
    ("curtain_iou_upper", "curtains, upper ends: overlap", 1.0),
    ("curtain_iou_lower", "curtains, lower ends: overlap", 1.0),
    ("massflow_rms", "mass in the box, RMS [% of total]", 100.0),
    ("power_error", "power / M g R ω, error [%]", 100.0),
)

Row = dict[str, Any]


def speed_against_error(models: Sequence[Row]) -> Figure:
    """Each error that was measured, against time. Bars: standard deviation over seeds; crosses: the
    same error between two seeds of the model, below which a difference says nothing.

    Args:
        models: of `speed_error.model_rows`.
    """
    panels = [p for p in PANELS if any(row[p[0]] is not None for row in models)] or PANELS
    rows = math.ceil(len(panels) / 2)
    with rc_context(STYLE):
        figure = Figure(figsize=(7.6, 1.0 + 2.4 * rows), layout="constrained")
        grid = figure.subplots(rows, 2, squeeze=False).ravel()
        all_axes = grid[: len(panels)]
        for axes in grid[len(panels) :]:
            axes.remove()
        for axes, (name, title, factor) in zip(all_axes, panels, strict=True):
            _error_panel(axes, models, name, factor)
            axes.set_ylabel(title)
            axes.set_xscale("log")
            plain_log_ticks(axes.xaxis)
            if name != "power_error":
                axes.set_ylim(0.0, 1.0 if "iou" in name else None)
        for axes in all_axes[-2:]:
            axes.set_xlabel("processor time [s]")
        known = {}
        for axes in all_axes:
            for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
                known.setdefault(label, handle)
        if known:
            figure.legend(known.values(), known.keys(), loc="outside upper center", ncols=3)
    return figure


def run_times(models: Sequence[Row], of_paper: bool = True) -> Figure:
    """Time against the number of balls (Table 10); the paper's is wall time of 20 s of the mill.

    Args:
        of_paper: whether the mill is the paper's.
    """
    with rc_context(STYLE):
        figure = Figure(figsize=(4.8, 3.6), layout="constrained")
        axes = figure.add_subplot()
        for key, group in _by_look(models).items():
            points = sorted((row["balls"], _time(row) / 3600.0) for row in group)
            axes.plot(*zip(*points, strict=True), ls="-", lw=0.8, label=_name(key), **_look(key))
        if of_paper:
            reported = paper.table("table10_wall_time")
            axes.plot(
                [row["particles"] for row in reported],
                [row["elapsed_h"] for row in reported],
                "x--",
                color="#444",
                lw=0.8,
                label="the paper, 20 s",
            )
        axes.set(xscale="log", yscale="log", xlabel="balls", ylabel="processor time [h]")
        for axis in (axes.xaxis, axes.yaxis):
            plain_log_ticks(axis)
        axes.legend()
    return figure


def _error_panel(axes: Axes, models: Sequence[Row], name: str, factor: float) -> None:
    known = [row for row in models if row[name] is not None]
    if not known:
        axes.text(0.5, 0.5, "not measured", transform=axes.transAxes, ha="center", color="#777")
        return
    for key, group in _by_look(known).items():
        time = [_time(row) for row in group]
        error = [factor * row[name] for row in group]
        bars = [factor * (row["spread"][name] or 0.0) for row in group]
        axes.errorbar(
            time, error, bars, ls="none", ms=5.5, capsize=3, label=_name(key), **_look(key)
        )
        for row, x, y in zip(group, time, error, strict=True):
            axes.annotate(
                f"{row['S']:.4g}", (x, y), xytext=(5, 4), textcoords="offset points", fontsize=7.5
            )
    noise = [(_time(r), factor * r["noise"][name]) for r in known if _told(r, name)]
    if noise:
        axes.plot(*zip(*noise, strict=True), "x", color="#777", ms=5, label="between two seeds")


def _time(row: Row) -> float:
    """Of the processor, which a shared machine lengthens less, or else wall time [s]."""
    return row["processor_time_s"] or row["wall_time_s"]


def _told(row: Row, name: str) -> bool:
    return row["noise"][name] is not None


def _by_look(models: Sequence[Row]) -> dict[tuple[str, str, str], list[Row]]:
    groups: dict[tuple[str, str, str], list[Row]] = {}
    for row in models:
        groups.setdefault((row["campaign"], row["scheme"], row["stiffness"]), []).append(row)
    return groups


def _look(key: tuple[str, str, str]) -> dict[str, Any]:
    return LOOKS.get(key[1:], OTHER_LOOK)


def _name(key: tuple[str, str, str]) -> str:
    matched = "" if key[2] == "fixed" else ", E matched"
    return key[1].replace("-", " ") + matched
