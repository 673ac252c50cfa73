"""Draw the pictures of a case in a separate process.

Without a graphics library the drawing toolkit does not raise an error, it crashes.
"""

from __future__ import annotations

import multiprocessing
import os
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import BinaryIO

from millscale.analysis.shapes.snapshots import Snapshot, snapshots_near
from millscale.runs.untrusted import RunFolderError

TIME_LIMIT_S = 600


def draw_pictures(folder: Path, mill_angles: Sequence[float], to: Path) -> list[tuple[Path, float]]:
    """Draw a case near mill angles [rad]; returns each picture with its mill angle.

    Drawing is in a child process, since without a graphics library the toolkit crashes. The child
    is forked after the toolkit is loaded, which takes longer than to draw a picture.

    Args:
        to: folder of the pictures, <case>-<angle in mrad>.png.

    Raises:
        RunFolderError: files are missing, or drawing failed.
    """
    chosen = snapshots_near(folder, mill_angles)
    pictures = [(to / f"{folder.name}-{1e3 * s.mill_angle:05.0f}.png", s) for s in chosen]
    _load()
    with tempfile.TemporaryFile() as errors:
        child = multiprocessing.get_context("fork").Process(
            target=_draw, args=(folder, pictures, errors)
        )
        child.start()
        child.join(TIME_LIMIT_S)
        if child.is_alive():
            child.kill()
            child.join()
            raise RunFolderError(folder, f"drawing took over {TIME_LIMIT_S} s", _INSTALL)
        errors.seek(0)
        text = errors.read().decode("utf-8", errors="replace")
    if child.exitcode != 0 or not all(path.exists() for path, _ in pictures):
        message = (text.strip().splitlines() or ["no message"])[-1]
        cause = f"drawing failed (exit code {child.exitcode}): {message}"
        raise RunFolderError(folder, cause, _INSTALL)
    return [(path, s.mill_angle) for path, s in pictures]


_INSTALL = (
    "off-screen pictures need OpenGL without a screen: "
    "apt-get install libegl1 libgl1-mesa-dri (or libosmesa6)"
)


def _load() -> None:
    """Load the toolkit, which opens no window."""
    import pyvista.plotting  # noqa: F401

    import millscale.report.pictures  # noqa: F401


def _draw(folder: Path, pictures: Sequence[tuple[Path, Snapshot]], errors: BinaryIO) -> None:
    """Draw pictures in the child, whose output goes to `errors`."""
    from millscale.report.pictures import draw_all

    for descriptor in (1, 2):
        os.dup2(errors.fileno(), descriptor)
    # Off-screen without a display server, unless the user has chosen another window.
    os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
    try:
        draw_all(folder, pictures)
    except ValueError as error:
        errors.write(str(error).encode())
        errors.flush()
        sys.exit(1)
