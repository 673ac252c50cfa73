"""Solid fraction of a charge over its cross-section, on one grid for all mills.

Lengths are over R - a, mill radius less mean ball radius, so that similar mills coincide.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from matplotlib.path import Path as Polygon
from scipy.ndimage import gaussian_filter

RESOLUTION = (
    0.02  # standard deviation of the kernel; a ball diameter is 0.027 at the paper's S = 2.6
)
CELLS_PER_RESOLUTION = 3
HALF_WIDTH = 1.1  # of the grid; the liner reaches R / (R - a), 1.014 at S = 2.6
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Grid:
    """A square grid of the cross-section, [x, z] over R - a.

    Attributes:
        resolution: standard deviation of the Gaussian kernel, over R - a.
    """

    resolution: float = RESOLUTION

    @cached_property
    def step(self) -> float:
        """Return the distance of neighbouring nodes."""
        return 2.0 * HALF_WIDTH / (self.nodes.size - 1)

    @cached_property
    def nodes(self) -> np.ndarray:
        """Return the nodes along each axis, (n,) float."""
        cells = int(np.ceil(2.0 * HALF_WIDTH * CELLS_PER_RESOLUTION / self.resolution))
        return np.linspace(-HALF_WIDTH, HALF_WIDTH, cells + 1)

    def inside(self, outline: np.ndarray) -> np.ndarray:
        """Return which nodes are inside a closed polygon (m, 2), (n, n) bool [z, x].

        Nodes nearer to the origin than the polygon are inside or outside as the origin is.
        """
        polygon = Polygon(outline)
        low, high = outline.min(axis=0), outline.max(axis=0)
        begin = np.searchsorted(self.nodes, low, side="left")
        end = np.searchsorted(self.nodes, high, side="right")
        columns, rows = (slice(*ends) for ends in zip(begin, end, strict=True))
        x, z = np.meshgrid(self.nodes[columns], self.nodes[rows])
        in_box = np.full(x.shape, polygon.contains_point((0.0, 0.0)))
        far = np.hypot(x, z) >= (1.0 - _ROUNDING) * _distance_from_origin(outline)
        in_box[far] = polygon.contains_points(np.column_stack([x[far], z[far]]))
        found = np.zeros(2 * self.nodes.shape, bool)
        found[rows, columns] = in_box
        return found

    def smooth(self, values: np.ndarray) -> np.ndarray:
        """Return values (n, n) at the nodes, averaged by the kernel."""
        return gaussian_filter(values, self.resolution / self.step, mode="constant", truncate=5.0)


def solid_fraction(centres: np.ndarray, areas: np.ndarray, grid: Grid) -> np.ndarray:
    """Return the solid fraction averaged along the axis and by a Gaussian kernel, (n, n) float [z,
    x].

    phi(p) = sum_i A_i exp(-|p - p_i|^2 / 2 w^2) / (2 pi w^2), A_i = V_i / (L (R - a)^2): each
    ball's volume V_i, spread along the length L and by the kernel of width w. Balls are first
    shared among the four nodes around them, which keeps volume and centre and widens the kernel by
    the step / sqrt(6), 0.9 % of w here.

    Args:
        centres: (m, 2) float [x, z] over R - a.
        areas: (m,) float, A_i.
    """
    count, place = grid.nodes.size, (centres - grid.nodes[0]) / grid.step
    low = np.clip(np.floor(place).astype(int), 0, count - 2)
    share = np.clip(place - low, 0.0, 1.0)
    total = np.zeros(count * count)
    for right in (0, 1):
        for up in (0, 1):
            weight = np.abs(1 - right - share[:, 0]) * np.abs(1 - up - share[:, 1])
            node = (low[:, 1] + up) * count + low[:, 0] + right
            total += np.bincount(node, areas * weight, minlength=total.size)
    return grid.smooth(total.reshape(count, count)) / grid.step**2


def value_at(field: np.ndarray, points: np.ndarray, grid: Grid) -> np.ndarray:
    """Return the values (m,) of a field (n, n) at the nodes nearest to points (m, 2)."""
    column, row = np.rint((points - grid.nodes[0]) / grid.step).astype(int).T
    last = grid.nodes.size - 1
    return field[np.clip(row, 0, last), np.clip(column, 0, last)]


def _distance_from_origin(outline: np.ndarray) -> float:
    """Return the distance of the origin from a closed polygon (m, 2)."""
    side = np.roll(outline, -1, axis=0) - outline
    squared = (side**2).sum(axis=1)
    along = -(outline * side).sum(axis=1) / np.where(squared > 0.0, squared, 1.0)
    return float(np.hypot(*(outline + np.clip(along, 0.0, 1.0)[:, None] * side).T).min())
