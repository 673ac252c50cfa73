"""Random periodic blocks."""

import math

import numpy as np
import pytest

from millscale.packing.random_block import random_block, wrapped


def overlap_by_definition(centres, radii, sides):
    """Return the largest overlap of every pair with every image in the neighbouring blocks."""
    worst = -np.inf
    for shift in np.ndindex(3, 3, 3):
        moved = centres + (np.array(shift) - 1) * sides
        distance = np.linalg.norm(centres[:, None] - moved[None], axis=2)
        if shift == (1, 1, 1):
            np.fill_diagonal(distance, np.inf)
        worst = max(worst, float((radii[:, None] + radii[None] - distance).max()))
    return worst


@pytest.mark.parametrize("sizes", [(0.02, 0.02), (0.014, 0.026), (0.006, 0.03)], ids=str)
def test_no_two_balls_overlap_across_any_side(sizes):
    radii = np.tile(sizes, 150)
    side = (4.0 / 3.0 * math.pi * (radii**3).sum() / 0.55) ** (1.0 / 3.0)
    sides = np.array([side, 0.8 * side, 1.25 * side])
    centres = random_block(radii, sides, np.random.default_rng(1))
    assert overlap_by_definition(centres, radii, sides) <= 0.0
    assert (centres >= 0.0).all() and (centres < sides).all()


def test_a_block_too_full_is_given_up():
    # No packing of equal balls exceeds pi / sqrt(18) = 0.74.
    radii = np.full(100, 0.02)
    side = (4.0 / 3.0 * math.pi * (radii**3).sum() / 0.75) ** (1.0 / 3.0)
    assert random_block(radii, np.full(3, side), np.random.default_rng(1)) is None


def test_positions_wrap_into_the_period_even_where_rounding_reaches_its_end():
    positions = np.array([-1e-20, -0.1, 0.0, 0.3, 1.0])
    assert wrapped(positions, 0.3) == pytest.approx([0.0, 0.2, 0.0, 0.0, 0.1])
    assert (wrapped(positions, 0.3) < 0.3).all()
