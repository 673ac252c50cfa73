"""Figures of contours, curtains and mass flow of all scaled mills (Figs. 11 to 14)."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from millscale.analysis.charge.groove_flow import PHASES, pitch_masses
from millscale.analysis.charge.measured import Measured
from millscale.analysis.finished import Charge
from millscale.analysis.paper import numbers as paper
from millscale.analysis.shapes.comparison import distance_along_normal
from millscale.analysis.shapes.cross_section import groove_box, liner_outline
from millscale.analysis.shapes.curtain import RESOLUTION
from millscale.analysis.shapes.mass_flow import FRAMES
from millscale.analysis.shapes.shape import Shape
from millscale.analysis.shapes.solid_fraction import Grid
from millscale.report.figures.style import STYLE, dashes_of_states, shade_of_each_S

DASHES = {"fixed": "-", "overlap-matched": (0, (4, 1.5))}
DOTS = (0, (1, 1))  # a policy other than the paper's


def looks_of(charges: Sequence[Charge], references: Collection[Charge] = ()) -> dict[Charge, dict]:
    """Return the line style of each charge: colour by S, black at S = 1, dashes for a matched E,
    dots for a policy other than the paper's, long dashes for a second state of the liner. Physical
    mills and references are thicker and on top."""
    shades, states = shade_of_each_S(charges), dashes_of_states(charges)
    on_top = {c: c.is_physical or (len(charges) > 1 and c in references) for c in charges}
    return {
        charge: {
            "color": shades[charge.S],
            "lw": 1.8 if on_top[charge] else 1.2,
            "ls": states.get(
                charge.state, DASHES[charge.stiffness] if charge.policy == "paper" else DOTS
            ),
            "zorder": 4 if on_top[charge] else 3,
        }
        for charge in charges
    }


def contours(
    measured: Measured, charges: Sequence[Charge], references: Collection[Charge] = ()
) -> Figure:
    """Return the surface contours at the mill angles kept, over R - a (Fig. 11).

    Args:
        charges: which to draw, one seed of each scaled mill.
        references: what they are compared with, drawn on top.
    """
    look = looks_of(charges, references)
    with rc_context(STYLE):
        figure, panels = _panels_of_angles(sorted(measured.shapes), 3.8, 3.7)
        for angle, axes in panels.items():
            shapes = measured.shapes[angle]
            drawn = [charge for charge in charges if charge in shapes]
            for charge in {charge.state: charge for charge in drawn[::-1]}.values():
                _outline(axes, shapes[charge])
            for charge in drawn:
                for i, line in enumerate(shapes[charge].contour.lines):
                    label = None if i else charge.label
                    axes.plot(*line.T, **look[charge], label=label)
        _share_legend(figure)
        figure.supxlabel("x / (R - a)", fontsize=9.5)
        figure.supylabel("z / (R - a)", fontsize=9.5)
    return figure


def contour_differences(
    measured: Measured, charges: Sequence[Charge], references: Mapping[Charge, Charge]
) -> Figure | None:
    """Return how far each surface lies from that of its reference, along the normal of the
    reference, at the mill angles kept; None without a charge that has another as reference.

    Args:
        charges: which to draw, one seed of each scaled mill.
        references: what each charge is compared with.
    """
    look = looks_of(charges, references.values())
    curves = {
        angle: {
            charge: distance_along_normal(reference.contour.lines, shapes[charge].contour.lines)
            for charge in charges
            if charge in shapes
            and references[charge] is not charge
            and (reference := shapes.get(references[charge]))
            and reference.contour.lines
        }
        for angle, shapes in sorted(measured.shapes.items())
    }
    angles = [angle for angle, found in curves.items() if found]
    if not angles:
        return None
    with rc_context(STYLE):
        figure, panels = _panels_of_angles(angles, 3.8, 2.4)
        for angle, axes in panels.items():
            axes.axhline(0.0, color="#000", lw=0.8, zorder=4)
            for charge, (along, distance) in curves[angle].items():
                axes.plot(along, 100.0 * distance, **look[charge], label=charge.label)
        _share_legend(figure)
        figure.supxlabel("along the surface from the toe / (R - a)", fontsize=9.5)
        figure.supylabel("distance from the reference [% of R - a]", fontsize=9.5)
    return figure


def _panels_of_angles(
    angles: Sequence[float], width: float, height: float
) -> tuple[Figure, dict[float, Axes]]:
    """Return a figure with a panel of this size [inch] for each mill angle, two in a row."""
    columns = min(len(angles), 2)
    rows = -(-len(angles) // columns)
    size = (width * columns, height * rows + 0.5)
    figure = Figure(figsize=size, layout="constrained")
    grid = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True).ravel()
    for axes in grid[len(angles) :]:
        axes.remove()
    for axes, angle in zip(grid, angles, strict=False):
        axes.set_title(f"{angle:.4g} rad", fontsize=9.5)
    return figure, dict(zip(angles, grid, strict=False))


def curtain_profiles(
    measured: Measured, charges: Sequence[Charge], references: Collection[Charge] = ()
) -> Figure | None:
    """Return the profiles of the paper's curtains at the last mill angle (Fig. 12), with the balls
    of the first charge. A mill without them has its own; None if no curtain has enough balls."""
    look, shapes = looks_of(charges, references), measured.shapes[measured.last_angle]
    known = [c for c in charges if c in shapes and shapes[c].curtains is not None]
    nodes = Grid(RESOLUTION).nodes
    found = sorted({number for c in known for number in shapes[c].curtains})
    numbers = [x for x in paper.CURTAINS if x in found] or found[: len(paper.CURTAINS)]
    if not numbers:
        return None
    with rc_context(STYLE):
        columns = min(len(numbers), 2)
        rows = -(-len(numbers) // columns)
        figure = Figure(figsize=(3.8 * columns, 3.7 * rows + 0.5), layout="constrained")
        grid = figure.subplots(rows, columns, squeeze=False).ravel()
        for axes in grid[len(numbers) :]:
            axes.remove()
        for axes, number in zip(grid, numbers, strict=False):
            drawn = [c for c in known if number in shapes[c].curtains]
            axes.set(title=f"curtain {number}", aspect="equal")
            _outline(axes, shapes[drawn[0]])
            balls = shapes[drawn[0]].curtains[number].centres
            axes.plot(*balls.T, ".", ms=2, color="#888", zorder=1, label=f"balls, {drawn[0].label}")
            for charge in drawn:
                style = look[charge]
                region = shapes[charge].curtains[number].region.astype(float)
                contour = axes.contour(
                    nodes,
                    nodes,
                    region,
                    [0.5],
                    colors=[style["color"]],
                    linewidths=style["lw"],
                    linestyles=[style["ls"]],
                    zorder=style["zorder"],
                )
                contour.set_gid(charge.label)  # a legend takes no contours
                axes.plot([], [], **style, label=charge.label)
            _frame_regions(axes, [shapes[c].curtains[number].region for c in drawn], nodes)
        _share_legend(figure)
        figure.supxlabel("x / (R - a)", fontsize=9.5)
        figure.supylabel("z / (R - a)", fontsize=9.5)
    return figure


def has_flow(charge: Charge) -> bool:
    """Return whether the series of a charge holds the mass in the monitoring box."""
    return all(charge.has(column) for column in FRAMES.values())


def mass_flow(charges: Sequence[Charge]) -> Figure:
    """Return the mass in the monitoring box over total mass against mill angle, in the fixed and in
    the rotating frame (Fig. 14)."""
    look = looks_of(charges)
    with rc_context(STYLE):
        figure = Figure(figsize=(7.6, 5.6), layout="constrained")
        panels = figure.subplots(2, 1, sharex=True)
        for axes, (frame, column) in zip(panels, FRAMES.items(), strict=True):
            for charge in charges:
                style = look[charge] | {"lw": 0.9}
                angle, share = charge.series["mill_angle_rad"], 100.0 * charge.series[column]
                axes.plot(angle, share, **style, label=charge.label)
            axes.set_ylabel(f"mass in the box [%]\n{frame} frame")
            axes.set_ylim(bottom=0.0)
        panels[-1].set_xlabel("mill rotation angle [rad]")
        _share_legend(figure)
    return figure


def mass_flow_over_pitch(charges: Sequence[Charge]) -> Figure | None:
    """Return the mass in the box at rest over one lifter pitch, the mean over the steady pitches,
    and below it the difference from the first of the charges; None without enough pitches."""
    masses = {charge: found for charge in charges if (found := pitch_masses(charge)) is not None}
    if not masses:
        return None
    look, reference = looks_of(charges), next(iter(masses))
    phase = (np.arange(PHASES) + 0.5) / PHASES
    several = len(masses) > 1
    with rc_context(STYLE):
        figure = Figure(figsize=(7.6, 4.8 if several else 3.0), layout="constrained")
        panels = figure.subplots(1 + several, 1, sharex=True, squeeze=False)[:, 0]
        for charge, found in masses.items():
            percent = 100.0 * found.mean(axis=0)
            panels[0].plot(phase, percent, **look[charge], label=charge.label)
            if several:
                difference = percent - 100.0 * masses[reference].mean(axis=0)
                panels[1].plot(phase, difference, **look[charge])
        panels[0].set_ylabel("mass in the box [%]")
        if several:
            panels[1].set_ylabel(f"less that of\n{reference.label} [%]")
        panels[-1].set_xlabel("share of a lifter pitch [-]")
        _share_legend(figure)
    return figure


def monitoring_box(charge: Charge) -> Figure:
    """Return the monitoring box in the mill at rest (Fig. 13)."""
    radius = charge.case.mill.radius_m
    with rc_context(STYLE):
        figure = Figure(figsize=(3.6, 3.7), layout="constrained")
        axes = figure.add_subplot()
        axes.plot(*(liner_outline(charge.case, 0.0) / radius).T, color="#555", lw=0.9)
        box = groove_box(charge.case)
        if box is not None:
            axes.fill(*(box / radius).T, color="#e8a25e")
            axes.plot(*(box / radius).T, color="#8a4508", label="monitoring box")
        axes.set(aspect="equal", xlabel="x / R", ylabel="z / R")
    return figure


def _outline(axes: Axes, shape: Shape) -> None:
    axes.plot(*shape.outline.T, color="#888", lw=0.6, zorder=1)
    axes.set_aspect("equal")


def _frame_regions(axes: Axes, regions: list[np.ndarray], nodes: np.ndarray) -> None:
    rows, columns = np.nonzero(np.any(regions, axis=0))
    middle = 0.5 * (nodes[columns].min() + nodes[columns].max())
    low, high = nodes[rows].min() - 0.06, nodes[rows].max() + 0.06
    half = max(0.5 * (high - low), 0.5 * np.ptp(nodes[columns]) + 0.06)
    axes.set(
        xlim=(middle - half, middle + half),
        ylim=(0.5 * (low + high) - half, 0.5 * (low + high) + half),
    )


def _share_legend(figure: Figure) -> None:
    known = {}
    for axes in figure.axes:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            known.setdefault(label, handle)
    if known:
        figure.legend(known.values(), known.keys(), loc="outside upper center", ncols=4)
