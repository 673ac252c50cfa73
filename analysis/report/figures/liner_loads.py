"""Figures of the loads on the liner: map, force on a lifter, wear along the profile."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from millscale.analysis.finished import Charge
from millscale.analysis.wear.lifter_load import LifterLoad
from millscale.analysis.wear.loads import Bins, LinerLoads
from millscale.analysis.wear.rate import WearRate
from millscale.report.figures.style import STYLE
from millscale.runs.case_file import Case

FACE_COLOURS = {"leading": "#d55e00", "top": "#009e73", "trailing": "#56b4e9"}
_LAW_COLOURS = {"archard": "#0072b2", "finnie": "#d55e00"}
_TICKS = np.arange(-180, 181, 60)


def load_map(loads: LinerLoads, case: Case) -> Figure:
    """Return the mean normal force per area by place of the bin and arc length of a pitch."""
    force = loads.rates("normal_impulse_Ns") / (
        loads.bins.widths[None, :] * case.mill.simulated_length_m
    )
    places = np.degrees(_from_vertical(loads.places))
    order = np.argsort(places)
    with rc_context(STYLE):
        figure = Figure(figsize=(7.2, 3.8), layout="constrained")
        axes = figure.subplots()
        axes.grid(False)
        drawn = axes.pcolormesh(
            places[order],
            500.0 * (loads.bins.edges[1:] + loads.bins.edges[:-1]),
            1e-3 * force[order].T,
            shading="nearest",
            cmap="magma_r",
        )
        figure.colorbar(drawn, ax=axes, label="normal force per area [kPa]")
        axes.set_xticks(_TICKS)
        axes.set_xlabel("middle of the groove, from the vertical [deg]")
        axes.set_ylabel("arc length of a pitch [mm]")
    return figure


def _from_vertical(angle: np.ndarray) -> np.ndarray:
    """Return angles from the bottom as angles from the vertical, in (-pi, pi] [rad]."""
    return np.pi - angle % (2.0 * np.pi)


def lifter_load_figure(lifters: Sequence[LifterLoad], charge: Charge) -> Figure:
    """Return the force on each lifter of a sector over a revolution, with toe and shoulder by it
    and by the balls at the wall."""
    with rc_context(STYLE):
        figure = Figure(figsize=(7.2, 3.4), layout="constrained")
        axes = figure.subplots()
        for k, load in enumerate(lifters):
            order = np.argsort(load.angle)
            angle = np.degrees(load.angle[order])
            name = f"lifter {load.lifter + 1}: " if len(lifters) > 1 else ""
            axes.plot(angle, load.along[order], color=f"C{2 * k}", label=f"{name}against rotation")
            axes.plot(angle, load.outward[order], color=f"C{2 * k + 1}", label=f"{name}outward")
        for end in (lifters[0].toe, lifters[0].shoulder):
            if end is not None:
                axes.axvline(_degrees(end), color="#444", lw=0.9, ls="--")
        for column in ("toe_angle_rad", "shoulder_angle_rad"):
            mean = charge.steady_mean(column)
            if mean is not None:
                axes.axvline(_degrees(mean), color="#999", lw=0.9, ls=":")
        axes.axhline(0.0, color="#888", lw=0.8)
        axes.set_xticks(_TICKS)
        axes.set_xlabel("lifter, from the vertical [deg]; dashed: toe and shoulder by the force, "
                        "dotted: by the balls")  # fmt: skip
        axes.set_ylabel("force per length [N/m]")
        axes.legend()
    return figure


def _degrees(angle: float) -> float:
    """Return an angle in (-180, 180] [deg]."""
    return 180.0 - (180.0 - np.degrees(angle)) % 360.0


def wear_figure(rates: Sequence[WearRate], bins: Bins) -> Figure:
    """Return the energy that wears the physical mill along a pitch, by each law."""
    with rc_context(STYLE):
        figure = Figure(figsize=(7.2, 3.4), layout="constrained")
        axes = figure.subplots()
        _shade_faces(axes, bins)
        for rate in rates:
            middles = 0.5 * (rate.edges[1:] + rate.edges[:-1])
            colour = _LAW_COLOURS[rate.law]
            axes.plot(middles, rate.flux, color=colour, label=rate.law.capitalize())
            low, high = rate.flux - rate.error, rate.flux + rate.error
            axes.fill_between(middles, low, high, color=colour, alpha=0.2, lw=0.0)
        axes.set_ylim(bottom=0.0)
        axes.set_xlabel("arc length over that of a pitch, in the direction of rotation")
        axes.set_ylabel("energy per area and time [W/m²]")
        axes.legend()
    return figure


def _shade_faces(axes: Axes, bins: Bins) -> None:
    """Shade the faces of the lifters."""
    edges = bins.edges / bins.edges[-1]
    changes = [0, *(np.flatnonzero(bins.faces[1:] != bins.faces[:-1]) + 1), len(bins.faces)]
    named = set()
    for first, last in pairwise(changes):
        face = str(bins.faces[first])
        if face in FACE_COLOURS:
            label = None if face in named else f"{face} face" if face != "top" else "top"
            named.add(face)
            axes.axvspan(edges[first], edges[last], color=FACE_COLOURS[face], alpha=0.12, lw=0.0,
                         label=label)  # fmt: skip
