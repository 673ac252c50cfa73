"""Distances of contours and overlaps of regions, in coordinates over R - a."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import cKDTree

SPACING = 5e-4  # between the points that replace a line; a distance is too large by half at most
NORMAL_SPACING = 0.01  # between the points of a surface at which its normal is taken
# Half of the chord that gives a normal: that of the line itself turns with single balls.
HALF_CHORD = 0.05
FARTHEST = 0.3  # along a normal; beyond it the other surface is another part of the charge


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


def distance_along_normal(
    reference: Sequence[np.ndarray], other: Sequence[np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Return how far a surface lies from a reference, along the normal of the reference.

    The normal is that of a chord of 2 HALF_CHORD.

    Args:
        reference, other: lines, each (n, 2) float [x, z]; the longest line of the reference counts.

    Returns:
        Position along the reference from its right end, the toe, (m,) float; signed distance there,
        (m,) float: positive towards the air, NaN where no line lies within FARTHEST.

    Raises:
        ValueError: the reference has no line.
    """
    if not len(reference):
        raise ValueError("a surface without a line has no normal")
    line = max(reference, key=lambda one: np.hypot(*np.diff(one, axis=0).T).sum())
    line = line if line[0, 0] >= line[-1, 0] else line[::-1]
    points = points_along([line], NORMAL_SPACING)
    along = np.append(0.0, np.cumsum(np.hypot(*np.diff(points, axis=0).T)))
    ahead, behind = (
        np.column_stack([np.interp(along + side * HALF_CHORD, along, c) for c in points.T])
        for side in (1.0, -1.0)
    )
    chord = ahead - behind
    # From the toe to the shoulder the bed is on the left and the air on the right.
    normal = np.column_stack([chord[:, 1], -chord[:, 0]]) / np.hypot(*chord.T)[:, None]
    begin = np.vstack([one[:-1] for one in other] or [np.empty((0, 2))])
    side = np.vstack([np.diff(one, axis=0) for one in other] or [np.empty((0, 2))])
    if not len(begin):
        return along, np.full(along.size, np.nan)
    return along, _nearest_crossing(points, normal, begin, side)


def _nearest_crossing(
    points: np.ndarray, normal: np.ndarray, begin: np.ndarray, side: np.ndarray
) -> np.ndarray:
    """Return the smallest signed distance (m,) along normals from points (m, 2) to line segments
    (k, 2); NaN without one within FARTHEST."""
    offset = begin[None] - points[:, None]
    turned = normal[:, None, 0] * side[None, :, 1] - normal[:, None, 1] * side[None, :, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = (offset[..., 0] * side[None, :, 1] - offset[..., 1] * side[None, :, 0]) / turned
        share = (offset[..., 0] * normal[:, None, 1] - offset[..., 1] * normal[:, None, 0]) / turned
    met = (share >= 0.0) & (share <= 1.0) & (np.abs(distance) <= FARTHEST)
    nearest = np.argmin(np.where(met, np.abs(distance), np.inf), axis=1)
    rows = np.arange(len(points))
    return np.where(met[rows, nearest], distance[rows, nearest], np.nan)
