"""A dense random packing of a block that repeats itself in all directions."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

# Radii are pushed apart as if larger by this share, so that the last true overlap goes in finite
# time: overlaps of pushed balls only fade. Measured: 100 to 300 passes at the fractions of charge.
INFLATION = 0.02
PASSES = 600
# Share of a pair's overlap that one pass takes away; balls are pushed from several sides at once.
PUSH = 0.7
# Pairs are listed up to so many reaches apart, and again when a ball has moved half the surplus.
LISTED = 1.25
# Radii of a level of sizes differ by less than this factor.
LEVEL = 4.0


@dataclass(frozen=True)
class Pairs:
    """Neighbours in a block: indices i, j, (m,) int; sums of their radii, (m,) float [m].

    `share`, (m,) float: of an overlap by which i moves; j moves by the rest.
    """

    i: np.ndarray
    j: np.ndarray
    touching: np.ndarray
    share: np.ndarray


def random_block(
    radii: np.ndarray, sides: np.ndarray, random: np.random.Generator, closed: bool = False
) -> np.ndarray | None:
    """Return the centres (n, 3) [m] of balls that do not overlap, also across the periodic sides.

    Balls thrown at random are pushed apart along their lines of centres until none overlap: a
    random packing, without the rows and columns of a lattice.

    Args:
        radii: (n,) float [m].
        sides: (3,) float, the periods, none shorter than the largest diameter [m].
        closed: walls at 0 and the length along y, which no ball crosses, instead of a period.

    Returns:
        None if overlaps are left after `PASSES`: the block is too full.
    """
    centres = random.uniform(0.0, 1.0, (len(radii), 3)) * sides
    reach = 2.0 * (1.0 + INFLATION) * float(radii.max())
    # A list lasts until a ball has moved by half of this [m].
    surplus = (LISTED - 1.0) * 2.0 * (1.0 + INFLATION) * float(radii[size_levels(radii)[-1]].max())
    length = sides[1]
    if closed:
        # The period is put out of the reach of the lists.
        sides = sides + np.array([0.0, 2.0 * LISTED * reach, 0.0])
        centres[:, 1] = _between(centres[:, 1], radii, length)
    pairs, listed = None, centres
    for _ in range(PASSES):
        if pairs is None or _farthest(centres, listed) > 0.5 * surplus:
            centres = wrapped(centres, sides)
            pairs, listed = _pairs(centres, radii, sides, surplus), centres
        apart = centres[pairs.i] - centres[pairs.j]
        apart -= sides * np.round(apart / sides)
        distance = np.maximum(np.linalg.norm(apart, axis=1), 1e-9 * reach)
        if (distance >= pairs.touching).all():
            return wrapped(centres, sides)
        centres = centres + PUSH * _pushes(pairs, apart, distance, len(radii))
        if closed:
            centres[:, 1] = _between(centres[:, 1], radii, length)
    return None


def _between(places: np.ndarray, radii: np.ndarray, length: float) -> np.ndarray:
    """Return places along the axis at which balls are clear of walls at 0 and a length [m]."""
    clear: np.ndarray = np.clip(places, radii, length - radii)
    return clear


def wrapped(positions: np.ndarray, period: np.ndarray | float) -> np.ndarray:
    """Return positions in [0, period), also if rounding makes a remainder the period."""
    remainder = np.mod(positions, period)
    return np.where(remainder >= period, 0.0, remainder)


def _farthest(centres: np.ndarray, before: np.ndarray) -> float:
    return float(np.linalg.norm(centres - before, axis=1).max())


def size_levels(radii: np.ndarray) -> list[np.ndarray]:
    """Return the indices of the balls by size, the largest first, each level (k,) int.

    The radii of a level differ by less than the factor `LEVEL`, so that few pairs of balls are
    listed in vain.
    """
    level = np.floor(np.log(radii.max() / radii) / math.log(LEVEL)).astype(int)
    return [np.flatnonzero(level == k) for k in np.unique(level)]


def close_pairs(
    centres: np.ndarray, radii: np.ndarray, sides: np.ndarray, gap: float, stretch: float = 1.0
) -> np.ndarray:
    """Return pairs of balls, (m, 2) int; all with a separation up to a gap [m] are among them.

    Args:
        centres: (n, 3) float, in [0, sides) [m].
        sides: (3,) float, the periods [m].
        stretch: of the radii.
    """
    levels = size_levels(radii)
    trees = [cKDTree(centres[some], boxsize=sides) for some in levels]
    largest = [stretch * float(radii[some].max()) for some in levels]
    found = []
    for a, (some, tree) in enumerate(zip(levels, trees, strict=True)):
        found.append(some[tree.query_pairs(2.0 * largest[a] + gap, output_type="ndarray")])
        for b in range(a + 1, len(levels)):
            near = tree.query_ball_tree(trees[b], largest[a] + largest[b] + gap)
            counts = [len(x) for x in near]
            others = np.fromiter((k for x in near for k in x), int, sum(counts))
            found.append(np.column_stack([np.repeat(some, counts), levels[b][others]]))
    return np.concatenate(found)


def _pairs(centres: np.ndarray, radii: np.ndarray, sides: np.ndarray, surplus: float) -> Pairs:
    i, j = close_pairs(centres, radii, sides, surplus, 1.0 + INFLATION).T
    if len(size_levels(radii)) > 1:
        # A large ball among many small ones would be pushed too far by all of them together.
        share = radii[j] ** 3 / (radii[i] ** 3 + radii[j] ** 3)
    else:
        share = np.full(len(i), 0.5)
    return Pairs(i, j, radii[i] + radii[j], share)


def _pushes(pairs: Pairs, apart: np.ndarray, distance: np.ndarray, count: int) -> np.ndarray:
    """Return the displacement of each ball, (count, 3) float [m]: the shares of every overlap, from
    both sides."""
    overlap = (1.0 + INFLATION) * pairs.touching - distance
    close = overlap > 0.0
    i, j, share = pairs.i[close], pairs.j[close], pairs.share[close]
    step = overlap[close] / distance[close]
    one, other = ((part * step)[:, None] * apart[close] for part in (share, 1.0 - share))
    sums = [
        np.bincount(i, one[:, axis], count) - np.bincount(j, other[:, axis], count)
        for axis in range(3)
    ]
    return np.column_stack(sums)
