"""The binding passes arguments, results and errors on; the arithmetic is tested in C++."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from millscale import _core

PAPER_BALL = _core.Material(youngs_modulus=5.98e7, poisson_ratio=0.3, density=2678.0)
PHYSICAL = _core.OperatingPoint(radius=3.9, ball_radius=0.02, gravity=9.81, omega=1.0)


@pytest.fixture(scope="module")
def liner():
    return _core.Lifters(3.9, 3.61, 0.25, 0.635, 25, phase=0.1)


def test_scale_takes_names_and_keywords():
    scaled = _core.scale(PHYSICAL, 2.6, scheme="constant-speed", policy="offset-liner")
    assert_allclose(scaled.mill.radius, 3.88 / 2.6 + 0.02)
    assert_allclose(scaled.mill.gravity, 9.81 / 2.6)
    assert_allclose(scaled.predicted_energy_ratio, 2.6**-2)
    assert (scaled.base.mass, scaled.base.time) == (1.0, 1.0)


def test_scale_defaults_to_the_papers_law_at_constant_gravity():
    assert_allclose(_core.scale(PHYSICAL, 2.6).mill.omega, math.sqrt(2.6))
    matched = _core.scale(PHYSICAL, 4.0, policy="friction-matched", friction_exponent=0.5)
    assert_allclose(matched.friction_ratio, 0.5)


def test_free_time_factor_and_permission_to_centrifuge_arrive():
    scaled = _core.scale(PHYSICAL, 2.0, "froude", time_factor=0.8)
    assert_allclose(scaled.mill.omega, 1.25)
    acceleration = _core.factor(scaled.base, length=1, mass=0, time=-2)
    assert_allclose(acceleration, scaled.mill.gravity / 9.81)
    fast = _core.OperatingPoint(3.9, 0.02, 9.81, 2.0)
    assert _core.scale(fast, 2.0, allow_centrifuging=True).froude > 1.0


def test_functions_of_an_operating_point():
    froude = _core.froude_number(radius=3.9, gravity=9.81, omega=1.0)
    assert_allclose(math.degrees(_core.detach_angle(froude)), 66.57, atol=0.01)
    assert _core.regime(froude) == "cataracting"
    assert_allclose(_core.critical_speed(PHYSICAL), math.sqrt(9.81 / 3.88))


def test_liner_shows_its_dimensions(liner):
    assert (liner.radius, liner.lifter_top_radius, liner.lifter_top_width) == (3.9, 3.61, 0.25)
    assert (liner.groove_width, liner.lifters, liner.phase) == (0.635, 25, 0.1)
    assert_allclose(liner.pitch, 2.0 * math.pi / 25)
    assert_allclose(math.degrees(liner.face_angle), 9.361, atol=1e-3)
    parallel = _core.Lifters.from_face_angle(3.9, 3.61, 0.25, 0.0, 25)
    assert parallel.face_angle == 0.0
    assert parallel.groove_width > liner.groove_width


def test_liner_makes_liners(liner):
    assert_allclose(liner.scaled(2.6).radius, 1.5)
    model = liner.offset_scaled(S=2.6, ball_radius=0.02)
    assert_allclose(model.offset(0.02).radius, 3.88 / 2.6)


def test_polygon_encloses_the_area(liner):
    nodes, faces = liner.polygon(chord_error=1e-8)
    assert nodes.dtype == float and nodes.shape == (len(faces), 2)
    assert np.issubdtype(faces.dtype, np.integer) and set(faces) == {0, 1, 2, 3}
    x, z = nodes.T
    enclosed = 0.5 * abs(np.dot(x, np.roll(z, -1)) - np.dot(np.roll(x, -1), z))
    assert_allclose(enclosed, liner.area, rtol=1e-8)


def test_many_points_give_what_single_points_give(liner):
    points = np.random.default_rng(5).uniform(-4.0, 4.0, (200, 2))
    many, within = liner.nearest(points), liner.inside(points)
    for i, (x, z) in enumerate(points):
        one = liner.nearest(x, z)
        assert (one.distance, one.face, one.sector) == (
            many.distance[i],
            many.face[i],
            many.sector[i],
        )
        assert_array_equal(one.point, many.point[i])
        assert_array_equal(one.normal, many.normal[i])
        assert liner.inside(x, z) == within[i] == (one.distance > 0.0)


def test_arrays_outlive_the_objects_they_come_from(liner):
    distance = liner.nearest(np.zeros((3, 2))).distance
    assert_allclose(distance, 3.61)


def test_points_of_any_layout_and_number_are_taken(liner):
    points = np.asfortranarray(np.random.default_rng(5).uniform(-4.0, 4.0, (20, 2)))
    assert_array_equal(liner.inside(points), liner.inside(np.ascontiguousarray(points)))
    assert liner.inside(np.zeros((0, 2))).shape == (0,)
    with pytest.raises(TypeError):
        liner.inside(np.zeros((4, 3)))


def test_groove_box_has_four_corners_around_the_groove(liner):
    box = liner.groove_box()
    middle = box.mean(axis=0)
    assert box.shape == (4, 2)
    assert_allclose(math.atan2(-middle[0], -middle[1]), 0.1)


def test_contact_limits():
    assert_allclose(_core.rayleigh_time(PAPER_BALL, 0.02), 7.33e-4, atol=0.005e-4)
    assert_allclose(_core.damping_ratio(0.1), 0.54, atol=0.005)
    overlap = _core.hertz_overlap(PAPER_BALL, 0.02, 10.0)
    time = _core.hertz_collision_time(PAPER_BALL, 0.02, 10.0)
    assert_allclose(time, 2.94 * overlap / 10.0, rtol=2e-3)
    single = _core.damping_time_step_limit(PAPER_BALL, 0.02, 0.1, 0.16e-3)
    bed = _core.damping_time_step_limit(PAPER_BALL, 0.02, 0.1, 0.16e-3, coordination=4)
    assert bed < single < _core.rayleigh_time(PAPER_BALL, 0.02)


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda: _core.scale(PHYSICAL, 0.5), "S: must be >= 1"),
        (lambda: _core.scale(PHYSICAL, 2.0, "constant"), "accepted are constant-gravity"),
        (lambda: _core.detach_angle(1.2), "centrifuging"),
        (lambda: _core.Lifters(3.9, 4.0, 0.25, 0.635, 25), "lifter top radius"),
        (lambda: _core.Lifters(3.9, 0.0, 0.0, 0.0, 0).groove_box(), "plain drum"),
        (lambda: _core.Lifters(3.9, 0.0, 0.0, 0.0, 0).polygon(0.0), "chord error"),
        (lambda: _core.rayleigh_time(PAPER_BALL, -0.02), "ball radius"),
        (lambda: _core.damping_ratio(0.0), "restitution"),
    ],
)
def test_errors_are_value_errors_that_name_the_value(call, text):
    with pytest.raises(ValueError, match=text):
        call()


def described(name, thing):
    """Return whether a docstring says more than the signature, which nanobind puts first."""
    text = (thing.__doc__ or "").splitlines()
    return any(line and not line.startswith(f"{name}(") for line in text)


def test_everything_has_a_docstring():
    for name, thing in vars(_core).items():
        if name.startswith("_"):
            continue
        assert described(name, thing), name
        if isinstance(thing, type):
            for member, attribute in vars(thing).items():
                if not member.startswith("_"):
                    assert described(member, attribute), f"{name}.{member}"


def test_reprs_show_the_numbers():
    assert repr(PHYSICAL) == ("OperatingPoint(radius=3.9, ball_radius=0.02, gravity=9.81, omega=1)")
    assert "groove_width=0.635" in repr(_core.Lifters(3.9, 3.61, 0.25, 0.635, 25))
