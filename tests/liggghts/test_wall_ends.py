"""Flat ends of the analytic wall; ranks, restarts and ball sizes on wall and ends."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from millscale import _core
from scene import run
from wall_bench import (
    INTEGRATE,
    WALLS,
    Balls,
    Materials,
    Mill,
    columns,
    deck,
    flats,
    fly,
    fly_in_halves,
    over_flat,
)

LINER = _core.Lifters(1.5, 3.61 / 2.6, 0.25 / 2.6, 0.635 / 2.6, 25)
DRUM = _core.Lifters(1.5, 0.0, 0.0, 0.0, 0)
CHORD_ERROR = 5e-4
RADIUS = 0.02
LOW, HIGH = 0.1, 0.4
CLOSED = {"words": f"ends {LOW} {HIGH}", "boundary": "f f f"}


def test_an_impact_on_an_end_is_one_on_a_flat_wall(tmp_path):
    liner, chord_error = flats(12)
    middle, inward, along = (v[0] for v in over_flat(liner, chord_error, np.array([0])))
    middle[1] = 0.25
    speed, spin = np.array([-2.0, 1.5, 0.4]), np.array([3.0, 20.0, -7.0])  # inward, along, across
    frames = [  # origin, and the directions inward, along, across as rows
        (middle, np.array([inward, along, np.cross(inward, along)])),
        ([0.3, LOW, 0.2], np.array([[0, 1, 0], [1, 0, 0], [0, 0, -1.0]])),
        ([0.3, HIGH, 0.2], np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1.0]])),
    ]
    place = [origin + (RADIUS + 2.13e-4) * frame[0] for origin, frame in frames]
    balls = Balls.of(place, [speed @ f for _, f in frames], [spin @ f for _, f in frames])
    mill = Mill("analytic", liner, chord_error, **CLOSED)
    state = fly(tmp_path, mill, balls, Materials(), 1e-5, 1000)[-1]
    for names in ("vx vy vz", "omegax omegay omegaz"):
        flat, low, high = (
            frame @ v for (_, frame), v in zip(frames, columns(state, names), strict=True)
        )
        assert_allclose([low, high], [flat, flat], rtol=1e-9, atol=1e-10)
    assert (columns(state, "vy")[1:, 0] * [1.0, -1.0] > 0.3).all()


def _pressed_on_end(folder, motion):
    """A ball that moves with the mill, pressed on the lower end: its place, force and torque, and
    force and torque on the wall."""
    omega, place = 1.6, np.array([0.6, LOW + RADIUS - 1e-4, -0.3])
    turning = np.array([0.0, omega, 0.0])
    balls = Balls.of(place, np.cross(turning, place), turning)
    words = f"{CLOSED['words']} end_motion {motion}"
    mill = Mill("arc", DRUM, 0.0, omega=omega, start="-1e-9", words=words, boundary="f f f")
    text = deck(folder, mill, balls, Materials(), 1e-5) + INTEGRATE
    text += 'run 0\nprint "ball $(fx[1]) $(fy[1]) $(fz[1]) $(tqx[1]) $(tqy[1]) $(tqz[1])"\n'
    text += 'print "wall ' + " ".join(f"$(f_liner[{k}])" for k in range(1, 7)) + '"\n'
    result = run(folder, text)
    return place, result.printed("ball"), result.printed("wall")


def test_ends_turn_with_the_mill_or_rest(tmp_path):
    place, on_ball, on_mill = _pressed_on_end(tmp_path, "mill")
    force = on_ball[:3]
    assert force[1] > 1.0
    assert np.abs(force[[0, 2]]).max() < 1e-9 * force[1]  # moving with the end, nothing slides
    assert_allclose(on_mill[:3], -force, rtol=1e-9, atol=1e-9)

    place, on_ball, on_mill = _pressed_on_end(tmp_path, "rest")
    force, torque = on_ball[:3], on_ball[3:]
    velocity = np.cross([0.0, 1.6, 0.0], place)
    assert force @ velocity < -0.01
    # All that the ball gains in angular momentum, rolling friction included.
    assert_allclose(on_mill[3:], -(np.cross(place, force) + torque), rtol=1e-9)


def test_an_end_is_wall_but_not_liner(tmp_path):
    # Off the groove at 1 m/s and pressed on an end all the way: liner contact lost, no flight.
    balls = Balls.of([[0.0, LOW + RADIUS - 1e-4, -(1.5 - RADIUS + 1e-4)]], [[0.0, 0.0, 1.0]])
    mill = Mill("arc", LINER, 0.0, **CLOSED)
    text = deck(tmp_path, mill, balls, Materials(), 1e-4) + INTEGRATE
    text += (
        "fix press all addforce 0 -5 0\n"
        f"compute detach all mill/detach mill mill lifters 25 lifter_top_radius {3.61 / 2.6!r}\n"
        "compute one all reduce max c_detach[1] c_detach[2] c_detach[12]\n"
        "thermo_style custom step c_one[1]\nrun 1000\n"
        'print "state $(c_one[1]) $(c_one[2]) $(c_one[3])"\n'
    )
    assert_array_equal(run(tmp_path, text).printed("state"), [1, 1, 0])


def _flying(count=60):
    """Balls of different sizes, thrown about between the ends."""
    random = np.random.default_rng(11)
    psi = 2.0 * np.pi / 25 * random.integers(0, 25, count)
    place = 1.42 * np.column_stack([-np.sin(psi), 0.0 * psi, -np.cos(psi)])
    place[:, 1] = random.uniform(LOW + 0.05, HIGH - 0.05, count)
    velocity = 2.0 * random.normal(size=(count, 3))
    return Balls.of(place, velocity, 0.0, random.uniform(0.01, 0.05, count))


def _rolling(count=20):
    """Balls that roll along the drum's bottom, over panel after panel, and along the axis."""
    random = np.random.default_rng(12)
    psi = random.uniform(-1.0, 1.0, count)
    at = 1.5 - RADIUS + 3e-4
    place = np.column_stack(
        [-at * np.sin(psi), random.uniform(0.15, 0.35, count), -at * np.cos(psi)]
    )
    velocity = 2.0 * np.column_stack([-np.cos(psi), 0.0 * psi, np.sin(psi)])
    velocity[:, 1] = random.uniform(-2.0, 2.0, count)
    return Balls.of(place, velocity)


def _mill(wall, liner):
    """A turning mill with weight: analytic closed by ends, mesh periodic."""
    closed = CLOSED if wall != "mesh" else {}
    return Mill(wall, liner, CHORD_ERROR, omega=1.6, start="now", gravity=9.81, **closed)


NAMES = "x y z vx vy vz omegax omegay omegaz"
SCENES = {"flying": (_flying, LINER), "rolling": (_rolling, DRUM)}


STOCK_RANKS = (
    "over the joint of two panels the engine's choice of the panel depends on the rank: after "
    "0.15 s a ball's spin differs by 0.1 rad/s"
)


@pytest.mark.parametrize(
    ("wall", "ranks", "scene"),
    [
        ("mesh", 2, "flying"),
        ("mesh", 2, "rolling"),
        ("analytic", 2, "flying"),
        ("analytic", 2, "rolling"),
        ("arc", 4, "flying"),
        ("arc", 4, "rolling"),
    ],
)
def test_balls_move_the_same_on_any_number_of_ranks(tmp_path, contact_row, wall, ranks, scene):
    balls, liner = SCENES[scene][0](), SCENES[scene][1]
    mill, steps = _mill(wall, liner), 600 if scene == "flying" else 1500
    one, many = (
        columns(fly(tmp_path / f"{n}", mill, balls, Materials(), 1e-4, steps, ranks=n)[-1], NAMES)
        for n in (1, ranks)
    )
    # A ball's forces are its own, and each is summed in one order on whatever rank.
    border = 0.25  # between ranks
    assert ((one[:, 1] > border) != (balls.position[:, 1] > border)).sum() >= 3
    contact_row(
        "fault: the result depends on the number of ranks",
        "-",
        wall,
        f"difference of {scene} balls on {ranks} ranks from one",
        dt=1e-4,
        expected=0.0,
        got=np.abs(many - one).max(),
        tolerance=0.0,
        reason="a ball's forces are its own, and each is summed in one order on whatever rank",
        fault=STOCK_RANKS if (wall, scene) == ("mesh", "rolling") else None,
    )


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("wall", WALLS)
def test_a_restart_changes_nothing(tmp_path, contact_row, wall, scene):
    balls, mill = SCENES[scene][0](), _mill(wall, SCENES[scene][1])
    whole = columns(fly(tmp_path / "whole", mill, balls, Materials(), 1e-4, 600)[-1], NAMES)
    halves = columns(fly_in_halves(tmp_path / "halves", mill, balls, Materials(), 1e-4, 600), NAMES)
    contact_row(
        "fault: a restart changes the motion",
        "-",
        wall,
        f"difference of {scene} balls",
        dt=1e-4,
        expected=0.0,
        got=np.abs(halves - whole).max(),
        tolerance=1e-9 if wall == "mesh" else 0.0,
        reason="the restart rounds the mesh's nodes once more, 1e-16 R, which impacts amplify; "
        "the analytic wall has none",
    )
