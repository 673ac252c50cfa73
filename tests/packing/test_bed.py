"""Measures of a settled bed, on beds of known density and overlap."""

import math

import numpy as np
import pytest

from millscale import _core
from millscale.campaign.campaign import Ball
from millscale.packing.bed import COLUMNS, bed_record, bulk_fraction, read_bed
from millscale.packing.charge import Packing, Room, pack

DRUM = _core.Lifters(1.5, 0.0, 0.0, 0.0, 0)
RADIUS = 0.02


def lattice(spacing: float, length: float, radius: float = RADIUS) -> Packing:
    """A simple cubic bed in the lower half of the drum."""
    grid = np.arange(-1.5, 1.5, spacing)
    x, y, z = np.meshgrid(grid, np.arange(0.5, length / spacing) * spacing, grid)
    centres = np.column_stack([x.ravel(), y.ravel(), z.ravel()])
    keep = (np.hypot(centres[:, 0], centres[:, 2]) < 1.5 - radius) & (centres[:, 2] < -0.2)
    centres = centres[keep]
    return Packing(centres, np.full(len(centres), radius), length)


def random():
    return np.random.default_rng(1)


@pytest.mark.parametrize("spacing", [0.04, 0.05])
def test_the_bulk_of_a_lattice_has_the_density_of_its_cell(spacing):
    packing = lattice(spacing, 6 * spacing)
    expected = 4.0 / 3.0 * math.pi * RADIUS**3 / spacing**3
    # Four standard errors of 1e5 points.
    error = 4.0 * math.sqrt(expected * (1.0 - expected) / 1e5)
    assert bulk_fraction(Room(DRUM, packing.length), packing, random()) == pytest.approx(
        expected, abs=error
    )


def test_balls_of_two_sizes_count_with_their_own_volume():
    packing = lattice(0.05, 0.3)
    radii = np.where(np.arange(len(packing.radii)) % 2, 0.5, 1.0) * RADIUS
    mixed = Packing(packing.centres, radii, packing.length)
    expected = 4.0 / 3.0 * math.pi * np.mean(radii**3) / 0.05**3
    # The two sizes alternate along the rows, and the sample points see them unequally: 1 %.
    assert bulk_fraction(Room(DRUM, 0.3), mixed, random()) == pytest.approx(expected, rel=0.01)


def test_a_bed_without_a_bulk_has_no_bulk_fraction():
    ball = Ball(RADIUS, 2678.0, 0.0, 2.0)
    thin = pack(Room(DRUM, 0.2), ball, 60, random())
    assert bulk_fraction(Room(DRUM, 0.2), thin, random()) is None


def dump(folder, rows, columns=COLUMNS):
    path = folder / "settled.dump"
    lines = ["x"] * 8 + ["ITEM: ATOMS " + " ".join(columns)]
    path.write_text("\n".join([*lines, *(" ".join(map(repr, row)) for row in rows)]) + "\n")
    return path


def test_a_dump_gives_speed_and_overlap_across_the_periodic_boundary(tmp_path):
    rows = [(0.0, -0.001, -1.0, 0.03, 0.0, 0.04, 0.02), (0.0, 0.16, -1.0, 0.0, 0.0, 0.0, 0.02)]
    found = bed_record(dump(tmp_path, rows), Room(DRUM, 0.2), 9.81)
    # 0.199 and 0.16 in a period of 0.2: a separation of 0.039.
    assert found["largest_overlap_m"] == pytest.approx(0.001, rel=1e-9)
    assert found["largest_overlap_over_radius"] == pytest.approx(0.05, rel=1e-9)
    assert found["rms_speed_m_s"] == pytest.approx(0.05 / math.sqrt(2.0))
    assert found["balls_in_contact"] == 1.0
    assert found["bulk_fraction"] is None
    packing, velocities = read_bed(dump(tmp_path, rows), 0.2)
    assert packing.centres[:, 1] == pytest.approx([0.199, 0.16])
    assert velocities.shape == (2, 3)


def test_a_bed_whose_balls_sink_into_each_other_is_refused(tmp_path):
    rows = [(0.0, 0.05, z, 0.0, 0.0, 0.0, 0.02) for z in (-1.0, -1.034)]
    with pytest.raises(ValueError, match=r"overlap by 0\.006 m, more than 0\.25 of their radius"):
        bed_record(dump(tmp_path, rows), Room(DRUM, 0.2), 9.81)


def test_a_charge_without_contacts_is_refused(tmp_path):
    rows = [(0.0, 0.05, z, 0.0, 0.0, -4e-5, 0.02) for z in (-1.0, -1.05, -1.1)]
    with pytest.raises(ValueError, match=r"hangs in the air after settling: 0% of its balls"):
        bed_record(dump(tmp_path, rows), Room(DRUM, 0.2), 1e-4)


@pytest.mark.parametrize(("gap", "meshed", "held"), [(0.0, False, 1.0), (0.001, True, 1.0)])
def test_a_ball_on_the_liner_alone_is_in_contact(tmp_path, gap, meshed, held):
    # The panels of a mesh may be nearer than the arc by the chord error.
    rows = [(0.0, 0.1, -(1.5 - 0.02 + 1e-5 - 0.5 * gap), 0.0, 0.0, 0.0, 0.02)]
    found = bed_record(dump(tmp_path, rows), Room(DRUM, 0.2, gap), 9.81, meshed)
    assert (found["balls_in_contact"], found["largest_overlap_m"]) == (held, 0.0)


def test_hard_balls_that_bounce_a_little_are_accepted_as_a_bed(tmp_path):
    # A hundredth of the radius is 0.2 mm.
    for gap, held in ((1.9e-4, True), (2.1e-4, False)):
        rows = [(0.0, 0.05, z, 0.0, 0.0, 0.0, 0.02) for z in (-1.0, -1.04 - gap)]
        path = dump(tmp_path, rows)
        if held:
            assert bed_record(path, Room(DRUM, 0.2), 9.81)["balls_in_contact"] == 1.0
            continue
        with pytest.raises(ValueError, match="hangs in the air"):
            bed_record(path, Room(DRUM, 0.2), 9.81)


def test_a_falling_charge_is_refused(tmp_path):
    # Half of the speed of a fall through 0.02 m is 0.31 m/s.
    rows = [(0.0, 0.05, z, 0.0, 0.0, -0.33, 0.02) for z in (-1.0, -1.0399)]
    with pytest.raises(ValueError, match=r"rms speed 0\.33 m/s, a bed has under 0\.313 m/s"):
        bed_record(dump(tmp_path, rows), Room(DRUM, 0.2), 9.81)


def test_a_dump_with_other_columns_is_refused(tmp_path):
    with pytest.raises(ValueError, match="no dump with the columns x y z vx vy vz radius"):
        read_bed(dump(tmp_path, [], ("id", "x")), 0.2)
