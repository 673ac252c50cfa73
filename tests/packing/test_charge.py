import math

import numpy as np
import pytest

from millscale import _core
from millscale.campaign.campaign import Ball
from millscale.errors import CampaignError
from millscale.packing.bed import bulk_fraction
from millscale.packing.charge import (
    Packing,
    Room,
    capacity,
    largest_overlap,
    pack,
    periodic_tree,
    write_charge,
    write_data,
)
from millscale.runs.liner import liner_of
from paper_campaign import cases

LINER = _core.Lifters(3.9, 3.61, 0.25, 0.635, 25).scaled(2.6)
EQUAL = Ball(0.02, 2678.0, 0.0, 2.0)
MIXED = Ball(0.02, 2678.0, 0.003, 2.0)


def packed(ball: Ball, count: int, length: float, seed: int = 1) -> Packing:
    return pack(Room(LINER, length, 4e-4), ball, count, np.random.default_rng(seed))


def overlap_by_definition(packing: Packing) -> float:
    """Return the largest overlap from every pair, with every image along y."""
    worst = 0.0
    for shift in (-packing.length, 0.0, packing.length):
        moved = packing.centres + np.array([0.0, shift, 0.0])
        distance = np.linalg.norm(packing.centres[:, None] - moved[None], axis=2)
        touching = packing.radii[:, None] + packing.radii[None]
        if shift == 0.0:
            np.fill_diagonal(distance, np.inf)
        worst = max(worst, float((touching - distance).max()))
    return worst


@pytest.mark.parametrize("ball", [EQUAL, MIXED], ids=["equal", "mixed"])
@pytest.mark.parametrize("length", [0.053, 0.0999, 0.3846], ids=["one", "two", "nine balls"])
def test_balls_overlap_neither_each_other_nor_the_liner(contact_row, ball, length):
    packing = packed(ball, 700, length)
    assert len(packing.radii) == 700
    assert largest_overlap(packing) == 0.0
    contact_row(
        "fault: balls are inserted overlapping",
        "-",
        "-",
        f"largest overlap [m], across the seam too, {length} m slice",
        expected=0.0,
        got=max(overlap_by_definition(packing), 0.0),
        tolerance=0.0,
        reason="none overlaps by definition, pair by pair",
    )
    cross_section = np.ascontiguousarray(packing.centres[:, [0, 2]])
    assert (LINER.nearest(cross_section).distance - packing.radii).min() >= 4e-4 * (1.0 - 1e-9)
    assert packing.centres[:, 1].min() >= 0.0
    assert packing.centres[:, 1].max() < length


def test_overlap_is_found_within_and_across_the_periodic_ends():
    radii = np.array([0.02, 0.01, 0.02])
    centres = np.array([[0.0, 0.001, 0.0], [0.0, 0.098, 0.0], [0.0, 0.05, 0.5]])
    across = Packing(centres, radii, 0.1)
    assert largest_overlap(across) == pytest.approx(0.03 - 0.003, rel=1e-12)
    assert overlap_by_definition(across) == pytest.approx(0.03 - 0.003, rel=1e-12)
    within = Packing(centres - np.array([[0, 0, 0], [0, 0.08, 0], [0, 0, 0]]), radii, 0.1)
    assert largest_overlap(within) == pytest.approx(0.03 - 0.017, rel=1e-12)


def test_the_largest_mill_of_the_paper_is_packed_in_seconds():
    liner = _core.Lifters(3.9, 3.61, 0.25, 0.635, 25)
    packing = pack(Room(liner, 1.0, 1e-3), EQUAL, 231461, np.random.default_rng(1))
    assert len(packing.radii) == 231461
    assert largest_overlap(packing) == 0.0
    # The mill is filled from the bottom: the surface is level, below the axis.
    assert packing.centres[:, 2].max() < 0.0


def test_the_same_seed_gives_the_same_packing_and_another_one_another():
    one, same, other = (packed(EQUAL, 500, 0.1, seed).centres for seed in (7, 7, 8))
    assert np.array_equal(one, same)
    assert not np.array_equal(one, other)


def test_radii_follow_the_requested_distribution():
    radii = packed(MIXED, 5000, 0.3846).radii
    assert radii.min() >= 0.014
    assert radii.max() <= 0.026
    # Standard error of the mean: 0.0026 / sqrt(5000).
    assert radii.mean() == pytest.approx(0.02, abs=4 * 0.0026 / math.sqrt(5000))


def test_more_balls_than_places_are_refused():
    most = capacity(Room(LINER, 0.1, 4e-4), EQUAL)
    assert len(packed(EQUAL, most, 0.1).radii) == most
    with pytest.raises(CampaignError, match=f"{2 * most} balls do not fit"):
        packed(EQUAL, 2 * most, 0.1)


@pytest.mark.parametrize(("ball", "length"), [(EQUAL, 0.0401), (MIXED, 0.0999)], ids=str)
def test_as_many_balls_as_the_capacity_are_placed(ball, length):
    room = Room(LINER, length, 4e-4)
    most = capacity(room, ball)
    assert len(pack(room, ball, most, np.random.default_rng(3)).radii) == most


def test_a_charge_is_level_and_almost_as_dense_as_a_bed():
    packing = packed(EQUAL, 13370, 0.3846)
    found = bulk_fraction(Room(LINER, 0.3846), packing, np.random.default_rng(1))
    # 0.55 requested; the error is of 1e5 points and of balls cut at the borders of the block.
    assert found == pytest.approx(0.55, abs=0.01)
    # Level: in every column of x the highest ball lies within two diameters of the highest.
    top = packing.centres[:, 2].max()
    x = packing.centres[:, 0]
    for left in np.arange(-1.0, 1.0, 0.2):
        column = packing.centres[(x >= left) & (x < left + 0.2), 2]
        assert column.max() > top - 0.08


def test_a_packing_has_no_columns_and_rows():
    """In a lattice the distances of close neighbours are few; here they are spread."""
    packing = packed(EQUAL, 6000, 0.3846)
    tree, _ = periodic_tree(packing)
    distance = tree.query(tree.data, k=[2])[0][:, 0]
    assert np.std(distance) > 1e-4
    # Six-fold order of the projected neighbours: 1 in a hexagonal lattice seen along its columns, 0
    # of random directions; four times the scatter of 6 neighbours of some 300 different balls.
    inner = np.flatnonzero(np.abs(packing.centres[:, 2] + 1.2) < 0.1)
    neighbours = tree.query(tree.data[inner], k=list(range(2, 8)))[1]
    arm = packing.centres[neighbours] - packing.centres[inner][:, None]
    order = np.abs(np.exp(6j * np.arctan2(arm[..., 2], arm[..., 0])).mean())
    assert order < 0.1


def test_a_plain_drum_is_filled_to_a_usual_level():
    drum = _core.Lifters(1.0, 0.0, 0.0, 0.0, 0)
    packing = pack(Room(drum, 0.2), EQUAL, 1500, np.random.default_rng(1))
    assert largest_overlap(packing) == 0.0
    assert np.hypot(packing.centres[:, 0], packing.centres[:, 2]).max() <= 0.98


def test_the_data_file_holds_the_packing_exactly(tmp_path):
    packing = packed(MIXED, 50, 0.1)
    write_data(packing, [2678.0], 1.54, tmp_path / "charge.data")
    text = (tmp_path / "charge.data").read_text()
    header, _, body = text.partition("Atoms\n\n")
    assert "50 atoms\n" in header
    assert "2 atom types\n" in header
    assert "-1.54 1.54 xlo xhi\n0.0 0.1 ylo yhi\n-1.54 1.54 zlo zhi\n" in header
    rows = np.array([line.split() for line in body.splitlines()], dtype=float)
    assert np.array_equal(rows[:, 0], np.arange(1, 51))
    assert np.array_equal(rows[:, 1], np.ones(50))
    assert np.array_equal(rows[:, 2], 2.0 * packing.radii)
    assert np.array_equal(rows[:, 3], np.full(50, 2678.0))
    assert np.array_equal(rows[:, 4:], packing.centres)
    assert [path.name for path in tmp_path.iterdir()] == ["charge.data"]


def test_a_case_has_its_count_of_balls_inside_its_own_liner(tmp_path):
    charge = {"count": [300, 200], "rotation_angle_rad": 1.0, "step_s": 1e-4}
    changes = {"scaling__S": [1.0, 2.6], "scaling__policies": ["offset-liner"]}
    for case in cases(tmp_path, single_ball=None, multi_ball=charge, **changes):
        write_charge(case, tmp_path)
        body = (tmp_path / "charge.data").read_text().partition("Atoms\n\n")[2]
        rows = np.array([line.split() for line in body.splitlines()], dtype=float)
        assert len(rows) == case.ball.count
        liner = liner_of(case.mill)
        assert liner.area == pytest.approx(case.mill.area_m2, rel=1e-12)
        cross_section = np.ascontiguousarray(rows[:, [4, 6]])
        assert liner.nearest(cross_section).distance.min() > 0.02
