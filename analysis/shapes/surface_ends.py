"""Toe and shoulder of a charge: where the surface of the bed meets a circle inside the lifter tops.

The circle is the same share of the mill radius at every S. A ring of a fixed number of balls is a
different share at every S, and its balls are those that the lifters hold. Derived here;
docs/theory/charge-shape.md.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from millscale.analysis.shapes.contour import Contour
from millscale.analysis.shapes.solid_fraction import Grid, value_at

# Points of an arc that show whether it runs through the bed.
_SAMPLES = np.linspace(0.05, 0.95, 19)


@dataclass(frozen=True)
class SurfaceEnds:
    """Ends of the surface, from the vertical (the top), positive on the rising side.

    Attributes:
        toe: counted on from the shoulder, down the rising side and through the bottom [rad].
        shoulder: in (-pi, pi] [rad].
    """

    toe: float
    shoulder: float


def surface_ends(contour: Contour, grid: Grid, radius: float) -> SurfaceEnds | None:
    """Return toe and shoulder; None if the surface does not reach the circle at both ends.

    From its point nearest to the axis the longest line of the surface is followed both ways to
    where it first meets the circle. The bed lies between the two points, from the toe in the
    direction of rotation to the shoulder.

    Args:
        radius: of the circle about the axis, over R - a.
    """
    if not contour.lines:
        return None
    line = max(contour.lines, key=_length)
    middle = int(np.argmin(np.hypot(*line.T)))
    one, other = (_first_crossing(part, radius) for part in (line[middle::-1], line[middle:]))
    if one is None or other is None:
        return None
    first, second = (float(np.arctan2(-x, z)) for x, z in (one, other))
    both = SurfaceEnds(_above(second, first), first), SurfaceEnds(_above(first, second), second)
    return max(both, key=lambda found: _share_in_bed(found, contour, grid, radius))


def _first_crossing(part: np.ndarray, radius: float) -> np.ndarray | None:
    """Return the first point (2,) of a line that lies on a circle; None if the line is inside."""
    distance = np.hypot(*part.T)
    outside = np.flatnonzero(distance >= radius)
    if not len(outside) or outside[0] == 0:
        return None
    i = outside[0]
    share = (radius - distance[i - 1]) / (distance[i] - distance[i - 1])
    return part[i - 1] + share * (part[i] - part[i - 1])


def _above(angle: float, other: float) -> float:
    """Return an angle in (other, other + 2 pi] [rad]."""
    return other + 2.0 * np.pi - (other - angle) % (2.0 * np.pi)


def _share_in_bed(ends: SurfaceEnds, contour: Contour, grid: Grid, radius: float) -> float:
    angle = ends.shoulder + _SAMPLES * (ends.toe - ends.shoulder)
    points = radius * np.column_stack([-np.sin(angle), np.cos(angle)])
    return float(np.mean(value_at(contour.inside, points, grid)))


def _length(line: np.ndarray) -> float:
    return float(np.hypot(*np.diff(line, axis=0).T).sum())
