"""Figures of multi-ball cases: time series against mill angle."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from millscale.analysis.charge.result import charge_scales
from millscale.analysis.charge.scaled_mills import mill_name
from millscale.analysis.finished import Charge
from millscale.report.figures.style import STYLE, dashes_of_states, shade_of_each_S

_PANELS = (
    ("kinetic energy", "kinetic_translation_J", "energy", "J"),
    ("potential energy", "potential_J", "energy", "J"),
    ("drive torque", "drive_torque_Nm", "torque", "N m"),
    ("drive power", "drive_power_W", "power", "W"),
    ("centre of mass x", "centre_x_m", "length", "m"),
    ("centre of mass z", "centre_z_m", "length", "m"),
)
_SCALE_NAMES = {"energy": "M ω²R²", "torque": "M g R", "power": "M g R ω", "length": "R"}
_COLOURS = ("#1f6fb4", "#d1711b", "#2a8c4a", "#8a4fa3", "#b0413e", "#5a6b7b")


def charge_series(charges: Sequence[Charge], dimensionless: bool) -> Figure:
    """Return energies, torque and power of the drive, centre of mass against mill angle.

    Args:
        dimensionless: divide by `result.charge_scales`, so that similar mills coincide.
    """
    with rc_context(STYLE):
        figure = Figure(figsize=(7.2, 7.4), layout="constrained")
        panels = figure.subplots(3, 2, sharex=True)
        looks = _looks(charges)
        for charge in charges:
            series = charge.series
            scales = charge_scales(charge.case, series)
            for axes, (_, column, scale, _) in zip(panels.flat, _PANELS, strict=True):
                values = series[column] / (getattr(scales, scale) if dimensionless else 1.0)
                axes.plot(series["mill_angle_rad"], values, lw=1.0, **looks[charge])
        for axes, (name, _, scale, unit) in zip(panels.flat, _PANELS, strict=True):
            divisor = f"/ {_SCALE_NAMES[scale]}" if dimensionless else f"[{unit}]"
            axes.set_ylabel(f"{name} {divisor}")
        for axes in panels[1]:
            ignore_start(axes)
        for axes in panels[-1]:
            axes.set_xlabel("mill rotation angle [rad]")
        handles, labels = panels[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=2)
    return figure


def _looks(charges: Sequence[Charge]) -> dict[Charge, dict[str, Any]]:
    """Return the line of each charge: colour by S, black at S = 1, dashes at constant speed, dots
    for a policy other than the paper's, long dashes for a second state of the liner. Seeds of one
    scaled mill look alike, and the first is in the legend."""
    colours, states = shade_of_each_S(charges), dashes_of_states(charges)
    looks: dict[Charge, dict[str, Any]] = {}
    named: set[tuple] = set()
    for charge in charges:
        mill = (*mill_name(charge), charge.balls)
        dashes = "--" if charge.scheme == "constant-speed" else "-"
        looks[charge] = {
            "color": colours[charge.S],
            "linestyle": states.get(charge.state, dashes if charge.policy == "paper" else ":"),
            "label": "_" if mill in named else charge.id.removesuffix(f"-seed{charge.seed}"),
        }
        named.add(mill)
    return looks


def ignore_start(axes: Axes) -> None:
    """Fit the axis to the curves without their first tenth, where the start has a large peak."""
    values = [
        line.get_ydata()[line.get_xdata() >= 0.1 * line.get_xdata()[-1]] for line in axes.lines
    ]
    low, high = min(v.min() for v in values), max(v.max() for v in values)
    margin = 0.08 * (high - low) or 1.0
    axes.set_ylim(low - margin, high + margin)


def charge_states(charge: Charge) -> Figure:
    """Return the share of the balls on the wall, in the bed and in flight against mill angle."""
    series = charge.series
    with rc_context(STYLE):
        figure = Figure(figsize=(5.6, 2.6), layout="constrained")
        axes = figure.add_subplot()
        for name, colour in zip(("wall", "bed", "flight"), _COLOURS, strict=False):
            preposition = "on" if name == "wall" else "in"
            share = 100.0 * series[f"balls_{preposition}_{name}"] / series["balls"]
            axes.plot(series["mill_angle_rad"], share, color=colour, label=f"{preposition} {name}")
        axes.set(xlabel="mill rotation angle [rad]", ylabel="balls [%]", ylim=(0, None))
        axes.legend(ncols=3)
    return figure
