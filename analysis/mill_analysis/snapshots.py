"""Which dumps of a multi-ball case to draw, and drawing them in a process of its own."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mill_analysis.dumps import Dump, read_dump, required_dumps
from mill_analysis.run_folder import SERIES, RunFolderError
from mill_analysis.series import Series, read_series

TIME_LIMIT_S = 600


@dataclass(frozen=True)
class Snapshot:
    """The dump nearest to a mill angle.

    Attributes:
        mill_angle: at the dump [rad].
    """

    path: Path
    mill_angle: float


def snapshots_near(folder: Path, mill_angles: Sequence[float]) -> list[Snapshot]:
    """The dump nearest to each mill angle [rad], each dump once, in order.

    The angle of a dump follows from its step and the series.

    Raises:
        RunFolderError: no dumps, or no series.
    """
    files = required_dumps(folder)
    series = read_series(folder / SERIES, "multi-ball")
    angles = mill_angle_at(np.array(list(files), float), series)
    paths = list(files.values())
    nearest = sorted({int(np.argmin(np.abs(angles - angle))) for angle in mill_angles})
    return [Snapshot(paths[i], float(angles[i])) for i in nearest]


def mill_angle_at(steps: np.ndarray, series: Series) -> np.ndarray:
    """Mill angle [rad] at steps of a multi-ball series, (n,) float.

    The mill turns evenly; before the first row, where the first dump lies, it is extrapolated.
    """
    step, angle = series["step"], series["mill_angle_rad"]
    slope = (angle[-1] - angle[0]) / (step[-1] - step[0])
    return np.maximum(0.0, angle[0] + slope * (steps - step[0]))


def starts_on_rising_side(dump: Dump, first: Dump) -> np.ndarray:
    """(n,) bool for the balls of `dump`: whether they were at x < 0 in the first dump.

    Raises:
        ValueError: a ball is not in the first dump.
    """
    row = np.searchsorted(first["id"], dump["id"])
    known = row < len(first)
    known[known] = first["id"][row[known]] == dump["id"][known]
    if not known.all():
        strange = dump["id"][~known][0]
        raise ValueError(f"ball {strange:.0f} of step {dump.step} is not in step {first.step}")
    return first["x"][row] < 0.0


def first_dump(folder: Path) -> Dump:
    """The dump before the rotation, whose positions give the balls their colours."""
    return read_dump(next(iter(required_dumps(folder).values())))


def draw_pictures(folder: Path, mill_angles: Sequence[float], to: Path) -> list[tuple[Path, float]]:
    """Draw a case near mill angles [rad]; returns each picture with its mill angle.

    In a process of its own: without a graphics library the drawing toolkit does not raise, it
    crashes.

    Args:
        to: folder of the pictures, <case>-<angle in mrad>.png.

    Raises:
        RunFolderError: files are missing, or drawing failed.
    """
    chosen = snapshots_near(folder, mill_angles)
    pictures = [(to / f"{folder.name}-{1e3 * s.mill_angle:05.0f}.png", s) for s in chosen]
    jobs = [word for path, s in pictures for word in (str(s.path), f"{s.mill_angle!r}", str(path))]
    command = [sys.executable, "-m", "mill_analysis.pictures", str(folder), *jobs]
    # Off-screen without a display server, unless the user has chosen another window.
    environment = {"VTK_DEFAULT_OPENGL_WINDOW": "vtkEGLRenderWindow", **os.environ}
    try:
        done = subprocess.run(
            command,
            env=environment,
            capture_output=True,
            encoding="utf-8",
            errors="replace",
            timeout=TIME_LIMIT_S,
        )
    except subprocess.TimeoutExpired:
        raise RunFolderError(folder, f"drawing took over {TIME_LIMIT_S} s", _INSTALL) from None
    if done.returncode != 0 or not all(path.exists() for path, _ in pictures):
        said = (done.stderr.strip().splitlines() or ["no message"])[-1]
        cause = f"drawing failed (exit code {done.returncode}): {said}"
        raise RunFolderError(folder, cause, _INSTALL)
    return [(path, s.mill_angle) for path, s in pictures]


_INSTALL = (
    "off-screen pictures need OpenGL without a screen: "
    "apt-get install libegl1 libgl1-mesa-dri (or libosmesa6)"
)
