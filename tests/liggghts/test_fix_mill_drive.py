"""fix mill/drive: work and torque of the drive against the charge's angular momentum, the energy
budget and samples at every step; restarts, ranks, walls; its errors."""

import numpy as np
import pytest

from bed import RADIUS, S, again_deck, bed_deck
from scene import loose_bed, run

DT = 5e-5
# Four balls fill the length, so that balls touch others across the ends.
LENGTH = 0.1625
BALLS = loose_bed(RADIUS, 100, LENGTH, seed=5)
WEIGHT = 4.0 / 3.0 * np.pi * 0.02**3 * 2678.0 * 9.81 * len(BALLS)
DRIVE = "fix drive all mill/drive mill mill wall liner every {every}\n"
SHAPE = f"lifters 25 lifter_top_radius {3.61 / S!r} lifter_top_width {0.25 / S!r} "
CHARGE = f"compute charge all mill/charge mill mill {SHAPE} groove_width {0.635 / S!r}\n"
COLUMNS = (
    *("f_mill[13]", "f_drive[1]", "f_drive[2]", "f_drive[3]", "f_drive[4]", "f_drive[5]"),
    *("c_charge[16]", "c_charge[6]", "f_liner[5]"),
)


def series(every, file="series.txt"):
    """Deck lines that print COLUMNS."""
    values = " ".join(f"$({name})" for name in COLUMNS)
    return f'fix rows all print {every} "$(step) {values}" screen no file {file}\n'


def read(folder, file="series.txt"):
    """(rows, columns) float: step and COLUMNS."""
    return np.loadtxt(folder / file, comments="#")


def turned(folder, deck, every, steps=2000, ranks=1):
    deck += CHARGE + DRIVE.format(every=every) + series(every) + f"run {steps}\n"
    ran = run(folder, deck, ranks)
    assert ran.code == 0, ran.text[-600:]
    return read(folder)


PATHS = {
    "bounded": ("fast", "tangential_damping bounded"),
    "mixed": ("fast", "tangential_damping bounded precision mixed"),
    "stock": ("stock", ""),
}


@pytest.mark.engine
@pytest.mark.parametrize("ranks", [1, 2])
@pytest.mark.parametrize("path", PATHS)
def test_torque_is_weight_times_arm_and_the_change_of_angular_momentum(tmp_path, path, ranks):
    deck = bed_deck(tmp_path, *PATHS[path], balls=BALLS, length=LENGTH)
    if path != "stock":
        deck = deck.replace("mill mill type 2", "mill mill type 2 tangential_damping bounded")
    _, _, _, impulse, torque, _, _, momentum, centre, _ = turned(tmp_path, deck, 1).T
    by_gravity = WEIGHT * 0.5 * (centre[1:] + centre[:-1])
    balance = np.diff(momentum) / DT - by_gravity
    rounding = 1e-5 if path == "mixed" else 1e-9
    assert np.abs(torque[1:] - balance).max() < rounding * WEIGHT * RADIUS
    assert np.abs(impulse[-1] - impulse[0] - balance.sum() * DT) < rounding * WEIGHT * RADIUS
    assert np.ptp(torque) > 0.1 * WEIGHT * RADIUS


@pytest.mark.engine
def test_means_do_not_depend_on_how_often_they_are_printed(tmp_path):
    # 7 and 50 steps: samples at even steps alone, or at both.
    found = {}
    for every in (1, 7, 50):
        folder = tmp_path / str(every)
        deck = bed_deck(folder, *PATHS["bounded"], balls=BALLS, length=LENGTH)
        found[every] = turned(folder, deck, every)
    single = found[1]
    for every in (7, 50):
        rows = found[every]
        assert np.array_equal(rows[:, 0] % every, np.zeros(len(rows)))
        at = np.searchsorted(single[:, 0], rows[:, 0])
        np.testing.assert_array_equal(single[at, 2], rows[:, 2])
        ends = at[1:]
        means = [single[e - every + 1 : e + 1, 4].mean() for e in ends]
        np.testing.assert_allclose(rows[1:, 4], means, rtol=1e-9, atol=1e-9)
        power = np.diff(rows[:, 2]) / np.diff(rows[:, 1])
        np.testing.assert_allclose(rows[1:, 5], power, rtol=1e-9, atol=1e-9)


@pytest.mark.engine
def test_the_alternating_part_is_that_of_even_and_odd_steps(tmp_path):
    deck = bed_deck(tmp_path, *PATHS["bounded"], balls=BALLS, length=LENGTH) + "run 500\n"
    both = (
        CHARGE
        + DRIVE.format(every=40)
        + series(40)
        + series(1, "each.txt").replace("fix rows", "fix each")
    )
    ran = run(tmp_path, deck + both + "run 1000\n")
    assert ran.code == 0, ran.text[-600:]
    rows, each = read(tmp_path), read(tmp_path, "each.txt")
    for row in rows[1:]:
        last = (each[:, 0] > row[0] - 40) & (each[:, 0] <= row[0])
        even = each[:, 0] % 2 == 0
        torque = -each[:, 9]
        wanted = 0.5 * (torque[last & even].mean() - torque[last & ~even].mean())
        assert row[6] == pytest.approx(wanted, abs=1e-9)


@pytest.mark.engine
def test_work_is_that_of_the_energy_budget(tmp_path):
    deck = bed_deck(tmp_path, *PATHS["bounded"], balls=BALLS, length=LENGTH)
    deck += CHARGE + DRIVE.format(every=50) + "fix ledger all mill/ledger mill mill\n"
    ran = run(tmp_path, deck + 'run 3000\nprint "both $(f_drive[1]) $(f_ledger[1])"\n')
    assert ran.code == 0, ran.text[-600:]
    work, of_budget = ran.printed("both")
    assert work == pytest.approx(of_budget, rel=1e-12)
    assert abs(work) > 0.1


@pytest.mark.engine
@pytest.mark.parametrize("ranks", [1, 2])
def test_a_run_that_goes_on_from_a_file_has_the_sums_of_one_that_did_not_stop(tmp_path, ranks):
    options = PATHS["bounded"]
    deck = bed_deck(tmp_path, *options, balls=BALLS, length=LENGTH)
    tail = CHARGE + DRIVE.format(every=50)
    restarts = "fix signed all mill/restart\nrestart 725 half.restart half.restart\n"
    whole = run(tmp_path, deck + tail + restarts + series(50) + "run 1000\n", ranks)
    assert whole.code == 0, whole.text[-600:]
    again = again_deck(*options, deck) + tail + series(50, "again.txt") + "run 1000 upto\n"
    ran = run(tmp_path, again, ranks)
    assert ran.code == 0, ran.text[-600:]
    expected, got = read(tmp_path), read(tmp_path, "again.txt")
    np.testing.assert_array_equal(got, expected[expected[:, 0] >= got[0, 0]])
    assert len(got) == 6


@pytest.mark.engine
def test_a_mesh_wall_is_summed_too(tmp_path):
    deck = bed_deck(tmp_path, "fast", "", balls=BALLS, length=LENGTH, wall="mesh")
    _, time, work, impulse, _, _, _, momentum, centre, _ = turned(tmp_path, deck, 10).T
    by_gravity = WEIGHT * np.trapezoid(centre, time)
    # The engine's torque leaves out the reaction of rolling friction: mu_r a / R of the forces.
    share = 0.01 * 0.02 / RADIUS
    balance = momentum[-1] - momentum[0] - by_gravity
    assert impulse[-1] - impulse[0] == pytest.approx(
        balance, abs=3.0 * share * WEIGHT * RADIUS * (time[-1] - time[0])
    )
    assert work[-1] == pytest.approx(np.sqrt(S) * impulse[-1], rel=1e-9)


WRONG = [
    ("mill nothing wall liner every 5", "mill: 'nothing' is not the id of a fix mill/similarity"),
    ("mill mill wall nothing every 5", "wall: 'nothing' is not the id of a fix wall/mill or mesh"),
    ("mill mill wall integrate every 5", "wall: 'integrate' is not the id of a fix wall/mill"),
    ("mill mill wall liner", "every: give the number of steps between two rows of the series"),
    ("mill mill wall liner every 0", "every: give the number of steps"),
    ("mill mill wall liner each 5", "unknown keyword 'each'; accepted are mill, wall, every"),
]


@pytest.mark.engine
@pytest.mark.parametrize(("words", "cause"), WRONG)
def test_wrong_arguments_are_refused(tmp_path, words, cause):
    deck = bed_deck(tmp_path, "fast", "") + f"fix drive all mill/drive {words}\n"
    ran = run(tmp_path, deck)
    assert ran.code != 0
    assert cause in ran.error
