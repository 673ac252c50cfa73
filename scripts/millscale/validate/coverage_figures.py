"""Speed against error of single scaled mills and of predictions; errors over half widths."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, NullFormatter

from millscale.campaign.keys import FRICTION_MATCHED
from millscale.report.figures.style import STYLE

# Colour-blind safe (Okabe and Ito); the mark differs as well.
LOOKS: dict[str, dict[str, Any]] = {
    "paper": {"marker": "o", "color": "#0072b2"},
    "friction-matched": {"marker": "s", "color": "#d55e00"},
}
OTHER_LOOK: dict[str, Any] = {"marker": "v", "color": "#009e73"}
PANELS = (
    ("contour_mean", "surface contour: mean error [% of R - a]"),
    ("power", "power: error [%]"),
)
FARTHEST = 4.0  # error over half width that is still drawn in its place
MEAN_OVER_DEVIATION = np.sqrt(2.0 / np.pi)  # of the size of a normal variable


def draw_speed(content: Mapping[str, Any], file: Path) -> Figure:
    """Draw error against processor time, a panel for the contour and one for the power.

    Lines: single scaled mills. Filled marks: predictions from two of them. Dotted: what chance
    leaves of shorter slices of S = 1.

    Args:
        content: of `coverage.try_predictions`.
    """
    with rc_context(STYLE):
        figure = Figure(figsize=(9.2, 4.6), layout="constrained")
        every = figure.subplots(1, len(PANELS))
        for axes, (name, label) in zip(every, PANELS, strict=True):
            for mill in content["mills"]:
                trials = [x for x in content["trials"] if x["mill"] == mill["name"]]
                with_S = len(content["mills"]) == 1
                _singles(axes, mill, name, with_S)
                _predictions(axes, mill, trials, name, with_S)
                _slice_of_1(axes, mill, name)
            axes.set_xscale("log")
            axes.set_yscale("log")
            axes.set_xlabel("processor time / that of a slice of S = 1")
            axes.set_ylabel(label)
            for axis in (axes.xaxis, axes.yaxis):
                axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0), numticks=12))
                axis.set_major_formatter("{x:g}")
                axis.set_minor_formatter(NullFormatter())
            _whole_mill_axis(axes, content["mills"])
        known: dict[str, Any] = {}
        for axes in every:
            for handle, text in zip(*axes.get_legend_handles_labels(), strict=True):
                known.setdefault(text, handle)
        known["bar to the half width of the interval"] = Line2D([], [], color="#777", lw=1.0,
                                                               marker="_", ms=8)  # fmt: skip
        figure.legend(known.values(), known.keys(), loc="outside upper center", ncols=3)
        figure.savefig(file, dpi=150)
    return figure


def _singles(axes: Axes, mill: Mapping[str, Any], name: str, with_S: bool) -> None:
    groups: dict[tuple[str, str], list[Mapping[str, Any]]] = {}
    for row in mill["singles"]:
        if name in row["errors"]:
            groups.setdefault((row["scheme"], row["policy"]), []).append(row)
    for (_, policy), rows in groups.items():
        look = LOOKS.get(policy, OTHER_LOOK)
        places = [row["cost_s"] / mill["cost_s"] for row in rows]
        errors = [row["errors"][name]["error"] for row in rows]
        axes.plot(places, errors, ls="-", lw=0.9, ms=5, mfc="white", label=f"one mill, {policy}",
                  alpha=1.0 if with_S else 0.4, **look)  # fmt: skip
        if with_S:
            for row, x, y in zip(rows, places, errors, strict=True):
                axes.annotate(f"S = {row['S']:.4g}", (x, y), xytext=(6, 4), fontsize=7.5,
                              textcoords="offset points", color=look["color"])  # fmt: skip


def _predictions(
    axes: Axes,
    mill: Mapping[str, Any],
    trials: Sequence[Mapping[str, Any]],
    name: str,
    with_S: bool,
) -> None:
    for policy, ratios, cost, error, width in _points(trials, name):
        look, x = LOOKS.get(policy, OTHER_LOOK), cost / mill["cost_s"]
        axes.plot([x, x], [error, width], color=look["color"], lw=1.0, alpha=0.5)
        axes.plot(x, width, marker="_", ms=8, color=look["color"], alpha=0.7, ls="none")
        axes.plot(x, error, ms=7, ls="none", label=f"two mills, extrapolated, {policy}", **look)
        # Intervals of friction-matched mills do not hold: their pairs stay without names.
        if with_S and policy != FRICTION_MATCHED:
            pair = ", ".join(f"{S:.4g}" for S in ratios)
            axes.annotate(pair, (x, error), xytext=(6, -9), textcoords="offset points",
                          fontsize=7.5, color=look["color"])  # fmt: skip


def _points(
    trials: Sequence[Mapping[str, Any]], name: str
) -> Iterator[tuple[str, tuple[float, ...], float, float, float]]:
    """Yield policy, S, cost, error and half width of each pair, medians of its predictions.

    Of those from one seed of the nearer mill, where it has several: they cost less.
    """
    groups: dict[tuple, list[Mapping[str, Any]]] = {}
    for trial in trials:
        ratios = tuple(S for S, _ in trial["runs"])
        if len(ratios) == 2:
            key = trial["scheme"], trial["policy"], ratios
            groups.setdefault(key, []).append(trial)
    for (_, policy, ratios), group in groups.items():
        cheap = [trial for trial in group if trial["runs"][0][1] == 1] or group
        known = [
            (trial["cost_s"], *found)
            for trial in cheap
            if (found := _error_and_width(trial, name)) is not None
        ]
        if known:
            cost, error, width = (median(column) for column in zip(*known, strict=True))
            yield policy, ratios, cost, error, width


def _error_and_width(trial: Mapping[str, Any], name: str) -> tuple[float, float] | None:
    """Return the error and the half width of a prediction in %."""
    if name == "contour_mean":
        contour = trial["contour"]
        return (contour["error"], contour["half_width"]) if contour else None
    row = next((row for row in trial["intervals"] if row["observable"] == name), None)
    if row is None or row["error"] is None:
        return None
    unit = 0.01 * abs(row["truth"])
    return abs(row["error"]) / unit, row["half_width"] / unit


def _slice_of_1(axes: Axes, mill: Mapping[str, Any], name: str) -> None:
    """Draw the mean error by chance of one slice of S = 1 and of shorter rotations."""
    deviation = mill["deviations"].get(name)
    if deviation is None:
        return
    # The deviation of a contour is a mean distance already.
    chance = deviation if name == "contour_mean" else MEAN_OVER_DEVIATION * deviation
    begin, end = mill["steady_from_rad"], mill["rotation_rad"]
    shares = np.linspace(0.1, 1.0, 40)
    ends = begin + shares * (end - begin)
    settling = mill["settling_s"] / mill["cost_s"]
    costs = settling + (1.0 - settling) * ends / end
    axes.plot(costs, chance / np.sqrt(shares), ls=":", color="black", lw=1.2)
    axes.plot(1.0, chance, marker="D", color="black", ms=5, ls="none",
              label="slice of S = 1: chance alone (dotted: shorter)")  # fmt: skip


def _whole_mill_axis(axes: Axes, mills: Sequence[Mapping[str, Any]]) -> None:
    """Add the time over that of the whole mill, whose balls cost as much as those of the slice."""
    shares = {round(mill["length_share"], 3) for mill in mills}
    if len(shares) > 1 or 1.0 in shares:
        return
    share = mills[0]["length_share"]
    upper = axes.secondary_xaxis("top", (lambda x: share * x, lambda x: x / share))
    upper.set_xlabel("processor time / that of the whole mill of S = 1, by balls", fontsize=8.5)
    upper.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0), numticks=12))
    upper.xaxis.set_major_formatter("{x:g}")
    upper.xaxis.set_minor_formatter(NullFormatter())


def draw_coverage(content: Mapping[str, Any], file: Path) -> Figure:
    """Draw the error of each prediction over the half width of its interval, by observable.

    Args:
        content: of `coverage.try_predictions`.
    """
    rows = [(x["policy"], row) for x in content["trials"] for row in x["intervals"]]
    rows = [(policy, row) for policy, row in rows if row["half_width"]]
    labels = list(dict.fromkeys(row["label"] for _, row in rows))
    policies = list(dict.fromkeys(policy for policy, _ in rows))
    random = np.random.default_rng(1)
    with rc_context(STYLE):
        figure = Figure(figsize=(7.2, 1.3 + 0.4 * len(labels)), layout="constrained")
        axes = figure.add_subplot()
        axes.axvspan(-1.0, 1.0, color="#e9e9e9", lw=0, label="inside the interval")
        for i, policy in enumerate(policies):
            found = [row for other, row in rows if other == policy]
            lane = 0.5 * (i + 0.5) / len(policies) - 0.25
            scatter = 0.2 / len(policies) * random.uniform(-1.0, 1.0, len(found))
            places = [labels.index(row["label"]) + lane for row in found] + scatter
            over = np.clip([row["error"] / row["half_width"] for row in found], -FARTHEST, FARTHEST)
            axes.plot(over, places, ls="none", ms=4.5, alpha=0.7, label=policy,
                      **LOOKS.get(policy, OTHER_LOOK))  # fmt: skip
        axes.set_yticks(range(len(labels)), labels)
        axes.invert_yaxis()
        axes.grid(axis="y", visible=False)
        axes.set_xlim(-1.05 * FARTHEST, 1.05 * FARTHEST)
        axes.set_xlabel(f"error / half width of the interval; beyond {FARTHEST:g} at the edge")
        figure.legend(loc="outside upper center", ncols=3)
        figure.savefig(file, dpi=150)
    return figure
