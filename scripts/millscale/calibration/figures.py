"""Figures of a calibration: the density of the parameters, profiles, convergence."""

from __future__ import annotations

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from millscale.calibration.inference import Parameter
from millscale.calibration.result import Result
from millscale.calibration.targets import Target
from millscale.report.figures.style import STYLE

# Colour-blind safe (Okabe and Ito).
BLUE, ORANGE, GREY = "#0072b2", "#d55e00", "#777"
SHOWN = 700
BINS = 24


def density_figure(result: Result) -> Figure:
    """Return the density of each parameter, and of each two below. Dots: particles; rings: samples;
    cross and line: best values."""
    found, parameters = result.inference, result.inference.parameters
    count = len(parameters)
    values = np.column_stack([p.value(found.particles[:, j]) for j, p in enumerate(parameters)])
    with rc_context(STYLE):
        size = max(2.0 * count, 3.2)
        figure = Figure(figsize=(size, size), layout="constrained")
        axes = figure.subplots(count, count, squeeze=False)
        for i, row in enumerate(parameters):
            for j, column in enumerate(parameters):
                if j > i:
                    axes[i, j].set_axis_off()
                elif j == i:
                    _histogram(axes[i, i], row, values[:, i], found.found[i].best)
                else:
                    _cloud(axes[i, j], result, values[:SHOWN, j], values[:SHOWN, i], (j, i))
                if i == count - 1:
                    axes[i, j].set_xlabel(column.name)
                if j == 0 and i > 0:
                    axes[i, j].set_ylabel(row.name)
    return figure


def _histogram(axes: Axes, parameter: Parameter, values: np.ndarray, best: float) -> None:
    edges = parameter.value(np.linspace(0.0, 1.0, BINS + 1))
    counts, _ = np.histogram(values, edges)
    axes.stairs(counts / counts.max(), edges, fill=True, color=BLUE, alpha=0.5)
    axes.axvline(best, color=ORANGE)
    axes.set_yticks([])
    _range(axes, parameter, None)


def _cloud(
    axes: Axes, result: Result, x: np.ndarray, y: np.ndarray, which: tuple[int, int]
) -> None:
    j, i = which
    axes.plot(x, y, ".", color=BLUE, ms=2.0, alpha=0.35, rasterized=True)
    sampled = np.array([sample.values for sample in result.samples])
    axes.plot(sampled[:, j], sampled[:, i], "o", mfc="none", mec=GREY, ms=3.5, mew=0.7)
    found = result.inference.found
    axes.plot(found[j].best, found[i].best, "+", color=ORANGE, ms=11.0, mew=1.8)
    _range(axes, result.inference.parameters[j], result.inference.parameters[i])


def _range(axes: Axes, across: Parameter, up: Parameter | None) -> None:
    if across.logarithmic:
        axes.set_xscale("log")
    axes.set_xlim(across.least, across.most)
    if up is not None:
        if up.logarithmic:
            axes.set_yscale("log")
        axes.set_ylim(up.least, up.most)


def profile_figure(result: Result, target: Target) -> Figure:
    """Return a measured profile beside the run with the best values; all samples in grey."""
    assert target.abscissa is not None
    order = np.argsort(target.abscissa)
    across = target.abscissa[order]
    with rc_context(STYLE):
        figure = Figure(figsize=(5.0, 3.2), layout="constrained")
        axes = figure.add_subplot()
        for sample in result.samples:
            seen = sample.observed.targets.get(target.name)
            if seen is not None:
                axes.plot(across, seen.values[order], color="#ccc", lw=0.6)
        seen = result.calibrated.observed.targets.get(target.name)
        if seen is not None:
            axes.plot(across, seen.values[order], color=ORANGE, label="calibrated")
        axes.errorbar(
            across, target.measured[order], target.uncertainty, fmt=".", color="#000", lw=0.8,
            label="measured",
        )  # fmt: skip
        axes.set_xlabel("along the profile [m]")
        axes.set_ylabel(f"{target.label} [{target.unit}]")
        axes.legend()
    return figure


def rounds_figure(result: Result) -> Figure:
    """Return the interval of each parameter after each round."""
    with rc_context(STYLE):
        parameters = result.inference.parameters
        figure = Figure(figsize=(5.0, 1.5 * len(parameters) + 0.6), layout="constrained")
        axes = figure.subplots(len(parameters), 1, squeeze=False, sharex=True)[:, 0]
        runs = [one.runs for one in result.history]
        for j, (own, parameter) in enumerate(zip(axes, parameters, strict=True)):
            found = [one.found[j] for one in result.history]
            best = np.array([one.best for one in found])
            ends = [best - [x.lower for x in found], np.array([x.upper for x in found]) - best]
            own.errorbar(runs, best, np.maximum(ends, 0.0), fmt="o", color=BLUE, capsize=3)
            own.set_ylabel(parameter.name)
            if parameter.logarithmic:
                own.set_yscale("log")
            own.set_ylim(parameter.least, parameter.most)
        axes[-1].set_xlabel("samples")
    return figure
