"""Curtains (Fig. 12): the balls in flight that have the same last lifter.

Lengths are over R - a. Angles from the vertical are 0 at the top and positive on the rising side.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from millscale.analysis.means import mean_known
from millscale.analysis.shapes.comparison import overlap
from millscale.analysis.shapes.solid_fraction import Grid, solid_fraction

RESOLUTION = 0.03  # standard deviation of the kernel: a curtain at S = 2.6 has some 100 balls
SHARE = 0.9  # of the balls that the profile encloses; the rest are strays
FEWEST_BALLS = 12
BANDS = 6
IN_FLIGHT = 3.0
PARTS = ("whole", "upper", "lower")


@dataclass(frozen=True)
class Lifters:
    """Where the lifters are.

    Attributes:
        count: of the lifters, over 0.
        phase: of groove 0 from the bottom at rest [rad]; lifter k trails groove k.
        first: angle from the vertical past which a rising lifter's curtain counts [rad].
        angles: (count,) floats, polar angles of the lifters' middles at rest, of lifters that are
            not at equal distances [rad].
    """

    count: int
    phase: float
    first: float
    angles: tuple[float, ...] = ()

    @property
    def pitch(self) -> float:
        """Return the angle from lifter to lifter [rad]."""
        return 2.0 * np.pi / self.count

    def angle_from_vertical(self, lifter, mill_angle):
        """Return the angle of the middle of a lifter [rad], in [-pi, pi); scalars or arrays."""
        if self.angles:
            at_rest = np.asarray(self.angles)[np.asarray(lifter).astype(int) % self.count]
        else:
            at_rest = (lifter - 0.5) * self.pitch + self.phase
        return np.mod(-(at_rest + mill_angle), 2.0 * np.pi) - np.pi

    def number(self, lifter: int, mill_angle: float) -> int:
        """Return the number of a lifter's curtain, 1 to count: 1 belongs to the last lifter that
        has risen past the angle `first`, 2 to the one before it, and so on in the sense of
        rotation. The same for all mills of the same lifters, mill angle and `first`."""
        past = self._past_first(lifter, mill_angle)
        if self.angles:
            every = self._past_first(np.arange(self.count), mill_angle)
            return int((every < past).sum()) + 1
        return int(np.floor(past / self.pitch)) + 1

    def _past_first(self, lifter, mill_angle: float):
        """Return the angle by which a lifter is past `first` [rad], in [0, 2 pi)."""
        return np.mod(self.first - self.angle_from_vertical(lifter, mill_angle), 2.0 * np.pi)


@dataclass(frozen=True)
class Curtain:
    """One curtain.

    Attributes:
        lifter, number: as in `Lifters`.
        centres: (n, 2) float [x, z].
        region: (m, m) bool [z, x]: grid nodes inside its profile.
        banded: the same by the second method.
        width: root mean square distance of the balls from their band's middle, in x.
    """

    lifter: int
    number: int
    centres: np.ndarray
    region: np.ndarray
    banded: np.ndarray
    width: float

    @property
    def middle(self) -> float:
        """Return the median height of its balls: its upper end lies above, its lower end below."""
        return float(np.median(self.centres[:, 1]))


def curtain_overlaps(
    curtains: Mapping[int, Curtain], reference: Mapping[int, Curtain]
) -> tuple[dict[str, dict[str, float | None]], *tuple[float | None, ...]]:
    """Return the overlap of each curtain of the same number, and the means of PARTS over them.

    Args:
        curtains, reference: by number.
    """
    each = {
        str(number): curtain_overlap(curtains[number], reference[number])
        for number in sorted(curtains.keys() & reference.keys())
    }
    return each, *(mean_known(parts[part] for parts in each.values()) for part in PARTS)


def curtain_overlap(curtain: Curtain, reference: Curtain) -> dict[str, float | None]:
    """Return the intersection over union of two curtains: whole, of their upper and lower ends
    (above and below the median height of the reference's balls), and whole by the second method."""
    upper = Grid(RESOLUTION).nodes[:, None] >= reference.middle
    return {
        "whole": overlap(curtain.region, reference.region),
        "upper": overlap(curtain.region, reference.region, upper),
        "lower": overlap(curtain.region, reference.region, ~upper),
        "second_method": overlap(curtain.banded, reference.banded),
    }


def longest_flight(froude: float) -> float:
    """Return the longest flight in mill rotation [rad]: a ball thrown straight up at the speed of
    the liner from its top, falling to its bottom: t = (V + sqrt(V^2 + 4 g R)) / g with V = omega R,
    so omega t = Fr (1 + sqrt(1 + 4 / Fr)), Fr = omega^2 R / g. Derived here."""
    return froude * (1.0 + np.sqrt(1.0 + 4.0 / froude))


def may_have_thrown(
    lifter: np.ndarray, lifters: Lifters, mill_angle: float, longest: float
) -> np.ndarray:
    """Return which lifters were above the axis on the rising side within the longest flight, (n,)
    bool. Balls with another last lifter are tumbling in the toe or have not been lifted.

    Args:
        lifter: (n,) float.
        mill_angle: now [rad].
        longest: of `longest_flight` [rad].
    """
    past_axis = 0.5 * np.pi - lifters.angle_from_vertical(lifter, mill_angle)
    return np.mod(past_axis, 2.0 * np.pi) <= 0.5 * np.pi + longest


def curtains(
    centres: np.ndarray, lifter: np.ndarray, lifters: Lifters, mill_angle: float
) -> list[Curtain]:
    """Return the curtains by number; fewer than FEWEST_BALLS balls have no profile.

    Args:
        centres: (n, 2) float [x, z] of balls in flight outside the bed.
        lifter: (n,) float, the last lifter of each ball.
        mill_angle: now [rad].
    """
    found = []
    for which in np.unique(lifter):
        balls = centres[lifter == which]
        if len(balls) >= FEWEST_BALLS:
            found.append(_curtain(int(which), lifters.number(which, mill_angle), balls))
    return sorted(found, key=lambda curtain: curtain.number)


def _curtain(lifter: int, number: int, balls: np.ndarray) -> Curtain:
    grid = Grid(RESOLUTION)
    edges, width = band_profile(balls)
    region, banded = densest_region(balls, grid), grid.inside(edges)
    return Curtain(lifter, number, balls, region, banded, width)


def densest_region(centres: np.ndarray, grid: Grid, share: float = SHARE) -> np.ndarray:
    """Return the profile of a curtain: the smallest region that holds a share of its balls, each
    smeared by the grid's Gaussian kernel. (n, n) bool [z, x]."""
    density = solid_fraction(centres, np.ones(len(centres)), grid)
    falling = np.sort(density.ravel())[::-1]
    last = int(np.searchsorted(np.cumsum(falling), share * falling.sum()))
    return density >= falling[min(last, falling.size - 1)]


def band_profile(centres: np.ndarray, share: float = SHARE) -> tuple[np.ndarray, float]:
    """Return the profile by a second method: BANDS bands of height with equally many balls, and in
    each the x between which `share` of its balls lie. No kernel and no grid.

    Returns:
        Closed polygon (2 BANDS + 5, 2) [x, z], and the root mean square distance of the balls
        from the mean x of their band.
    """
    order = np.argsort(centres[:, 1])
    bands = np.array_split(centres[order], BANDS)
    tails = (0.5 * (1.0 - share), 0.5 * (1.0 + share))
    sides = np.array([np.quantile(band[:, 0], tails) for band in bands])
    heights = [float(np.mean(band[:, 1])) for band in bands]
    ends = np.quantile(centres[:, 1], tails)
    heights = [min(ends[0], heights[0]), *heights, max(ends[1], heights[-1])]
    left, right = np.vstack([sides[:1], sides, sides[-1:]]).T
    outline = np.column_stack([np.append(left, right[::-1]), np.append(heights, heights[::-1])])
    squares = sum(float(np.sum((band[:, 0] - band[:, 0].mean()) ** 2)) for band in bands)
    return np.vstack([outline, outline[:1]]), np.sqrt(squares / (len(centres) - BANDS))
