"""Packings of several sizes: counts of each class, no overlaps, mixed, periodic or walled."""

import numpy as np
import pytest

from millscale import _core
from millscale.campaign.campaign import Ball, BallClass
from millscale.packing.bed import Solid
from millscale.packing.charge import Packing, Room, largest_overlap, overlaps, pack, write_data
from millscale.packing.random_block import close_pairs, size_levels

DRUM = _core.Lifters(0.5, 0.0, 0.0, 0.0, 0)


def mixture(*radii_and_mass):
    volumes = [4.0 / 3.0 * np.pi * a**3 for a, _ in radii_and_mass]
    numbers = [m / v for (_, m), v in zip(radii_and_mass, volumes, strict=True)]
    classes = tuple(
        BallClass(a, 7800.0, n / sum(numbers))
        for (a, _), n in zip(radii_and_mass, numbers, strict=True)
    )
    mean = sum(a * m for a, m in radii_and_mass) / sum(m for _, m in radii_and_mass)
    return Ball(mean, 7800.0, 0.0, 2.0, classes)


MIXTURES = {
    "1 : 1.5 : 2.5": (mixture((0.008, 0.3), (0.012, 0.3), (0.02, 0.4)), 1500),
    "1 : 10": (mixture((0.004, 0.3), (0.04, 0.7)), 2500),
}


@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("name", MIXTURES)
def test_balls_do_not_overlap_and_have_the_shares_of_their_classes(name, closed):
    ball, count = MIXTURES[name]
    room = Room(DRUM, 0.1, 0.0, closed)
    packing = pack(room, ball, count, np.random.default_rng(3))
    assert largest_overlap(packing) == 0.0
    exact = [count * one.share for one in ball.classes]
    found = np.bincount(packing.kinds, minlength=len(exact))
    assert found.sum() == count and np.abs(found - exact).max() < 1.0
    np.testing.assert_array_equal(
        packing.radii, np.array([one.radius for one in ball.classes])[packing.kinds]
    )
    section = np.ascontiguousarray(packing.centres[:, [0, 2]])
    assert (DRUM.nearest(section).distance > packing.radii).all()
    if closed:
        along = packing.centres[:, 1]
        assert (np.minimum(along, 0.1 - along) >= packing.radii * (1.0 - 1e-12)).all()
    # Mixed at random: the classes have the same mean height to a few standard errors.
    heights = [packing.centres[packing.kinds == k, 2] for k in range(len(exact))]
    error = np.sqrt(sum(h.var() / len(h) for h in heights))
    assert abs(heights[0].mean() - heights[-1].mean()) < 5.0 * error + 0.02


def test_pairs_by_size_level_are_all_close_pairs():
    random = np.random.default_rng(5)
    radii = random.choice([0.01, 0.03, 0.1], 400, p=[0.8, 0.15, 0.05])
    sides = np.array([1.0, 0.8, 1.2])
    centres = random.uniform(0.0, 1.0, (400, 3)) * sides
    assert len(size_levels(radii)) == 2
    apart = centres[:, None] - centres[None]
    apart -= sides * np.round(apart / sides)
    near = np.linalg.norm(apart, axis=2) < radii[:, None] + radii[None] + 0.01
    wanted = {(i, j) for i, j in np.argwhere(near) if i < j}
    found = {tuple(sorted(pair)) for pair in close_pairs(centres, radii, sides, 0.01).tolist()}
    assert wanted <= found
    assert len(found) < 400 * 399 // 4


def test_a_large_ball_and_a_small_one_overlap_across_the_period():
    packing = Packing(np.array([[0.0, 0.01, 0.0], [0.0, 0.995, 0.0]]), np.array([0.1, 0.01]), 1.0)
    assert overlaps(packing)[1].max() == pytest.approx(0.11 - 0.015)


def test_points_in_balls_of_any_size_are_found():
    random = np.random.default_rng(2)
    radii = np.repeat([0.1, 0.02, 0.005], [4, 60, 800])
    packing = Packing(random.uniform(0.0, 1.0, (864, 3)) * [0.5, 0.4, 0.5], radii, 0.4)
    points = random.uniform(0.0, 1.0, (3000, 3)) * [0.5, 0.4, 0.5]
    apart = points[:, None] - packing.centres[None]
    apart[:, :, 1] -= 0.4 * np.round(apart[:, :, 1] / 0.4)
    inside = (np.linalg.norm(apart, axis=2) < radii).any(axis=1)
    np.testing.assert_array_equal(Solid(packing).covers(points), inside)
    assert 0.1 < inside.mean() < 0.9
    small_alone = (np.linalg.norm(apart, axis=2) < radii)[:, 4:].any(axis=1)
    assert (inside != small_alone).any()


def test_a_data_file_states_types_and_densities(tmp_path):
    packing = Packing(np.zeros((2, 3)), np.array([0.01, 0.02]), 1.0, kinds=np.array([1, 0]))
    write_data(packing, [7800.0, 3600.0], 1.0, tmp_path / "d", 4)
    lines = (tmp_path / "d").read_text().splitlines()
    assert "4 atom types" in lines
    assert lines[-2].split()[:4] == ["1", "2", "0.02", "3600.0"]
    assert lines[-1].split()[:4] == ["2", "1", "0.04", "7800.0"]
