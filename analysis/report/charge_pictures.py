"""Pictures of a charge, after Figs. 9 and 10."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.colors import to_rgb
from PIL import Image

from millscale.analysis.shapes.snapshots import (
    class_of_each,
    first_dump,
    snapshots_near,
    starts_on_rising_side,
)
from millscale.report.ball_classes import colours_of_classes
from millscale.report.figures.ball_picture import ball_picture, colours_by_side, wall_picture
from millscale.runs.case_file import Case, load_case
from millscale.runs.dumps import Dump, read_dump
from millscale.runs.untrusted import RunFolderError
from millscale.runs.writing import writing_by_name


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
