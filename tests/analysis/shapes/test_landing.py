"""Where thrown balls land."""

import math

import numpy as np
import pytest

from millscale.analysis.shapes.landing import landing_angles

G, R = 9.81, 1.3


def test_a_ball_thrown_level_from_the_axis_lands_where_its_parabola_meets_the_circle():
    v = 2.0
    # (v t)^2 + (g t^2 / 2)^2 = R^2, solved for t^2.
    square = (-(v**2) + math.sqrt(v**4 + G**2 * R**2)) / (G**2 / 2.0)
    t = math.sqrt(square)
    expected = math.atan2(-v * t, -G * t**2 / 2.0) % (2.0 * math.pi)
    # One ball to the falling side, beyond the bottom, and its mirror image.
    found = landing_angles(np.array([[0.0, 0.0, v, 0.0], [0.0, 0.0, -v, 0.0]]), G, R)
    assert found[0] == pytest.approx(expected, abs=1e-4)
    assert math.pi < found[0] < 1.5 * math.pi
    assert found[1] == pytest.approx(2.0 * math.pi - expected, abs=1e-4)


def test_the_ball_of_a_smooth_drum_lands_at_three_times_its_release():
    """Thrown at phi from the top with the speed of the drum, cos(phi) = V^2 / (g R), it meets the
    circle again at 3 phi past the top on the other side (docs/theory)."""
    phi = math.radians(50.0)
    V = math.sqrt(G * R * math.cos(phi))
    # The rising side is x < 0; the mill turns clockwise, so that the ball moves up and to +x.
    start = [-R * math.sin(phi), R * math.cos(phi), V * math.cos(phi), V * math.sin(phi)]
    moved = landing_angles(np.array([start]), G, R * (1.0 - 1e-9))[0]
    # Polar angle 3 phi from the rising side's release is 2 pi - 3 phi counted down the rising side.
    assert moved == pytest.approx(2.0 * math.pi - 3.0 * phi, abs=1e-3)


def test_a_ball_that_flies_past_the_circle_does_not_land_on_it():
    assert np.isnan(landing_angles(np.array([[2.0 * R, 0.0, 1.0, 0.0]]), G, R)).all()
