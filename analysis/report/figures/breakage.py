"""Breakage of an ore: energy of the impacts of the physical mill, rates by particle size."""

from __future__ import annotations

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from millscale.analysis.ore.breakage import MINUTE, Breakage, MillBreakage
from millscale.report.figures.style import STYLE, colour_of_S


def breakage_figure(found: Breakage) -> Figure:
    """Return power by energy of an impact, and selection function or t10 by size, of each mill."""
    with rc_context(STYLE):
        figure = Figure(figsize=(9.0, 3.8), layout="constrained")
        left, right = figure.subplots(1, 2)
        for mill in found.mills:
            _power(left, mill)
        left.set(xscale="log", yscale="log")
        left.set_xlabel("energy of an impact, physical mill [J]")
        left.set_ylabel(f"{found.ore.energy} [kW per decade]")
        left.legend()
        if found.ore.tavares is not None:
            _rates(right, found)
        else:
            _fineness(right, found)
        right.set_xscale("log")
        right.set_xlabel("particle size [mm]")
        right.legend()
    return figure


def _label(mill: MillBreakage) -> str:
    return f"S = {mill.S:.4g}, {mill.scheme.replace('-', ' ')}"


def _power(axes: Axes, mill: MillBreakage) -> None:
    if not mill.decades:
        return
    edges = [row.low for row in mill.decades] + [10.0 * mill.decades[-1].low]
    axes.stairs(
        [1e-3 * row.power for row in mill.decades],
        edges,
        color=colour_of_S(mill.S),
        label=_label(mill),
    )


def _rates(axes: Axes, found: Breakage) -> None:
    for mill in found.mills:
        rows = [row for row in mill.sizes if row.rate]
        axes.errorbar(
            [1e3 * row.size for row in rows],
            [MINUTE * (row.rate or 0.0) for row in rows],
            [MINUTE * (row.rate_deviation or 0.0) for row in rows],
            fmt="o-",
            markersize=3.5,
            capsize=2,
            color=colour_of_S(mill.S),
            label=_label(mill),
        )
    if found.ore.austin is not None:
        sizes = np.geomspace(found.ore.sizes[0], found.ore.sizes[-1], 60)
        axes.plot(1e3 * sizes, found.ore.austin.at(sizes), "k--", label="batch test, as stated")
    axes.set_yscale("log")
    axes.set_ylabel("selection function [1/min]")


def _fineness(axes: Axes, found: Breakage) -> None:
    for mill in found.mills:
        points = [(1e3 * row.size, row.t10) for row in mill.sizes if row.t10 is not None]
        axes.plot(
            [size for size, _ in points],
            [fineness for _, fineness in points],
            "o-",
            markersize=3.5,
            color=colour_of_S(mill.S),
            label=_label(mill),
        )
    axes.set_ylabel("t10, impacts weighted by energy [%]")
