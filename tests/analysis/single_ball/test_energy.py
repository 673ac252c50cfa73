"""Energy change in free flight: exact parabola, samples, fixed angles."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from millscale.analysis.single_ball import energy
from millscale.analysis.single_ball.events import flights, throws
from millscale.analysis.single_ball.result import ball_of
from synthetic_ball import usual_motion
from synthetic_case import typed

WINDOW = 0.977


@pytest.fixture
def series(case):
    return usual_motion(case).series()


def test_exact_change_is_that_of_the_known_parabola(case, series):
    throw = throws(series)[0].flight
    ball = ball_of(typed(case))
    motion = usual_motion(case)
    release = [s.release for s in motion.segments if s.release][3]
    v0, v1 = release.velocity_at([0.0, WINDOW / motion.omega])
    naive = 0.5 * motion.mass * (v1 @ v1 - v0 @ v0)
    span = throw.mill_angle + np.array([0.0, WINDOW])
    assert_allclose(energy.change_on_parabola(throw, ball, *span), naive, rtol=1e-8)


def test_changes_over_two_spans_of_a_flight_add_up(case, series):
    throw, ball = throws(series)[0].flight, ball_of(typed(case))
    a, b, c = throw.mill_angle + np.array([0.1, 0.5, 1.2])
    parts = (
        energy.change_on_parabola(throw, ball, a, b),
        energy.change_on_parabola(throw, ball, b, c),
    )
    assert_allclose(sum(parts), energy.change_on_parabola(throw, ball, a, c), rtol=1e-12)


def test_samples_agree_with_the_parabola_to_interpolation(case, series):
    throw = throws(series)[0].flight
    ball = ball_of(typed(case))
    begin = throw.mill_angle
    exact = energy.change_on_parabola(throw, ball, begin, begin + WINDOW)
    sampled = energy.change_from_release(series, throw, ball, WINDOW)
    # Linear interpolation of a parabola over a sample h: at most m g^2 h^2 / 8.
    h = case["time"]["sample_angle_rad"] / ball.omega
    tolerance = ball.mass * ball.gravity**2 * h**2 / 8.0
    assert_allclose(sampled.kinetic, exact, atol=1.01 * tolerance)
    assert_allclose(sampled.potential, -exact, atol=1.01 * tolerance)
    assert sampled.in_flight


def test_samples_of_the_flight_lie_on_the_parabola(case, series):
    throw, ball = throws(series)[0].flight, ball_of(typed(case))
    assert_allclose(energy.deviation_from_parabola(series, throw, ball), 0.0, atol=1e-9)
    series["kinetic_translation_J"][throw.rows[5]] += 0.25
    series["potential_J"][throw.rows[7]] -= 0.125
    assert_allclose(energy.deviation_from_parabola(series, throw, ball), (0.25, 0.125), atol=1e-9)


def test_change_between_fixed_angles_in_flight_balances(series):
    throw = throws(series)[0].flight
    begin, end = throw.mill_angle + 0.1, throw.mill_angle + 0.9
    change = energy.sampled_change(series, begin, end, flights(series))
    assert change.in_flight
    assert_allclose(change.kinetic, -change.potential, rtol=1e-4)


@pytest.mark.parametrize("shift", [-0.2, 1.0])
def test_fixed_angles_outside_the_flight_are_flagged(series, shift):
    throw = throws(series)[0].flight
    begin = throw.mill_angle + shift
    change = energy.sampled_change(series, begin, begin + 0.8, flights(series))
    assert not change.in_flight


def test_angles_beyond_the_series_are_refused(series):
    with pytest.raises(ValueError, match=r"mill angles 2 to 99 rad are not in the series, 0 to"):
        energy.sampled_change(series, 2.0, 99.0, [])


def test_gain_over_a_window_beyond_the_top_is_a_loss_of_height(case, series):
    """Up to twice the time to the top, kinetic energy first falls, then comes back."""
    throw, ball = throws(series)[0].flight, ball_of(typed(case))
    begin = throw.mill_angle
    top = begin + throw.velocity[2] / ball.gravity * ball.omega
    back = energy.change_on_parabola(throw, ball, begin, 2.0 * top - begin)
    assert_allclose(back, 0.0, atol=1e-12)
    assert_allclose(
        energy.change_on_parabola(throw, ball, begin, top),
        -0.5 * ball.mass * throw.velocity[2] ** 2,
        rtol=1e-12,
    )
