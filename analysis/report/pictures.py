"""Balls and liner of a charge as meshes, for ParaView and for views in 3-D."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyvista as pv

from millscale.analysis.shapes.cross_section import turned
from millscale.runs.dumps import Dump
from millscale.runs.untrusted import check_regular
from millscale.runs.writing import writing_by_name

WALL = "#7a828b"


def ball_points(dump: Dump, rising: np.ndarray) -> pv.PolyData:
    """Return the balls of a dump as points.

    Point data: every column of the dump but the positions, `velocity` (n, 3), and `rising`, 1 for
    balls that started on the rising side.

    Args:
        rising: (n,) bool.
    """
    cloud = pv.PolyData(dump.positions)
    velocity = [dump.columns[name] for name in ("vx", "vy", "vz") if name in dump.columns]
    if len(velocity) == 3:
        cloud["velocity"] = np.column_stack(velocity)
    for name, values in dump.columns.items():
        if name not in ("x", "y", "z", "vx", "vy", "vz"):
            cloud[name] = values
    cloud["rising"] = rising.astype(np.uint8)
    return cloud


def turned_liner(liner: Path, mill_angle: float) -> pv.PolyData:
    """Return a liner mesh, turned by the mill angle [rad], with its data.

    Raises:
        RunFolderError: the mesh is missing.
    """
    check_regular(liner, "millscale run FILE --runs DIR --only ID")
    mesh = pv.read(liner)
    mesh.points[:, [0, 2]] = turned(mesh.points[:, [0, 2]], mill_angle)
    return mesh


def save_balls(dump: Dump, rising: np.ndarray, path: Path) -> None:
    """Write `ball_points` for ParaView (VTK PolyData)."""
    _save_whole(ball_points(dump, rising), path)


def save_liner(liner: Path, mill_angle: float, path: Path) -> None:
    """Write `turned_liner` for ParaView (VTK PolyData)."""
    _save_whole(turned_liner(liner, mill_angle), path)


def _save_whole(mesh: pv.PolyData, path: Path) -> None:
    with writing_by_name(path) as part:
        mesh.save(part)
