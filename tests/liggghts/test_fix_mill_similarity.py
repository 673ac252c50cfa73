"""fix mill/similarity: what it derives, applies and turns, and what it refuses."""

import math

import numpy as np
import pytest

from millscale import _core
from scene import HEAD, material, read_dump, run, write_liner

BALL = 0.02
PAPER = "radius 3.9 gravity 9.81 omega 1.0 ball_radius 0.02"
BOX = """
region box block -4.2 4.2 0 0.2 -4.2 4.2 units box
create_box 2 box
"""
ONE_BALL = """
create_atoms 1 single 0.3 0.1 0.4 units box
set type 1 diameter 0.04 density 2678
"""
FREE = HEAD + BOX + material(0.2, 1e-4) + ONE_BALL
ALL_VALUES = 'print "values ' + " ".join(f"$(f_mill[{k}])" for k in range(1, 14)) + '"\n'


@pytest.mark.parametrize("policy", ["paper", "corrected", "offset-liner"])
@pytest.mark.parametrize(
    ("scheme", "time_factor"),
    [("constant-gravity", 0.0), ("constant-speed", 0.0), ("froude", 0.8)],
)
def test_derives_what_the_law_says(tmp_path, scheme, time_factor, policy):
    deck = FREE + (
        f"fix mill all mill/similarity {PAPER} scale 2.6 scheme {scheme} "
        f"time_factor {time_factor} policy {policy} start never\n"
        "run 0\n" + ALL_VALUES
    )
    values = run(tmp_path, deck).printed("values")

    physical = _core.OperatingPoint(3.9, BALL, 9.81, 1.0)
    law = _core.scale(physical, 2.6, scheme, policy, time_factor)
    expected = [
        *(0.0, 0.0, law.mill.gravity, law.froude, law.mill.radius, law.mill.omega),
        *(law.base.length, law.base.mass, law.base.time),
        *(law.predicted_energy_ratio, law.centre_path_energy_ratio),
        *(_core.detach_angle(law.froude), 0.0),
    ]
    np.testing.assert_array_equal(values, expected)  # both come from the same header


def test_a_free_ball_falls_with_the_scaled_gravity(tmp_path):
    deck = FREE + (
        f"fix mill all mill/similarity {PAPER} scale 2.6 scheme constant-speed\n"
        "fix integrate all nve/sphere\nrun 1000\n"
        'print "ball $(x[1]) $(y[1]) $(z[1]) $(vz[1])"\n'
    )
    x, y, z, vz = run(tmp_path, deck).printed("ball")
    g, t = 9.81 / 2.6, 0.1
    # Velocity Verlet is exact under constant force, up to 1000 roundings.
    np.testing.assert_allclose([x, y], [0.3, 0.1], rtol=1e-15)
    np.testing.assert_allclose([z, vz], [0.4 - g * t * t / 2, -g * t], rtol=1e-12)


def test_gravity_acts_along_down(tmp_path):
    deck = FREE + (
        f"fix mill all mill/similarity {PAPER} axis 0 1 0 down 3 0 0\n"
        "fix integrate all nve/sphere\nrun 100\n"
        'print "ball $(vx[1]) $(vy[1]) $(vz[1])"\n'
    )
    v = run(tmp_path, deck).printed("ball")
    np.testing.assert_allclose(v, [0.0981, 0.0, 0.0], rtol=1e-12, atol=1e-15)


def _turning_drum(folder, extra, steps, before_run=""):
    drum = _core.Lifters(0.5, 0.45, 0.05, 0.09, 14)
    curvature = write_liner(folder, drum, 0.2, 1e-3)
    return (
        HEAD
        + "region box block -0.6 0.6 0 0.2 -0.6 0.6 units box\ncreate_box 2 box\n"
        + material(0.1, 1e-4)
        + "create_atoms 1 single 0 0.1 0 units box\nset type 1 diameter 0.04 density 2678\n"
        + f"fix liner all mesh/surface/stress file liner.stl type 2 curvature {curvature!r}\n"
        + "fix wall all wall/gran model hertz tangential history rolling_friction cdt "
        "mesh n_meshes 1 meshes liner\n"
        + "fix mill all mill/similarity radius 0.5 gravity 1e-9 omega 2e-5 ball_radius 0.02 "
        + f"mesh liner {extra}\n"
        + "fix integrate all nve/sphere\n"
        + before_run
        + f"run {steps}\n"
    )


def _stl_nodes(path):
    words = [line.split() for line in path.read_text().splitlines() if "vertex" in line]
    return np.array([[float(w) for w in line[1:4]] for line in words])


def test_the_mesh_turns_by_the_mill_angle_about_its_axis(tmp_path):
    dump = "dump turned all mesh/stl 2000 turned*.stl\n"
    result = run(
        tmp_path,
        _turning_drum(tmp_path, "", 2000, dump).replace("omega 2e-5", "omega 2.0")
        .replace("gravity 1e-9", "gravity 9.81")
        + 'print "angle $(f_mill)"\n',
    )  # fmt: skip
    angle = result.printed("angle")[0]
    assert angle == pytest.approx(0.4, rel=1e-14)
    before, after = (_stl_nodes(tmp_path / f"turned{step}.stl") for step in (0, 2000))
    # The bottom moves towards -x: (x, z) turn by the angle about +y.
    c, s = math.cos(angle), math.sin(angle)
    expected = np.column_stack(
        [before[:, 0] * c + before[:, 2] * s, before[:, 1], before[:, 2] * c - before[:, 0] * s]
    )
    np.testing.assert_allclose(after, expected, atol=2e-6)  # the engine writes STL with 6 digits


def test_the_mill_stands_still_until_its_start(tmp_path):
    # Froude number 2e-10: the ball in the middle stays where it is, far from the wall.
    deck = _turning_drum(tmp_path, "start 0.05", 400) + ALL_VALUES
    deck += 'run 200\nprint "later $(f_mill[1]) $(f_mill[2])"\n'
    result = run(tmp_path, deck)
    assert result.printed("values")[0] == 0.0
    angle, speed = result.printed("later")
    assert angle == pytest.approx(2e-5 * 0.01, rel=1e-12)
    assert speed == 2e-5


def test_a_ball_on_a_turning_wall_is_driven_at_wall_speed(tmp_path):
    drum = _core.Lifters(0.5, 0, 0, 0, 0)
    curvature = write_liner(tmp_path, drum, 0.2, 1e-4)
    deck = (
        HEAD
        + "region box block -0.6 0.6 0 0.2 -0.6 0.6 units box\ncreate_box 2 box\n"
        + material(0.1, 2e-5)
        + "create_atoms 1 single 0 0.1 -0.48001 units box\nset type 1 diameter 0.04 density 2678\n"
        + f"fix liner all mesh/surface file liner.stl type 2 curvature {curvature!r}\n"
        + "fix wall all wall/gran model hertz tangential history mesh n_meshes 1 meshes liner\n"
        + "fix mill all mill/similarity radius 0.5 gravity 9.81 omega 0.5 ball_radius 0.02 "
        + "mesh liner start 0.05\nfix integrate all nve/sphere\nrun 20000\n"
        + 'print "ball $(vx[1]) $(omegay[1]) $(x[1]) $(z[1])"\n'
    ).replace(" rolling_friction cdt", "")
    vx, spin, x, z = run(tmp_path, deck).printed("ball")
    radius = math.hypot(x, z)
    along = (vx * z) / radius  # speed along the wall, positive with the rotation
    # Without rolling friction the surface of the ball moves with the wall: no slip.
    slip = 0.5 * 0.5 - (along + 0.02 * spin)
    assert abs(slip) < 0.02 * 0.5 * 0.5
    assert spin > 1.0


WRONG = [
    ("scale 0.5", "S: must be >= 1"),
    ("scale 200", "must exceed the ball radius"),
    ("scale two", "scale: expected a number, got 'two'"),
    ("scale 2o", "scale: expected a number, got '2o'"),
    ("scheme constant-weight", "accepted are constant-gravity, constant-speed, froude"),
    ("scheme froude", "time factor"),
    ("policy none", "accepted are paper, corrected, offset-liner"),
    ("omega 10", "centrifuging"),
    ("mesh nothing", "mesh 'nothing' is not the id of a fix mesh/surface"),
    ("axis 0 0 1", "perpendicular"),
    ("speed 3", "unknown keyword 'speed'; accepted are"),
    ("start soon", "now, or never"),
    ("scale", "the command ends here"),
]


@pytest.mark.parametrize(("words", "cause"), WRONG, ids=[words for words, _ in WRONG])
def test_wrong_arguments_give_one_line_of_cause(tmp_path, words, cause):
    result = run(tmp_path, FREE + f"fix mill all mill/similarity {PAPER} {words}\nrun 1\n")
    assert result.code != 0
    assert "Fix mill/similarity (id mill)" in result.error
    assert cause in result.error


def test_a_missing_physical_mill_is_named(tmp_path):
    result = run(tmp_path, FREE + "fix mill all mill/similarity scale 2\nrun 1\n")
    assert "needs radius, gravity, omega and ball_radius" in result.error


def test_centrifuging_runs_when_allowed(tmp_path):
    words = PAPER.replace("omega 1.0", "omega 3.0") + " centrifuging allow"
    deck = FREE + f"fix mill all mill/similarity {words}\nrun 0\n" + ALL_VALUES
    assert run(tmp_path, deck).printed("values")[3] == pytest.approx(9 * 3.9 / 9.81, rel=1e-14)


def test_a_mesh_that_moves_already_is_refused(tmp_path):
    deck = _turning_drum(tmp_path, "", 10).replace(
        "fix mill all",
        "fix move all move/mesh mesh liner rotate origin 0 0 0 axis 0 1 0 period 3\nfix mill all",
    )
    assert "is moved already" in run(tmp_path, deck).error


def test_clear_loses_the_styles(tmp_path):
    deck = FREE + "clear\n" + FREE + f"fix mill all mill/similarity {PAPER}\n"
    assert 'Invalid fix style: "mill/similarity"' in run(tmp_path, deck).error


def test_help_lists_the_styles_before_those_of_the_engine(tmp_path):
    import subprocess

    from millscale.engine.deck_run import find_engine

    done = subprocess.run([find_engine(), "-h"], cwd=tmp_path, capture_output=True, text=True)
    ours, stock = done.stdout.index("fix mill/similarity"), done.stdout.index("Command line")
    assert ours < stock
    for style in ("compute mill/detach", "fix mill/forces"):
        assert style in done.stdout[:stock]


@pytest.mark.parametrize(
    "steps", [2000, pytest.param(1_000_000, marks=pytest.mark.validate, id="1e6")]
)
def test_the_mesh_stays_on_the_axis(tmp_path, contact_row, steps):
    deck = _turning_drum(tmp_path, "", steps).replace("omega 2e-5", "omega 2.0")
    deck = deck.replace("gravity 1e-9", "gravity 9.81")
    deck = deck.replace("create_atoms 1 single 0 0.1 0", "create_atoms 1 single 0 0.1 -0.479")
    result = run(tmp_path, deck + 'print "mesh $(f_mill[1]) $(f_mill[14])"\n')
    angle, wobble = result.printed("mesh")
    assert angle == pytest.approx(2.0 * steps * 1e-4, rel=1e-14)
    contact_row(
        "fault: a rotating mesh wobbles",
        "-",
        "mesh",
        f"centre of the mesh from the axis / radius after {steps} steps",
        dt=1e-4,
        expected=0.0,
        got=wobble,
        tolerance=1e-12,
        reason="rounding: the nodes are turned from stored places by the step's angle",
    )


def test_a_mesh_off_the_axis_wobbles(tmp_path):
    deck = _turning_drum(tmp_path, "origin 0.01 0 0", 10)
    result = run(tmp_path, deck + 'print "mesh $(f_mill[1]) $(f_mill[14])"\n')
    assert result.printed("mesh")[1] == pytest.approx(0.01 / 0.5, rel=1e-3)


def test_read_dump_sorts_by_id(tmp_path):
    (tmp_path / "d").write_text("ITEM: ATOMS id x\n2 5.0\n1 4.0\n")
    np.testing.assert_array_equal(read_dump(tmp_path / "d")["x"], [4.0, 5.0])
