"""compute mill/charge: against the definitions in numpy, on one rank and two; its errors."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from millscale import _core
from scene import SLICE, loose_bed, mill_deck, read_dump, run

S = 2.6
RADIUS, TOP, BALL = 3.9 / S, 3.61 / S, 0.02
GRAVITY = 9.81
LINER = _core.Lifters(RADIUS, TOP, 0.25 / S, 0.635 / S, 25)
SHAPE = (
    f"lifters 25 lifter_top_radius {TOP!r} lifter_top_width {0.25 / S!r} groove_width {0.635 / S!r}"
)
NAMES = (
    *("balls", "mass", "translation", "rotation", "potential", "x", "z", "fixed", "rotating"),
    *("toe", "shoulder", "overlap", "ball_overlap", "wall_overlap", "speed", "angular_momentum"),
    "liner_slip",
)
PRINT = 'print "charge ' + " ".join(f"$(c_charge[{k}])" for k in range(1, 18)) + '"\n'
DUMP = (
    "dump end all custom 1 end.dump id x y z vx vy vz omegax omegay omegaz radius mass\n"
    'dump_modify end format "%d' + " %.17g" * 11 + '"\n'
)


def _measure(folder, deck, steps, box="", ranks=1):
    """Numbers of the compute after `steps` by name, its balls, and the mill's angle and speed."""
    deck += f"compute charge all mill/charge mill mill {SHAPE} {box}\n"
    deck += f"thermo_style custom step c_charge[1]\nthermo {max(steps, 1)}\n"
    deck += f'run {steps}\nprint "turned $(f_mill[1]) $(f_mill[2])"\n{PRINT}{DUMP}run 0\n'
    result = run(folder, deck, ranks)
    assert result.code == 0, result.text[-2000:]
    values = dict(zip(NAMES, result.printed("charge"), strict=True))
    return values, read_dump(folder / "end.dump"), *result.printed("turned")


def _within(corners, points):
    """(n,) bool: points (n, 2) inside a convex polygon (4, 2)."""
    sides = np.roll(corners, -1, axis=0) - corners
    to = points[:, None, :] - corners
    turn = sides[:, 0] * to[..., 1] - sides[:, 1] * to[..., 0]
    return (turn >= 0).all(axis=1) | (turn <= 0).all(axis=1)


def _turned(corners, angle):
    """(n, 2) points x, z turned with the mill: the bottom moves towards -x."""
    x, z = np.asarray(corners).T
    c, s = np.cos(angle), np.sin(angle)
    return np.column_stack([c * x + s * z, c * z - s * x])


def _bed_by_definition(balls):
    """Toe and shoulder: the best of all two-level steps through the mass in the wall layer."""
    distance, angle = np.hypot(balls["x"], balls["z"]), np.arctan2(-balls["x"], balls["z"])
    layer = (distance >= TOP - 2 * BALL) & (distance <= TOP)
    bins = round(2 * np.pi * (TOP - BALL) / BALL)
    width = 2 * np.pi / bins
    # Bin 0 begins at the top and goes down the rising side.
    mass = np.bincount(((angle[layer] % (2 * np.pi)) / width).astype(int), minlength=bins)
    best = (np.inf, 0, 0)
    for first in range(bins):
        rolled = np.roll(mass, -first).astype(float)
        below = np.cumsum(rolled)[:-1]
        k = np.arange(1, bins)
        inside, outside = below / k, (below[-1] + rolled[-1] - below) / (bins - k)
        misfit = np.where(inside > outside, -(k * inside**2 + (bins - k) * outside**2), np.inf)
        at = misfit.argmin()
        best = min(best, (misfit[at], first, k[at]))
    shoulder = best[1] * width
    shoulder -= 2 * np.pi * (shoulder > np.pi)
    return shoulder + best[2] * width, shoulder, width


def _largest_overlap(balls):
    """Of all pairs, also across the periodic ends."""
    position = np.column_stack([balls[name] for name in "xyz"])
    gap = position[:, None] - position
    gap[..., 1] -= SLICE * np.round(gap[..., 1] / SLICE)
    distance = np.sqrt((gap**2).sum(axis=-1)) + 10 * np.eye(len(position))
    return (balls["radius"][:, None] + balls["radius"] - distance).max()


def _check_against_definitions(values, balls, box_fixed, angle, omega):
    mass, v2 = balls["mass"], sum(balls[f"v{d}"] ** 2 for d in "xyz")
    spin2 = sum(balls[f"omega{d}"] ** 2 for d in "xyz")
    section = np.column_stack([balls["x"], balls["z"]])
    box_rotating = _turned(box_fixed, angle)
    at_rest = _turned(section, -angle)
    wall = balls["radius"] - [LINER.nearest(*p).distance for p in at_rest]
    path = mass * (balls["z"] * balls["vx"] - balls["x"] * balls["vz"])
    touches, inertia = wall > 0.0, mass * (section**2).sum(axis=1)
    expected = {
        "balls": len(mass),
        "mass": mass.sum(),
        "translation": (mass * v2).sum() / 2,
        "rotation": (0.2 * mass * balls["radius"] ** 2 * spin2).sum(),
        "potential": GRAVITY * (mass * balls["z"]).sum(),
        "x": (mass * balls["x"]).sum() / mass.sum(),
        "z": (mass * balls["z"]).sum() / mass.sum(),
        "fixed": mass[_within(box_fixed, section)].sum() / mass.sum(),
        "rotating": mass[_within(box_rotating, section)].sum() / mass.sum(),
        "ball_overlap": max(_largest_overlap(balls), 0.0),
        "wall_overlap": max(wall.max(), 0.0),
        "speed": np.sqrt(v2.max()),
        "angular_momentum": (path + 0.4 * mass * balls["radius"] ** 2 * balls["omegay"]).sum(),
        "liner_slip": (
            1 - path[touches].sum() / (omega * inertia[touches].sum()) if omega else np.nan
        ),
    }
    expected["overlap"] = max(expected["ball_overlap"], expected["wall_overlap"])
    for name, value in expected.items():
        # Sums in another order; overlaps are small differences of lengths around 1.5 m.
        assert_allclose(values[name], value, rtol=1e-11, atol=1e-14, err_msg=name)
    assert expected["overlap"] > 0
    assert 0 < expected["rotating"] < 1
    toe, shoulder, width = _bed_by_definition(balls)
    assert_allclose([values["toe"], values["shoulder"]], [toe, shoulder], atol=1e-9 * width)


def test_a_moving_charge_measures_as_its_definitions_say(tmp_path):
    charge = loose_bed(RADIUS, 250, SLICE, seed=4)
    deck = mill_deck(tmp_path, charge, S, "constant-gravity", dt=1e-4, wall="analytic")
    values, balls, angle, omega = _measure(tmp_path, deck, 1500)
    assert angle > 0.2
    corners = np.array(LINER.groove_box())
    _check_against_definitions(values, balls, corners, angle, omega)
    assert values["rotation"] > 0
    assert 0.01 < values["liner_slip"] < 2


def test_the_box_stands_where_it_is_asked_to(tmp_path):
    charge = loose_bed(RADIUS, 250, SLICE, seed=4)
    deck = mill_deck(tmp_path, charge, S, "constant-gravity", dt=1e-4, wall="analytic")
    values, balls, angle, omega = _measure(tmp_path, deck, 1500, box="box_angle 0.1")
    _check_against_definitions(values, balls, _turned(LINER.groove_box(), 0.1), angle, omega)


def _ring_of_balls():
    """(n, 3): a layer along the wall from 1.2 to 3.9 rad from the top, overlapping, some also
    across the periodic ends, and balls scattered inside."""
    random = np.random.default_rng(8)
    angle = np.repeat(np.arange(1.2, 3.9, 0.0285), 4)
    distance = TOP - BALL + random.uniform(-2e-3, 2e-3, angle.size)
    y = np.tile([0.001, 0.07, 0.13, 0.1605], angle.size // 4) + random.uniform(0, 5e-4, angle.size)
    layer = np.column_stack([-distance * np.sin(angle), y, distance * np.cos(angle)])
    loose = random.uniform([-0.8, 0.01, -0.8], [0.8, 0.19, 0.8], (40, 3))
    in_groove = np.array([[x, y, -1.45] for x in (-0.05, 0.0, 0.06) for y in (0.05, 0.1, 0.199)])
    return np.vstack([layer, loose, in_groove])


def test_a_known_bed_measures_the_same_on_one_rank_and_on_two(tmp_path):
    charge, measured = _ring_of_balls(), []
    for ranks in (1, 2):
        folder = tmp_path / str(ranks)
        folder.mkdir()
        deck = mill_deck(
            folder, charge, S, "constant-gravity", dt=1e-4, start="never", wall="analytic"
        )
        deck += "velocity all set 0.1 -0.2 0.3\n"
        values, balls, angle, omega = _measure(folder, deck, 0, ranks=ranks)
        measured.append(values)
    one, two = measured
    assert_allclose([two[n] for n in NAMES], [one[n] for n in NAMES], rtol=1e-11, atol=1e-14)
    _check_against_definitions(one, balls, np.array(LINER.groove_box()), angle, omega)
    resolution = BALL / (TOP - BALL)
    assert one["shoulder"] == pytest.approx(1.2, abs=resolution)
    assert one["toe"] == pytest.approx(3.9, abs=2 * resolution)  # the last ball, and its bin
    assert one["potential"] != 0


@pytest.mark.parametrize("ranks", [1, 2])
def test_a_ball_outside_the_liner_stops_the_run_and_is_named(tmp_path, ranks):
    charge = np.array([[0.0, 0.1, -1.4], [0.0, 0.1, -1.505]])
    deck = mill_deck(
        tmp_path, charge, S, "constant-gravity", dt=1e-4, start="never", wall="analytic"
    )
    deck += f"compute charge all mill/charge mill mill {SHAPE}\n"
    deck += "unfix liner\nthermo_style custom step c_charge[1]\nrun 1\n"
    result = run(tmp_path, deck, ranks)
    assert result.code != 0
    assert (
        "1 balls outside the liner at step 0: id 2 with its centre at (0, 0.1, -1.505) m"
        in result.error
    )


def test_a_lost_ball_stops_the_run(tmp_path):
    charge = np.array([[0.0, 0.1, -1.2], [0.0, 0.1, -1.3], [0.0, 0.1, -1.0]])
    deck = mill_deck(
        tmp_path, charge, S, "constant-gravity", dt=1e-4, start="never", wall="analytic"
    )
    deck = deck.replace("thermo_modify lost error", "thermo_modify lost ignore")
    # It leaves the liner and the box, 0.23 m away, between steps 2 and 4.
    deck += (
        "group gone id 2\nvelocity gone set 0 0 -700\nunfix liner\nneigh_modify every 1 check no\n"
    )
    deck += f"compute charge all mill/charge mill mill {SHAPE}\n"
    deck += 'fix series all print 2 "$(c_charge[1])" screen no\nrun 10\n'
    result = run(tmp_path, deck)
    assert result.code != 0
    assert "1 of 3 balls lost since the last sample, seen at step 4, id 2;" in result.error


WRONG = [
    ("mill nobody", "'nobody' is not the id of a fix mill/similarity"),
    ("lifters 25", "mill: the id of a fix mill/similarity is needed"),
    ("mill mill lifters 25 lifter_top_radius 4", "lifter top radius"),
    ("mill mill box_angle east", "box_angle: expected a number, got 'east'"),
    ("mill mill angle 3", "unknown keyword 'angle'; accepted are"),
]


@pytest.mark.parametrize(("words", "cause"), WRONG, ids=[words for words, _ in WRONG])
def test_wrong_arguments_give_one_line_of_cause(tmp_path, words, cause):
    deck = mill_deck(tmp_path, np.array([[0.0, 0.1, -1.3]]), S, "constant-gravity", wall="analytic")
    result = run(tmp_path, deck + f"compute charge all mill/charge {words}\nrun 1\n")
    assert result.code != 0
    assert cause in result.error
