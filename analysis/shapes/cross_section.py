"""Cross-section of the liner as a closed line."""

from __future__ import annotations

import numpy as np

from millscale.runs.case_file import Case
from millscale.runs.liner import liner_of


def liner_outline(case: Case, mill_angle: float) -> np.ndarray:
    """Return the closed outline of the liner of a case, turned by the mill angle; (n, 2) float [x,
    z] in m.

    Args:
        mill_angle: positive turns the bottom towards -x [rad].
    """
    liner = liner_of(case.mill)
    nodes, _ = liner.polygon(1e-3 * liner.radius)
    return turned(np.vstack([nodes, nodes[:1]]), mill_angle)


def groove_box(case: Case) -> np.ndarray | None:
    """Return the closed outline of the monitoring box, which contains groove 0 at rest; (5, 2)
    float [x, z] in m. None for a plain drum, and for a liner without a groove."""
    liner = liner_of(case.mill)
    if not liner.has_groove:
        return None
    corners = np.asarray(liner.groove_box())
    return np.vstack([corners, corners[:1]])


def turned(points: np.ndarray, mill_angle: float) -> np.ndarray:
    """Return points (n, 2) [x, z] turned with the mill by an angle [rad], about +y."""
    c, s = np.cos(mill_angle), np.sin(mill_angle)
    x, z = points.T
    return np.column_stack([x * c + z * s, z * c - x * s])
