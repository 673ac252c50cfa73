"""Figures of several runs folders: one colour for each, their scaled mills laid over each other."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib import colormaps, rc_context
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from millscale.analysis.charge.measured import Measured
from millscale.analysis.charge.result import charge_scales
from millscale.analysis.finished import Charge
from millscale.analysis.shapes.cross_section import liner_outline
from millscale.analysis.shapes.shape import physical_unit_length
from millscale.report.figures.charge import ignore_start
from millscale.report.figures.single_ball import first_cycle
from millscale.report.figures.style import LIGHTEST, STYLE
from millscale.report.overview import QUANTITIES
from millscale.report.side_by_side import BallGroup, Group, Side, SideBySide, SideRow

# Each has a contrast of 3 or more on white, and colour-blind people can distinguish them.
COLOURS = ("#0072b2", "#d55e00", "#00805c", "#a6428a", "#000000", "#8a6d00")
ANSWERS = ("power", "power per tonne of balls", "toe", "shoulder")

_PANELS = (
    ("kinetic energy", "kinetic_translation_J", "energy", "kJ", 1e-3),
    ("drive torque", "drive_torque_Nm", "torque", "kN m", 1e-3),
    ("drive power", "drive_power_W", "power", "kW", 1e-3),
    ("balls in flight", "balls_in_flight", "balls", "%", 100.0),
    ("centre of mass x", "centre_x_m", "length", "m", 1.0),
    ("centre of mass z", "centre_z_m", "length", "m", 1.0),
)
_SCALE_NAMES = {"energy": "M ω²R²", "torque": "M g R", "power": "M g R ω", "length": "R"}


def colours_of(sides: Sequence[Side]) -> dict[str, str]:
    """Return the colour of each runs folder by its name."""
    if len(sides) <= len(COLOURS):
        return {side.name: colour for side, colour in zip(sides, COLOURS, strict=False)}
    places = np.linspace(0.0, LIGHTEST, len(sides))
    return {
        side.name: to_hex(colormaps["plasma"](float(place)))
        for side, place in zip(sides, places, strict=True)
    }


def series(group: Group, colours: dict[str, str], physical: bool) -> Figure:
    """Return energy, torque, power, flight and centre of mass against mill angle.

    Args:
        physical: as those of the physical mill with its whole charge; else dimensionless.
    """
    with rc_context(STYLE):
        figure = Figure(figsize=(7.6, 7.4), layout="constrained")
        panels = figure.subplots(3, 2, sharex=True)
        for row in group.rows:
            for charge in row.charges:
                label = row.side.name if charge is row.charges[0] else "_"
                look = {"lw": 1.0, "color": colours[row.side.name], "label": label}
                for axes, panel in zip(panels.flat, _PANELS, strict=True):
                    values = _curve(charge, row, panel, physical)
                    axes.plot(charge.series["mill_angle_rad"], values, **look)
        for axes, (name, _, scale, unit, _) in zip(panels.flat, _PANELS, strict=True):
            in_unit = f"[{unit}]" if physical or scale == "balls" else f"/ {_SCALE_NAMES[scale]}"
            axes.set_ylabel(f"{name} {in_unit}")
        for axes in panels.flat[1:3]:
            ignore_start(axes)
        for axes in panels[-1]:
            axes.set_xlabel("mill rotation angle [rad]")
        _share_legend(figure, colours)
    return figure


def _curve(charge: Charge, row: SideRow, panel: tuple, physical: bool) -> np.ndarray:
    _, column, scale, _, in_unit = panel
    values = charge.series[column]
    if scale == "balls":
        return in_unit * values / charge.series["balls"]
    over = values / getattr(charge_scales(charge.case, charge.series), scale)
    if not physical:
        return over
    mill = row.row.physical
    full = {"length": mill.radius}.get(scale) or getattr(mill, f"{scale}_scale")
    return in_unit * full * over


def contours(
    group: Group, measured: Measured, colours: dict[str, str], physical: bool
) -> Figure | None:
    """Return surface and liner of each runs folder at the mill angles that were kept; None without.

    Args:
        physical: in metres of the physical mill; else over R - a.
    """
    angles = [a for a, shapes in sorted(measured.shapes.items()) if shapes.keys() & group.charges]
    if not angles:
        return None
    columns = min(2, len(angles))
    rows = math.ceil(len(angles) / columns)
    with rc_context(STYLE):
        figure = Figure(figsize=(3.8 * columns, 3.7 * rows + 0.5), layout="constrained")
        panels = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True).flat
        for axes, angle in zip(panels, angles, strict=False):
            for row in reversed(group.rows):  # the first on top
                _contour(axes, row, measured, angle, colours[row.side.name], physical)
            axes.set(title=f"{angle:.4g} rad", aspect="equal")
        for axes in list(panels)[len(angles) :]:
            axes.set_visible(False)
        _share_legend(figure, colours)
        unit = "in the physical mill [m]" if physical else "/ (R - a)"
        figure.supxlabel(f"x {unit}", fontsize=9.5)
        figure.supylabel(f"z {unit}", fontsize=9.5)
    return figure


def _contour(
    axes: Axes, row: SideRow, measured: Measured, angle: float, colour: str, physical: bool
) -> None:
    known = [charge for charge in row.charges if charge in measured.shapes[angle]]
    for charge in known:
        shape = measured.shapes[angle][charge]
        unit = physical_unit_length(charge.case) if physical else 1.0
        for number, line in enumerate(shape.contour.lines):
            label = row.side.name if charge is known[0] and not number else "_"
            axes.plot(*(unit * line).T, color=colour, lw=1.4, label=label)
        if charge is known[0]:
            axes.plot(*(unit * shape.outline).T, color=colour, lw=0.6, alpha=0.7)


def answers(found: SideBySide, group: Group, colours: dict[str, str]) -> Figure:
    """Return power, power per tonne, toe and shoulder of the physical mill with intervals: against
    the fact that was varied, or by runs folder."""
    chosen = [i for i, quantity in enumerate(QUANTITIES) if quantity.label in ANSWERS]
    varied = found.varied
    places = _places(found, group)
    with rc_context(STYLE):
        figure = Figure(figsize=(7.6, 5.4), layout="constrained")
        for axes, i in zip(figure.subplots(2, 2, sharex=True).flat, chosen, strict=True):
            values = [row.row.estimates[i] for row in group.rows]
            if varied is not None:
                known = sorted(
                    (x, e.value) for x, e in zip(places, values, strict=True) if e.value is not None
                )
                axes.plot(*np.array(known).reshape(-1, 2).T, color="#999", lw=0.8, zorder=1)
            for row, x, found_value in zip(group.rows, places, values, strict=True):
                if found_value.value is not None:
                    axes.errorbar(
                        x, found_value.value, found_value.half_width or 0.0,
                        fmt="o", ms=5.5, capsize=3, color=colours[row.side.name],
                    )  # fmt: skip
            axes.set_ylabel(QUANTITIES[i].heading)
            if varied is None:
                axes.set_xticks(places, [row.side.name for row in group.rows])
                axes.set_xlim(-0.5, len(group.rows) - 0.5)
            elif axes in figure.axes[2:]:
                axes.set_xlabel(varied.fact.heading)
    return figure


def _places(found: SideBySide, group: Group) -> list[float]:
    """Return where the runs folders of a group stand on the axis."""
    if found.varied is None:
        return [float(i) for i in range(len(group.rows))]
    return [float(found.varied.fact.read(row.case)) for row in group.rows]  # type: ignore[arg-type]


def trajectories(group: BallGroup, colours: dict[str, str]) -> Figure:
    """Return the path of the ball's centre over R in its first cycle, inside the liner of each mill
    at the mill angle of the throw."""
    with rc_context(STYLE):
        figure = Figure(figsize=(4.8, 5.0), layout="constrained")
        axes = figure.add_subplot()
        for side, row in zip(group.sides, group.rows, strict=True):
            ball, colour = row.ball, colours[side.name]
            radius, first = ball.case.mill.radius_m, first_cycle(ball)
            path = [ball.series[name][first] / radius for name in ("x_m", "z_m")]
            axes.plot(*path, color=colour, lw=1.2, label=side.name)
            throws = ball.result.throws
            turned = throws[0].mill_angle_rad if throws else 0.0
            outline = liner_outline(ball.case, turned) / radius
            axes.plot(*outline.T, color=colour, lw=0.6, alpha=0.7)
        axes.set(aspect="equal", xlabel="x / R", ylabel="z / R")
        _share_legend(figure, colours)
    return figure


def _share_legend(figure: Figure, colours: dict[str, str]) -> None:
    """Add one legend for all panels, in the order of the command."""
    known: dict[str, Any] = {}
    for axes in figure.axes:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            known.setdefault(label, handle)
    names = [name for name in colours if name in known]
    if names:
        handles = [known[name] for name in names]
        figure.legend(handles, names, loc="outside upper center", ncols=4)
