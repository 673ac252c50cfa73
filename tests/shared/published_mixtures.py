"""Published models of the solid fraction of a bed of several ball sizes."""

from __future__ import annotations

import bisect

import numpy as np
import scipy.optimize


def linear_packing(radii: np.ndarray, shares: np.ndarray, mono: float) -> float:
    """Return the solid fraction by the linear packing model.

    The least over the classes t of b / (1 - sum_{x < t} y(x) f(x / t) - (1 - b) sum_{x > t} y(x)
    g(t / x)), with b the fraction of one size, y the shares by volume, f(z) = 0.7 (1 - z) +
    0.3 (1 - z)^12 for the loosening by smaller balls, g(z) = (1 - z)^1.3 for the wall effect of
    larger ones. Stovall, de Larrard, Buil, Powder Technology 48 (1986) 1-12; the functions as given
    by de Larrard and Sedran, Cement and Concrete Research 24 (1994) 997-1009.

    Args:
        radii: of the classes, (n,) float [m].
        shares: of the volume of balls, (n,) float.
        mono: solid fraction of a bed of one size.
    """
    fractions = []
    for size in radii:
        small, large = radii < size, radii > size
        ratio = 1.0 - radii[small] / size
        loosened = shares[small] @ (0.7 * ratio + 0.3 * ratio**12)
        walls = shares[large] @ (1.0 - size / radii[large]) ** 1.3
        fractions.append(mono / (1.0 - loosened - (1.0 - mono) * walls))
    return min(fractions)


def rods(radii: np.ndarray, shares: np.ndarray, mono: float, count: int = 4000) -> float:
    """Return the solid fraction by the packing of rods on a line.

    Balls cut by a random line are rods with the density 2 L / D^2 of lengths L up to the diameter
    D, and of each size as many as its section. The longest first, rods are put in the widest gap,
    apart by at least h times the shorter one's length. Farr and Groot, Journal of Chemical Physics
    131 (2009) 244104, who take h of the densest random packing; here it is that of `mono`.
    """

    return _fraction_of_rods(radii, shares, rod_spacing(mono), count)


def rod_spacing(mono: float, count: int = 4000) -> float:
    """Return h of the rods of balls of one size whose solid fraction is `mono`."""
    one = np.ones(1)
    apart: float = scipy.optimize.brentq(
        lambda h: _fraction_of_rods(one, one, h, count) - mono, 0.3, 2.0, xtol=1e-6
    )
    return apart


def _fraction_of_rods(radii: np.ndarray, shares: np.ndarray, apart: float, count: int) -> float:
    lengths = _chords(radii, shares, count)
    gaps = [apart * lengths[0]]
    for length in lengths[1:]:
        widest = gaps.pop()
        bisect.insort(gaps, apart * length)
        bisect.insort(gaps, max(apart * length, widest - (1.0 + apart) * length))
    solid = lengths.sum()
    return float(solid / (solid + sum(gaps)))


def _chords(sizes: np.ndarray, weights: np.ndarray, count: int) -> np.ndarray:
    """Return the lengths of `count` rods at equally likely ranks, the longest first."""
    # As many balls as weight / size^3, each cut as often as its section: weight / size.
    cut = weights / sizes
    grid = np.linspace(0.0, 2.0 * sizes.max(), 200_001)
    below = sum(c * np.minimum(grid / (2.0 * a), 1.0) ** 2 for c, a in zip(cut, sizes, strict=True))
    ranks = (np.arange(count)[::-1] + 0.5) / count
    return np.interp(ranks, below / below[-1], grid)
