"""Balls and liner of a charge as meshes of the drawing library."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyvista as pv

from millscale.analysis.shapes.cross_section import turned
from millscale.exports.columns import plain_name
from millscale.runs.dumps import Dump
from millscale.runs.untrusted import check_regular

POSITION, VELOCITY = ("x", "y", "z"), ("vx", "vy", "vz")


def ball_points(dump: Dump, rising: np.ndarray) -> pv.PolyData:
    """Return the balls of a dump as points.

    Point data, SI units: the columns of the dump under the names of `columns.plain_name`,
    `velocity` (n, 3), `speed`, and `rising`, 1 for balls that started on the rising side.

    Args:
        rising: (n,) bool.
    """
    cloud = pv.PolyData(dump.positions)
    if all(name in dump.columns for name in VELOCITY):
        velocity = np.column_stack([dump[name] for name in VELOCITY])
        cloud["velocity"] = velocity
        cloud["speed"] = np.linalg.norm(velocity, axis=1)
    for name, values in dump.columns.items():
        if name not in (*POSITION, *VELOCITY):
            cloud[plain_name(name)] = values
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
