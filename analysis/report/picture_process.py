"""Draw the pictures of a case in a separate process.

Without a graphics library the drawing toolkit does not raise an error, it crashes.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from millscale.analysis.shapes.snapshots import snapshots_near
from millscale.runs.untrusted import RunFolderError

TIME_LIMIT_S = 600


def draw_pictures(folder: Path, mill_angles: Sequence[float], to: Path) -> list[tuple[Path, float]]:
    """Draw a case near mill angles [rad]; returns each picture with its mill angle.

    Drawing is in a separate process, since without a graphics library the toolkit crashes.

    Args:
        to: folder of the pictures, <case>-<angle in mrad>.png.

    Raises:
        RunFolderError: files are missing, or drawing failed.
    """
    chosen = snapshots_near(folder, mill_angles)
    pictures = [(to / f"{folder.name}-{1e3 * s.mill_angle:05.0f}.png", s) for s in chosen]
    jobs = [word for path, s in pictures for word in (str(s.path), f"{s.mill_angle!r}", str(path))]
    command = [sys.executable, "-m", "millscale.report.pictures", str(folder), *jobs]
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
        message = (done.stderr.strip().splitlines() or ["no message"])[-1]
        cause = f"drawing failed (exit code {done.returncode}): {message}"
        raise RunFolderError(folder, cause, _INSTALL)
    return [(path, s.mill_angle) for path, s in pictures]


_INSTALL = (
    "off-screen pictures need OpenGL without a screen: "
    "apt-get install libegl1 libgl1-mesa-dri (or libosmesa6)"
)
