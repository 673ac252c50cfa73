"""fix mill/occupancy: the file against the balls it was made of, ranks, restarts, its errors."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from scene import (
    HEAD,
    SLICE,
    analytic_wall,
    loose_bed,
    material,
    mill_deck,
    read_dump,
    run,
    wall_and_drive,
)

S = 2.6
RADIUS, BALL, DT = 3.9 / S, 0.02, 1e-4
SPEED = float(np.sqrt(S))  # of the mill [rad/s]
EVERY, STEPS = 20, 400
# Steps 100 to 300, and a hair more, so that rounding of the angle decides nothing.
FROM, TO = 99.5 * DT * SPEED, 300.5 * DT * SPEED
RINGS, SECTORS = 12, 36
COLUMNS = (
    "mill_angle_from_rad,mill_angle_to_rad,samples,radius_low,radius_high,angle_low_rad,"
    "angle_high_rad,solid_fraction"
)
WINDOW = f"from {FROM!r} to {TO!r}"
DUMP = (
    f"dump all all custom {EVERY} balls.*.dump id x y z radius\n"
    f'dump_modify all format "%d{" %.17g" * 4}"\n'
)


def _fix(window=WINDOW):
    return (
        f"fix occupancy all mill/occupancy mill mill every {EVERY} {window} "
        f"rings {RINGS} sectors {SECTORS} file occupancy.csv\n"
    )


def _deck(folder, balls=250):
    # 0.5 m/s to the side: some balls cross from cell to cell.
    return (
        mill_deck(
            folder,
            loose_bed(RADIUS, balls, SLICE, seed=6),
            S,
            "constant-gravity",
            dt=DT,
            wall="analytic",
        )
        + "velocity all set 0.5 0.2 0\n"
    )


def _read(folder):
    lines = (folder / "occupancy.csv").read_text().splitlines()
    assert lines[0] == COLUMNS
    table = np.array([[float(word) for word in line.split(",")] for line in lines[1:]])
    return dict(zip(COLUMNS.split(","), table.T, strict=True))


def _by_definition(folder, steps):
    """(RINGS, SECTORS) mean solid fraction of the dumped balls at some steps."""
    reach, total = RADIUS - BALL, 0.0
    for step in steps:
        balls = read_dump(folder / f"balls.{step}.dump")
        distance = np.hypot(balls["x"], balls["z"]) / reach
        angle = np.arctan2(-balls["x"], balls["z"]) % (2 * np.pi)
        volume, *_ = np.histogram2d(
            np.minimum(distance, 1.0),
            angle,
            bins=(RINGS, SECTORS),
            range=((0, 1), (0, 2 * np.pi)),
            weights=4 / 3 * np.pi * balls["radius"] ** 3,
        )
        total = total + volume / len(steps)
    edge = np.linspace(0, 1, RINGS + 1) * reach
    area = np.pi * np.diff(edge**2)[:, None] / SECTORS
    return total / (area * SLICE)


def _check(table, folder, steps):
    assert (table["samples"] == len(steps)).all()
    # Ten digits are written.
    assert_allclose(table["mill_angle_from_rad"], steps[0] * DT * SPEED, rtol=1e-9)
    assert_allclose(table["mill_angle_to_rad"], steps[-1] * DT * SPEED, rtol=1e-9)
    solid = table["solid_fraction"].reshape(RINGS, SECTORS)
    assert_allclose(solid, _by_definition(folder, steps), rtol=2e-9)
    assert (solid > 0).sum() > 5


@pytest.mark.parametrize("ranks", [1, 2])
def test_the_file_is_the_average_of_the_balls_between_two_mill_angles(tmp_path, ranks):
    result = run(tmp_path, _deck(tmp_path) + _fix() + DUMP + f"run {STEPS}\n", ranks)
    assert result.code == 0, result.text[-2000:]
    table = _read(tmp_path)
    _check(table, tmp_path, range(100, 301, EVERY))
    edges = np.linspace(0, 1, RINGS + 1), np.linspace(0, 2 * np.pi, SECTORS + 1)
    ring, sector = np.divmod(np.arange(RINGS * SECTORS), SECTORS)
    assert_allclose(table["radius_low"], edges[0][ring], atol=1e-9)
    assert_allclose(table["radius_high"], edges[0][ring + 1], atol=1e-9)
    assert_allclose(table["angle_low_rad"], edges[1][sector], atol=1e-9)
    assert_allclose(table["angle_high_rad"], edges[1][sector + 1], atol=1e-9)
    assert not (tmp_path / "occupancy.csv.part").exists()


def test_a_run_that_ends_within_the_window_leaves_the_average_so_far(tmp_path):
    result = run(tmp_path, _deck(tmp_path) + _fix() + DUMP + "run 200\n")
    assert result.code == 0, result.text[-2000:]
    _check(_read(tmp_path), tmp_path, range(100, 201, EVERY))


def test_a_run_that_ends_before_the_window_writes_nothing(tmp_path):
    assert run(tmp_path, _deck(tmp_path, 20) + _fix() + "run 80\n").code == 0
    assert not (tmp_path / "occupancy.csv").exists()


@pytest.mark.parametrize("ranks", [1, 2])
def test_a_restart_within_the_window_goes_on_with_the_average(tmp_path, ranks):
    half = f"run {STEPS // 2}\nwrite_restart half.restart\n"
    assert run(tmp_path, _deck(tmp_path) + _fix() + DUMP + half, ranks).code == 0
    (tmp_path / "occupancy.csv").unlink()
    top = f"lifters 25 lifter_top_radius {3.61 / S!r}"
    again = (
        HEAD
        + "read_restart half.restart\n"
        + material(0.02, DT)
        + wall_and_drive(S, "constant-gravity", analytic_wall(S), "now", top)
    )
    result = run(tmp_path, again + _fix() + DUMP + f"run {STEPS // 2}\n", ranks)
    assert result.code == 0, result.text[-2000:]
    _check(_read(tmp_path), tmp_path, range(100, 301, EVERY))


WRONG = [
    ("mill nobody every 1 to 1 file a", "'nobody' is not the id of a fix mill/similarity"),
    ("mill mill every 1 to 1", "file: the name of the file to write is needed"),
    ("mill mill every 0 to 1 file a", "every: expected a number of steps >= 1"),
    ("mill mill every 1 file a", "mill angles 0 <= from < to are needed [rad], got 0 and -1"),
    ("mill mill every 1 from 2 to 1 file a", "0 <= from < to are needed [rad], got 2 and 1"),
    ("mill mill every 1 to 1 file a rings 0", "rings and sectors must be > 0, got 0 and 180"),
    ("mill mill every 1 to 1 file a cells 3", "unknown keyword 'cells'; accepted are"),
]


@pytest.mark.parametrize(("words", "cause"), WRONG, ids=[words for words, _ in WRONG])
def test_wrong_arguments_give_one_line_of_cause(tmp_path, words, cause):
    result = run(tmp_path, _deck(tmp_path, 1) + f"fix occupancy all mill/occupancy {words}\n")
    assert result.code != 0
    assert cause in result.error


def test_a_file_that_cannot_be_written_stops_the_run(tmp_path):
    deck = _deck(tmp_path, 1) + _fix().replace("occupancy.csv", "nowhere/occupancy.csv")
    result = run(tmp_path, deck + f"run {STEPS}\n")
    assert result.code != 0
    assert "file: cannot write 'nowhere/occupancy.csv'" in result.error
