"""All scaled mills of a scheme at the same mill angles in one sheet (Figs. 9, 10), with their mean
fields."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure
from scipy.ndimage import convolve

from millscale.analysis.finished import Charge
from millscale.analysis.shapes.cross_section import liner_outline
from millscale.analysis.shapes.occupancy import OCCUPANCY, PolarCells, read_occupancy
from millscale.analysis.shapes.shape import SAME_ANGLE, unit_length
from millscale.analysis.shapes.snapshots import first_dump, snapshots_near, starts_on_rising_side
from millscale.analysis.shapes.velocity_field import VelocityField
from millscale.report.figures.ball_picture import ball_picture, colours_by_side
from millscale.report.figures.style import STYLE
from millscale.runs.dumps import read_dump
from millscale.runs.untrusted import RunFolderError

PIXELS = 420
FIELD_PIXELS = 160
POINTS = 4  # of a pixel, along each side
ARROW_SPACING = 0.12  # over R - a
VIEW = 1.04  # half width of a picture over R


@dataclass(frozen=True)
class _Fields:
    """A mean field of each charge that has it, all in one scale of colours.

    Attributes:
        pictures: values (n, n) [z, x], NaN where nothing is known, and half of their width over R.
        arrows: mean velocities to draw on them.
    """

    title: str
    label: str
    colours: str
    pictures: dict[Charge, tuple[np.ndarray, float]]
    arrows: Mapping[Charge, VelocityField]


def snapshot_sheet(
    charges: Sequence[Charge],
    mill_angles: Sequence[float],
    velocities: Mapping[Charge, VelocityField] | None = None,
) -> Figure:
    """Return a row for each charge, a column for each mill angle [rad]; a panel without a dump at
    that angle has a note. Right of them the mean solid fraction and the mean velocity, if a charge
    has them.

    Args:
        velocities: in the steady part of the rotation.

    Raises:
        RunFolderError: a case without dumps, or a damaged file.
    """
    fields = _mean_fields(charges, velocities or {})
    columns = len(mill_angles) + len(fields)
    with rc_context(STYLE):
        size = (1.75 * columns + 0.5, 1.75 * len(charges) + 0.3 + 0.5 * bool(fields))
        figure = Figure(figsize=size, layout="constrained")
        rows = figure.subplots(len(charges), columns, squeeze=False)
        for axes in rows.flat:
            axes.set(xticks=[], yticks=[], aspect="equal", xlim=(-VIEW, VIEW), ylim=(-VIEW, VIEW))
            axes.spines[:].set_visible(False)
            axes.grid(False)
        for row, charge in zip(rows, charges, strict=True):
            row[0].set_ylabel(f"{charge.label}\n{charge.balls:,} balls")
            _draw_row(row[: len(mill_angles)], charge, mill_angles)
        for axes, angle in zip(rows[0], mill_angles, strict=False):
            axes.set_title(f"{angle:.4g} rad", fontsize=9.5)
        for field, column in zip(fields, rows.T[len(mill_angles) :], strict=True):
            _draw_fields(figure, column, charges, field)
    return figure


def _mean_fields(
    charges: Sequence[Charge], velocities: Mapping[Charge, VelocityField]
) -> list[_Fields]:
    measured = [charge for charge in charges if (charge.folder / OCCUPANCY).exists()]
    fractions = {
        c: _on_pixels(
            *read_occupancy(c.folder), _unit(c), c.case.ball.radius_m / unit_length(c.case)
        )
        for c in measured
    }
    arrows = {c: field for c, field in velocities.items() if c in charges}
    speeds = {c: (field.speed, field.edges[-1] * _unit(c)) for c, field in arrows.items()}
    found = [
        _Fields("mean", "solid fraction", "Blues", fractions, {}),
        _Fields("mean velocity", "speed / ωR", "viridis", speeds, arrows),
    ]
    return [field for field in found if field.pictures]


def _draw_fields(
    figure: Figure, column: Sequence[Any], charges: Sequence[Charge], field: _Fields
) -> None:
    """Draw the field of each charge into its panel of a column, the scale of colours below."""
    top = max(float(np.nanpercentile(values, 99.5)) for values, _ in field.pictures.values())
    image: Any = None
    for axes, charge in zip(column, charges, strict=True):
        outline = liner_outline(charge.case, 0.0) / charge.case.mill.radius_m
        axes.plot(*outline.T, color="#555", lw=0.6)
        if charge not in field.pictures:
            axes.text(0, 0, "not measured", ha="center", va="center", color="#777")
            continue
        values, half = field.pictures[charge]
        image = axes.imshow(
            values, extent=(-half, half, -half, half), origin="lower", cmap=field.colours,
            vmin=0.0, vmax=top, interpolation="nearest",
        )  # fmt: skip
        axes.set(xlim=(-VIEW, VIEW), ylim=(-VIEW, VIEW))
        if charge in field.arrows:
            _draw_arrows(axes, field.arrows[charge], _unit(charge))
    column[0].set_title(field.title, fontsize=9.5)
    scale = column[-1].inset_axes([0.05, -0.12, 0.9, 0.05])
    figure.colorbar(image, cax=scale, orientation="horizontal", label=field.label)


def _draw_arrows(axes: Any, field: VelocityField, unit: float) -> None:
    middles = field.middles
    every = max(1, round(ARROW_SPACING / (middles[1] - middles[0])))
    part = slice(every // 2, None, every)
    along, up = field.velocity[:, part, part]
    axes.quiver(*2 * [middles[part] * unit], along, up, color="#fff", scale=12.0, width=0.008)


def _on_pixels(
    cells: PolarCells, values: np.ndarray, unit: float, ball: float
) -> tuple[np.ndarray, float]:
    """Return the solid fraction of polar cells (rings, sectors) in square pixels, (n, n) [z, x],
    NaN where no ball was; and half of their width over R.

    A cell has the whole volume of a ball whose centre it holds, so layers of balls would have
    fractions above 1. Here the volume is spread over the cross-section of a ball.

    Args:
        unit: R - a over R.
        ball: a over R - a.
    """
    half = float(cells.radii[-1]) + ball
    width = 2.0 * half / FIELD_PIXELS
    # Cells are as small as pixels, so a pixel takes the mean of several points.
    x = width * (np.arange(FIELD_PIXELS * POINTS) + 0.5) / POINTS - half
    ring = np.searchsorted(cells.radii, np.hypot(x[None, :], x[:, None])) - 1
    angle = np.arctan2(-x[None, :], x[:, None]) % (2.0 * np.pi)  # from the top, down the left
    sector = np.clip(np.searchsorted(cells.angles, angle) - 1, 0, values.shape[1] - 1)
    inside = (ring >= 0) & (ring < values.shape[0])
    by_centre = np.where(inside, values[np.where(inside, ring, 0), sector], 0.0)
    blocks = by_centre.reshape(FIELD_PIXELS, POINTS, FIELD_PIXELS, POINTS)
    spread = convolve(blocks.mean(axis=(1, 3)), _sphere(ball / width), mode="constant")
    return np.where(spread > 0.0, spread, np.nan), half * unit


def _sphere(radius: float) -> np.ndarray:
    """Return the share of a sphere's volume in each pixel of its cross-section, (n, n); its radius
    in pixels."""
    side = np.arange(-np.ceil(radius), np.ceil(radius) + 1.0)
    square = radius**2 - side[:, None] ** 2 - side[None, :] ** 2
    height = np.sqrt(np.maximum(square, 0.0))
    return height / height.sum()


def _unit(charge: Charge) -> float:
    """Return R - a over R."""
    return unit_length(charge.case) / charge.case.mill.radius_m


def _draw_row(row: Sequence[Any], charge: Charge, mill_angles: Sequence[float]) -> None:
    case, folder = charge.case, charge.folder
    radius = case.mill.radius_m
    first = first_dump(folder)
    near = snapshots_near(folder, mill_angles)
    for axes, angle in zip(row, mill_angles, strict=True):
        snapshot = min(near, key=lambda s: abs(s.mill_angle - angle))
        axes.plot(*(liner_outline(case, snapshot.mill_angle) / radius).T, color="#555", lw=0.6)
        if abs(snapshot.mill_angle - angle) > SAME_ANGLE:
            axes.text(0, 0, "no dump", ha="center", va="center", color="#777")
            continue
        dump = read_dump(snapshot.path)
        try:
            rising = starts_on_rising_side(dump, first)
        except ValueError as error:
            raise RunFolderError(snapshot.path, str(error), "run the case again") from None
        white = np.full((PIXELS, PIXELS, 3), 255, np.uint8)
        picture = ball_picture(dump, colours_by_side(rising), radius, white, VIEW)
        axes.imshow(picture, extent=(-VIEW, VIEW, -VIEW, VIEW), interpolation="antialiased")
