"""Surface contour of a charge (Fig. 11): where the solid fraction is half that of the bed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from contourpy import contour_generator
from scipy.ndimage import label

from millscale.analysis.shapes.solid_fraction import Grid, solid_fraction, value_at

LEAST_COVER = 0.5  # share of the kernel inside the liner; nodes with less are not used


@dataclass(frozen=True)
class Contour:
    """Free surface of the bed.

    Attributes:
        lines: each (m, 2) float [x, z] over R - a, from liner to liner or closed.
        bulk_fraction: solid fraction of the bed.
        inside: (n, n) bool [z, x]: grid nodes in the bed.
    """

    lines: list[np.ndarray]
    bulk_fraction: float
    inside: np.ndarray


def surface_contour(
    centres: np.ndarray, areas: np.ndarray, outline: np.ndarray, grid: Grid
) -> Contour:
    """Return the free surface of the bed by the solid fraction.

    The fraction (`solid_fraction`) is divided by the share of the kernel that lies inside the
    liner. The fraction of the bed is the median over its balls. The surface is where the fraction
    is half of that: a symmetric kernel of any width w leaves a flat edge in place, and moves an
    edge of radius of curvature c by w^2 / 2c. Only the largest connected piece of the bed counts,
    and of its edge only the part along the largest piece of air: no voids, no edge along the liner.

    Balls in flight count. A third of the dense tumbling layer is without contact at any moment, and
    the distance of the contours of two seeds doubles if these balls are left out. Curtains have a
    tenth of the fraction of the bed, so they stay below half of it.

    Args:
        centres: (m, 2) float [x, z] of all balls, over R - a.
        areas: (m,) float, as in `solid_fraction`.
        outline: (k, 2) float, closed liner over R - a, turned to its mill angle.

    Raises:
        ValueError: no ball.
    """
    if not len(centres):
        raise ValueError("no balls: there is no surface")
    mill = grid.inside(outline)
    cover = grid.smooth(mill.astype(float))
    known = mill & (cover > LEAST_COVER)
    fraction = solid_fraction(centres, areas, grid) / np.maximum(cover, LEAST_COVER)
    bulk = float(np.median(value_at(fraction, centres, grid)))
    bed = _largest_piece(known & (fraction >= 0.5 * bulk))
    return Contour(_surface(fraction, bed, known, 0.5 * bulk, grid), bulk, bed)


def first_gaps(
    places: np.ndarray, ball_radius: float, length: float, lifter_tops: float
) -> np.ndarray:
    """Return the free surface by a second method, (m, 2) float [x, z] over R - a, by polar angle.

    The mill inside the circle of the lifter tops is cut into columns from that circle to the axis,
    two ball diameters wide at the wall and along the axis. Going inwards, the bed of a column ends
    before the first gap of two ball diameters between the distances of successive balls from the
    axis; the surface is the centre of its last ball, in the median over the columns along the
    axis. The method has no kernel, grid or bulk fraction. It finds only surface that is visible
    from the axis, to about a ball radius.

    Args:
        places: (n, 3) float [x, y, z] of all balls, over R - a.
        ball_radius, length: over R - a.
        lifter_tops: distance of the lifter tops from the axis, over R - a.
    """
    width = 4.0 * ball_radius
    sectors, slabs = int(2.0 * np.pi / width), max(1, round(length / width))
    x, y, z = places.T
    psi = np.arctan2(-x, -z)
    sector = np.floor((psi + np.pi) / (2.0 * np.pi) * sectors).astype(int) % sectors
    slab = np.floor(y / length * slabs).astype(int) % slabs
    every = np.arange(sectors * slabs)
    column = np.concatenate([every, sector * slabs + slab])
    radius = np.concatenate([np.full(every.size, lifter_tops), np.hypot(x, z)])
    ends = _column_ends(column, np.minimum(radius, lifter_tops), width)
    surface = np.median(ends.reshape(sectors, slabs), axis=1)
    seen = surface < lifter_tops
    middle = (np.flatnonzero(seen) + 0.5) / sectors * 2.0 * np.pi - np.pi
    return -surface[seen, None] * np.column_stack([np.sin(middle), np.cos(middle)])


def _column_ends(column: np.ndarray, radius: np.ndarray, gap: float) -> np.ndarray:
    """Return the smallest radius before the first gap of each column, (columns,) float; no column
    is empty."""
    order = np.lexsort((-radius, column))
    column, radius = column[order], radius[order]
    same = column[1:] == column[:-1]
    last = np.append(~same | (radius[:-1] - radius[1:] > gap), True)
    _, first = np.unique(column[last], return_index=True)
    return radius[last][first]


def _largest_piece(bed: np.ndarray) -> np.ndarray:
    pieces, count = label(bed)
    if count == 0:
        return bed
    return pieces == 1 + np.argmax(np.bincount(pieces.ravel())[1:])


def _surface(
    fraction: np.ndarray, bed: np.ndarray, known: np.ndarray, level: float, grid: Grid
) -> list[np.ndarray]:
    """Return the level lines between the bed and the air, the largest connected piece of the mill
    without bed; without lines around voids in the bed or between bed and liner."""
    air = _largest_piece(known & ~bed)
    # Nodes that are neither bed nor air make no line: those with few balls get values of the bed,
    # heaps beside the bed get values of the air.
    values = np.where(bed | air, fraction, np.maximum(fraction, 2.0 * level))
    heap = known & ~bed & (fraction >= level)
    values = np.where(heap, np.nextafter(level, 0.0), values)
    masked = np.ma.masked_array(values, mask=~known)
    lines = contour_generator(grid.nodes, grid.nodes, masked, corner_mask=True).lines(level)
    return [line for line in lines if len(line) > 1]
