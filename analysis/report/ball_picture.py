"""Pictures of a charge along the mill axis, after Figs. 9 and 10.

Balls are drawn into an array of pixels, so that 231,461 of them take part of a second and no
graphics library is needed.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.colors import to_rgb
from PIL import Image, ImageDraw

from millscale.analysis.shapes.cross_section import liner_outline
from millscale.analysis.shapes.snapshots import (
    class_of_each,
    first_dump,
    snapshots_near,
    starts_on_rising_side,
)
from millscale.report.ball_classes import colours_of_classes
from millscale.runs.case_file import Case
from millscale.runs.case_folder import load_case
from millscale.runs.dumps import Dump, read_dump
from millscale.runs.untrusted import RunFolderError
from millscale.runs.writing import writing_by_name

RISING, FALLING = (200, 50, 43), (36, 88, 179)  # red and blue by the starting side, x < 0, x >= 0
WALL = (122, 130, 139)
WALL_THICKNESS = 0.03  # drawn, over R
VIEW = 1.06  # half width of a picture over R
PIXELS = 600
SMOOTH = 3  # pixels along each side of the wall's pixel
DARKEST = 0.45  # of a ball's colour, at its rim


def draw_pictures(folder: Path, mill_angles: Sequence[float], to: Path) -> list[tuple[Path, float]]:
    """Draw a case near mill angles [rad]; returns each picture with its mill angle.

    Balls are coloured by class, or by their starting side if all are of one class.

    Args:
        to: folder of the pictures, <case>-<angle in mrad>.png.

    Raises:
        RunFolderError: files are missing or damaged.
    """
    case, first = load_case(folder), first_dump(folder)
    drawn = []
    for snapshot in snapshots_near(folder, mill_angles):
        dump = read_dump(snapshot.path)
        try:
            colours = colours_of_balls(dump, first, case)
        except ValueError as error:
            raise RunFolderError(snapshot.path, str(error), "run the case again") from None
        wall = wall_picture(case, snapshot.mill_angle)
        picture = ball_picture(dump, colours, case.mill.radius_m, wall)
        path = to / f"{folder.name}-{1e3 * snapshot.mill_angle:05.0f}.png"
        with writing_by_name(path) as part:
            Image.fromarray(picture).save(part, "PNG")
        drawn.append((path, snapshot.mill_angle))
    return drawn


def colours_of_balls(dump: Dump, first: Dump, case: Case) -> np.ndarray:
    """Return the colour of each ball, (n, 3) uint8: of its class, or of its starting side if all
    balls are of one class.

    Raises:
        ValueError: a ball is of no class, or not in the first dump.
    """
    if case.ball.classes:
        colours = [to_rgb(colour) for colour in colours_of_classes(case.ball)]
        kinds = class_of_each(dump, len(case.ball.classes))
        return np.round(255.0 * np.array(colours)).astype(np.uint8)[kinds]
    return colours_by_side(starts_on_rising_side(dump, first))


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
