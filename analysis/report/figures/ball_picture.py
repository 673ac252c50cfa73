"""A view of balls and liner along the mill axis.

Balls are drawn into an array of pixels, so that 231,461 of them take part of a second and no
graphics library is needed.
"""

from __future__ import annotations

import numpy as np
from PIL import Image, ImageDraw

from millscale.analysis.shapes.cross_section import liner_outline
from millscale.runs.case_file import Case
from millscale.runs.dumps import Dump

RISING, FALLING = (200, 50, 43), (36, 88, 179)  # red and blue by the starting side, x < 0, x >= 0
WALL = (122, 130, 139)
WALL_THICKNESS = 0.03  # drawn, over R
VIEW = 1.06  # half width of a picture over R
PIXELS = 600
SMOOTH = 3  # pixels along each side of the wall's pixel
DARKEST = 0.45  # of a ball's colour, at its rim


def colours_by_side(rising: np.ndarray) -> np.ndarray:
    """Return the colour of balls by whether they started on the rising side, (n, 3) uint8."""
    return np.array([FALLING, RISING], np.uint8)[rising.astype(int)]


def wall_picture(case: Case, mill_angle: float, pixels: int = PIXELS) -> np.ndarray:
    """Return the liner turned by the mill angle as a band, (pixels, pixels, 3) uint8."""
    fine = SMOOTH * pixels
    scale = 0.5 * fine / (VIEW * case.mill.radius_m)
    picture = Image.new("RGB", (fine, fine), "white")
    draw = ImageDraw.Draw(picture)
    middle, outer = 0.5 * fine, (1.0 + WALL_THICKNESS) * case.mill.radius_m * scale
    draw.ellipse([middle - outer, middle - outer, middle + outer, middle + outer], fill=WALL)
    outline = middle + scale * liner_outline(case, mill_angle) * (1.0, -1.0)
    draw.polygon([tuple(point) for point in outline], fill="white")
    return np.asarray(picture.reduce(SMOOTH))


def ball_picture(
    dump: Dump, colours: np.ndarray, radius: float, background: np.ndarray, view: float = VIEW
) -> np.ndarray:
    """Return a view along the mill axis: x to the right, z up; of balls behind each other the one
    with the smallest y is seen.

    Args:
        colours: (n, 3) uint8, of each ball.
        radius: of the mill [m].
        background: (pixels, pixels, 3) uint8, where no ball is.
        view: half width of the picture over the radius.
    """
    pixels = len(background)
    size = 2.0 * view * radius / pixels
    column = (dump["x"] + view * radius) / size
    row = (view * radius - dump["z"]) / size
    reach = dump["radius"] / size
    picture = background.reshape(-1, 3).copy()
    nearest = np.full(pixels * pixels, -1)
    rank = np.empty(len(dump), int)
    rank[np.argsort(-dump["y"], kind="stable")] = np.arange(len(dump))
    at_row, at_column = (np.floor(x).astype(int) for x in (row, column))
    widest = int(np.ceil(reach.max()))
    for down in range(-widest, widest + 1):
        for right in range(-widest, widest + 1):
            i, j = at_row + down, at_column + right
            off = np.hypot(i + 0.5 - row, j + 0.5 - column) / np.maximum(reach, 0.75)
            drawn = np.flatnonzero((off <= 1.0) & (i >= 0) & (i < pixels) & (j >= 0) & (j < pixels))
            place = i[drawn] * pixels + j[drawn]
            np.maximum.at(nearest, place, rank[drawn])
            seen = nearest[place] == rank[drawn]
            place, drawn = place[seen], drawn[seen]
            shade = DARKEST + (1.0 - DARKEST) * np.sqrt(1.0 - off[drawn] ** 2)
            picture[place] = colours[drawn] * shade[:, None]
    return picture.reshape(background.shape)
