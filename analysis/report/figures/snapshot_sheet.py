"""All scaled mills of a scheme at the same mill angles in one sheet (Figs. 9, 10).

Balls are drawn into an array of pixels, so that 231,461 of them take part of a second and no
graphics library is needed.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

from millscale.analysis.finished import Charge
from millscale.analysis.shapes.cross_section import liner_outline
from millscale.analysis.shapes.shape import SAME_ANGLE
from millscale.analysis.shapes.snapshots import first_dump, snapshots_near, starts_on_rising_side
from millscale.report.figures.style import STYLE
from millscale.runs.dumps import Dump, read_dump
from millscale.runs.untrusted import RunFolderError

RISING, FALLING = (200, 50, 43), (36, 88, 179)  # red and blue by the starting side, x < 0, x >= 0
PIXELS = 420
VIEW = 1.04  # half width of a picture over R
DARKEST = 0.45  # of a ball's colour, at its rim


def snapshot_sheet(charges: Sequence[Charge], mill_angles: Sequence[float]) -> Figure:
    """Return a row for each charge, a column for each mill angle [rad]; a panel without a dump at
    that angle has a note.

    Raises:
        RunFolderError: a case without dumps.
    """
    with rc_context(STYLE):
        size = (1.75 * len(mill_angles) + 0.5, 1.75 * len(charges) + 0.3)
        figure = Figure(figsize=size, layout="constrained")
        rows = figure.subplots(len(charges), len(mill_angles), squeeze=False)
        for row, charge in zip(rows, charges, strict=True):
            row[0].set_ylabel(f"{charge.label}\n{charge.balls:,} balls")
            _draw_row(row, charge, mill_angles)
        for axes, angle in zip(rows[0], mill_angles, strict=True):
            axes.set_title(f"{angle:.4g} rad", fontsize=9.5)
    return figure


def ball_picture(dump: Dump, rising: np.ndarray, radius: float, pixels: int = PIXELS) -> np.ndarray:
    """Return a view along the mill axis, (pixels, pixels, 3) uint8: x to the right, z up, white
    where no ball is; of balls behind each other the one with the smallest y is seen.

    Args:
        rising: (n,) bool, balls in red.
        radius: of the mill [m].
    """
    size = 2.0 * VIEW * radius / pixels
    column = (dump["x"] + VIEW * radius) / size
    row = (VIEW * radius - dump["z"]) / size
    reach = dump["radius"] / size
    picture = np.full((pixels * pixels, 3), 255, np.uint8)
    colour = np.where(rising[:, None], RISING, FALLING).astype(float)
    far_first = np.argsort(-dump["y"], kind="stable")
    nearest = np.full(pixels * pixels, -1)
    rank = np.empty(len(dump), int)
    rank[far_first] = np.arange(len(dump))
    widest = int(np.ceil(reach.max()))
    for down in range(-widest, widest + 1):
        for right in range(-widest, widest + 1):
            i, j = np.floor(row).astype(int) + down, np.floor(column).astype(int) + right
            off = np.hypot(i + 0.5 - row, j + 0.5 - column) / np.maximum(reach, 0.75)
            drawn = (off <= 1.0) & (i >= 0) & (i < pixels) & (j >= 0) & (j < pixels)
            place = i[drawn] * pixels + j[drawn]
            np.maximum.at(nearest, place, rank[drawn])
            seen = nearest[place] == rank[drawn]
            shade = DARKEST + (1.0 - DARKEST) * np.sqrt(1.0 - off[drawn][seen] ** 2)
            picture[place[seen]] = colour[drawn][seen] * shade[:, None]
    return picture.reshape(pixels, pixels, 3)


def _draw_row(row: Sequence[Any], charge: Charge, mill_angles: Sequence[float]) -> None:
    case, folder = charge.case, charge.folder
    radius = case.mill.radius_m
    first = first_dump(folder)
    near = snapshots_near(folder, mill_angles)
    for axes, angle in zip(row, mill_angles, strict=True):
        axes.set(xticks=[], yticks=[], aspect="equal")
        axes.spines[:].set_visible(False)
        axes.grid(False)
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
        picture = ball_picture(dump, rising, radius)
        axes.imshow(picture, extent=(-VIEW, VIEW, -VIEW, VIEW), interpolation="antialiased")
