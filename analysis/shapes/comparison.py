"""Distances of contours and overlaps of regions, in coordinates over R - a."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import cKDTree

SPACING = 5e-4  # between the points that replace a line; a distance is too large by half at most


def curve_distances(
    first: Sequence[np.ndarray], second: Sequence[np.ndarray]
) -> tuple[float, float]:
    """Return the symmetric mean and largest distance of two curves of one or more lines.

    Mean: of the distance to the other curve along each curve, averaged over both. Largest:
    the Hausdorff distance, the farthest that a point of either lies from the other.

    Args:
        first, second: lines, each (n, 2) float.

    Raises:
        ValueError: a curve without a line.
    """
    points = [points_along(curve) for curve in (first, second)]
    there = cKDTree(points[1]).query(points[0])[0]
    back = cKDTree(points[0]).query(points[1])[0]
    return float(0.5 * (there.mean() + back.mean())), float(max(there.max(), back.max()))


def points_along(curve: Sequence[np.ndarray], spacing: float = SPACING) -> np.ndarray:
    """Return points (n, 2) evenly along the lines of a curve."""
    if not len(curve):
        raise ValueError("a curve without a line has no distance to another")
    points = []
    for line in curve:
        travelled = np.append(0.0, np.cumsum(np.hypot(*np.diff(line, axis=0).T)))
        places = np.linspace(0.0, travelled[-1], max(2, int(travelled[-1] / spacing) + 2))
        points.append(np.column_stack([np.interp(places, travelled, c) for c in line.T]))
    return np.vstack(points)


def overlap(first: np.ndarray, second: np.ndarray, where: np.ndarray | bool = True) -> float | None:
    """Return the intersection over union of two regions on one grid; None if both are empty.

    Args:
        first, second: (n, n) bool.
        where: part of the grid that counts.
    """
    union = np.sum((first | second) & where)
    return float(np.sum(first & second & where) / union) if union else None
