"""Run time of scaled mills (Table 10), and their errors against it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from millscale.analysis.charge.scaled_mills import MillName
from millscale.analysis.charge.speed_error import SHOWN, MillRow
from millscale.analysis.measures import ErrorColumn
from millscale.analysis.paper import numbers as paper
from millscale.report.figures.style import STYLE, colour_of_S, plain_log_ticks

# By scheme and stiffness; the colour is that of S, as in every figure.
MARKS = {
    ("constant-gravity", "fixed"): "o",
    ("constant-gravity", "overlap-matched"): "D",
    ("constant-speed", "fixed"): "s",
    ("constant-speed", "overlap-matched"): "^",
}
OTHER_MARK = "v"
NEUTRAL = "#444"


def speed_against_error(mills: Sequence[MillRow]) -> Figure:
    """Return each error that was measured, against time. Bars: standard deviation over seeds;
    crosses: the same error between two seeds of the mill. An error no larger than those may be
    chance.

    Args:
        mills: of `speed_error.mill_rows`.
    """
    panels = [x for x in SHOWN if any(mill.errors[x.name].mean is not None for mill in mills)]
    panels = panels or list(SHOWN)
    rows = math.ceil(len(panels) / 2)
    with rc_context(STYLE):
        figure = Figure(figsize=(7.6, 1.0 + 2.4 * rows), layout="constrained")
        grid = figure.subplots(rows, 2, squeeze=False).ravel()
        all_axes = grid[: len(panels)]
        for axes in grid[len(panels) :]:
            axes.remove()
        for axes, error in zip(all_axes, panels, strict=True):
            _error_panel(axes, mills, error)
            axes.set_ylabel(error.heading)
            axes.set_xscale("log")
            plain_log_ticks(axes.xaxis)
            if not error.signed:
                axes.set_ylim(0.0, error.same or None)
        for axes in all_axes[-2:]:
            axes.set_xlabel("processor time [s]")
        known = {}
        for axes in all_axes:
            for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
                known.setdefault(label, handle)
        if known:
            figure.legend(known.values(), known.keys(), loc="outside upper center", ncols=3)
    return figure


def run_times(mills: Sequence[MillRow], of_paper: bool = True) -> Figure:
    """Return time against the number of balls (Table 10); the paper's is the wall time of 20 s.

    Args:
        of_paper: whether the mill is the paper's.
    """
    with rc_context(STYLE):
        figure = Figure(figsize=(4.8, 3.6), layout="constrained")
        axes = figure.add_subplot()
        for key, group in _by_look(mills).items():
            points = sorted((mill.balls, mill.time_s / 3600.0) for mill in group)
            axes.plot(*zip(*points, strict=True), ls="-", lw=0.8, label=_name(key), **_look(key))
            for mill in group:
                axes.plot(
                    mill.balls, mill.time_s / 3600.0, ls="none", **_look(mill.name, mill.name.S)
                )
        if of_paper:
            reported = paper.table("table10_wall_time")
            axes.plot(
                [row["particles"] for row in reported],
                [row["elapsed_h"] for row in reported],
                "x--",
                color=NEUTRAL,
                lw=0.8,
                label="the paper, 20 s",
            )
        axes.set(xscale="log", yscale="log", xlabel="balls", ylabel="processor time [h]")
        for axis in (axes.xaxis, axes.yaxis):
            plain_log_ticks(axis)
        axes.legend()
    return figure


def _error_panel(axes: Axes, mills: Sequence[MillRow], error: ErrorColumn) -> None:
    name, factor = error.name, error.factor
    known = [mill for mill in mills if mill.errors[name].mean is not None]
    if not known:
        axes.text(0.5, 0.5, "not measured", transform=axes.transAxes, ha="center", color="#777")
        return
    for key, group in _by_look(known).items():
        time = [mill.time_s for mill in group]
        values = [factor * mill.errors[name].mean for mill in group]
        bars = [factor * (mill.errors[name].deviation or 0.0) for mill in group]
        axes.errorbar(
            time, values, bars, ls="none", ms=5.5, capsize=3, label=_name(key), **_look(key)
        )
        for mill, x, y in zip(group, time, values, strict=True):
            axes.plot(x, y, ls="none", ms=5.5, **_look(mill.name, mill.name.S))
            axes.annotate(
                f"{mill.name.S:.4g}", (x, y), xytext=(5, 4), textcoords="offset points",
                fontsize=7.5,
            )  # fmt: skip
    between = [(mill.time_s, mill.errors[name].between_seeds) for mill in known]
    points = [(time, factor * value) for time, value in between if value is not None]
    if points:
        axes.plot(*zip(*points, strict=True), "x", color="#777", ms=5, label="between two seeds")


def _by_look(mills: Sequence[MillRow]) -> dict[MillName, list[MillRow]]:
    """Return the mills of each campaign, scheme, policy and stiffness, whatever their S."""
    groups: dict[MillName, list[MillRow]] = {}
    for mill in mills:
        groups.setdefault(mill.name._replace(S=0.0), []).append(mill)
    return groups


def _look(name: MillName, S: float | None = None) -> dict[str, Any]:
    """Return mark and colour: of an S, or of a legend of all S. Policies other than the paper's are
    hollow."""
    colour = NEUTRAL if S is None else colour_of_S(S)
    hollow = {} if name.policy == "paper" else {"mfc": "white"}
    mark = MARKS.get((name.scheme, name.stiffness), OTHER_MARK)
    return {"marker": mark, "color": colour, "zorder": 3} | hollow


def _name(name: MillName) -> str:
    policy = "" if name.policy == "paper" else f", {name.policy}"
    matched = "" if name.stiffness == "fixed" else ", E matched"
    return name.scheme.replace("-", " ") + policy + matched
