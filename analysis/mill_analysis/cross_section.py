"""The liner's cross-section as a line to draw."""

from __future__ import annotations

from typing import Any

import mill_core
import numpy as np


def liner_outline(case: dict[str, Any], mill_angle: float) -> np.ndarray:
    """Closed outline of the liner of a case, turned by the mill angle; (n, 2) float [x, z] in m.

    Args:
        mill_angle: positive turns the bottom towards -x [rad].
    """
    mill = case["mill"]
    widths = ("lifter_top_radius_m", "lifter_top_width_m", "groove_width_m")
    liner = mill_core.Liner(
        mill["radius_m"],
        *(mill[width] if mill["lifters"] else 0.0 for width in widths),
        mill["lifters"],
        mill["phase_rad"],
    )
    nodes, _ = liner.polygon(1e-3 * mill["radius_m"])
    return turned(np.vstack([nodes, nodes[:1]]), mill_angle)


def turned(points: np.ndarray, mill_angle: float) -> np.ndarray:
    """Points (n, 2) [x, z] turned with the mill by an angle [rad], about +y."""
    c, s = np.cos(mill_angle), np.sin(mill_angle)
    x, z = points.T
    return np.column_stack([x * c + z * s, z * c - x * s])
