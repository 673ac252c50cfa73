"""Flight of a released ball against its closed forms."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from millscale.analysis.single_ball.flight import (
    Release,
    flight_time,
    impact_angle,
    impact_speed_ratio,
    release_on_circle,
)

ANGLES = np.radians([20.0, 50.0, 60.0, 66.7, 80.0])


@pytest.mark.parametrize("phi", ANGLES)
@pytest.mark.parametrize(("radius", "gravity"), [(3.88, 9.81), (1.48, 9.81), (1.48, 3.773)])
def test_ball_meets_its_circle_again_at_three_phi(phi, radius, gravity):
    release = release_on_circle(radius, phi, gravity)
    # By bisection on the parabola itself: inside the circle half-way, outside at 1.5 flight times.
    expected = flight_time(np.linalg.norm(release.velocity), phi, gravity)
    low, high = 0.5 * expected, 1.5 * expected
    for _ in range(60):
        middle = 0.5 * (low + high)
        inside = np.linalg.norm(release.position_at(middle)) < radius
        low, high = (middle, high) if inside else (low, middle)
    assert_allclose(low, expected, rtol=1e-9)
    x, _, z = release.position_at(low)
    across = impact_angle(phi)
    assert_allclose([x, z], [radius * np.sin(across), radius * np.cos(across)], atol=1e-8 * radius)


@pytest.mark.parametrize("phi", ANGLES)
def test_speed_at_impact_follows_from_the_fall(phi):
    release = release_on_circle(3.88, phi, 9.81)
    speed = np.linalg.norm(release.velocity)
    drop = 3.88 * (np.cos(phi) - np.cos(3.0 * phi))
    assert_allclose(
        impact_speed_ratio(phi), np.sqrt(1.0 + 2.0 * 9.81 * drop / speed**2), rtol=1e-12
    )


@pytest.mark.parametrize("phi", ANGLES)
def test_time_to_radius_finds_the_impact_not_the_lift_off(phi):
    release = release_on_circle(2.0, phi, 9.81)
    expected = flight_time(np.linalg.norm(release.velocity), phi, 9.81)
    # The path touches the circle to third order at lift-off: that root is found to eps^(1/3).
    assert_allclose(release.time_to_radius(2.0), expected, rtol=1e-6)


def test_time_to_radius_of_a_ball_falling_down_the_axis():
    release = Release(np.zeros(3), np.zeros(3), 9.81)
    assert_allclose(release.time_to_radius(2.0), np.sqrt(2.0 * 2.0 / 9.81), rtol=1e-9)


def test_ball_without_gravity_at_rest_never_arrives():
    assert Release(np.zeros(3), np.zeros(3), 0.0).time_to_radius(2.0) == np.inf


def test_kinetic_change_is_the_change_of_half_m_v_squared():
    release = Release(np.array([-1.0, 0.5, 2.0]), np.array([3.0, 0.1, 2.0]), 9.81)
    time, mass = np.linspace(0.0, 2.0, 7), 0.0897
    speed2 = (release.velocity_at(time) ** 2).sum(axis=1)
    naive = 0.5 * mass * (speed2 - speed2[0])
    assert_allclose(release.kinetic_change(time, mass), naive, atol=1e-14)
    height = release.position_at(time)[:, 2]
    assert_allclose(mass * 9.81 * (height[0] - height), naive, atol=1e-14)
