"""Which confirmed flight is the throw, and where the regions begin."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

from millscale.analysis.single_ball.events import (
    flights,
    lift_rows,
    liner_offs,
    mill_relative_speed,
    regions,
    throws,
    unseen_events,
)
from synthetic_ball import DETACH, LINER_OFF, START, Motion, usual_motion


@pytest.fixture
def motion(case) -> Motion:
    return usual_motion(case)


def test_every_flight_is_seen_with_its_length(motion):
    launched = [s for s in motion.segments if s.release]
    seen = flights(motion.series())
    sample = motion.sample * motion.step * motion.omega
    assert len(seen) == len(launched) == 2 + 2 * 4
    for flight, segment in zip(seen, launched, strict=True):
        assert_allclose(flight.mill_angle, motion.omega * (segment.begin - START), atol=1e-9)
        length = motion.omega * (segment.end - segment.begin)
        assert length - sample <= flight.length <= length
        assert_allclose(flight.velocity, segment.release.velocity)
        assert flight.finished


def test_throw_is_the_long_flight_from_the_upper_half(motion):
    found = throws(motion.series())
    assert_allclose(
        [throw.flight.angle for throw in found], [DETACH, DETACH - math.radians(0.4)], atol=1e-9
    )
    assert_allclose([throw.liner_off.angle for throw in found], LINER_OFF, atol=1e-9)


def test_throw_is_found_without_any_other_flight(case):
    motion = Motion(case)
    motion.carry(DETACH)
    motion.throw()
    motion.hop(-0.8, 0.5)
    (throw,) = throws(motion.series())
    assert throw.liner_off is None
    assert_allclose(throw.flight.angle, DETACH)


def test_throw_cut_by_the_end_of_the_series_still_counts(motion):
    series = motion.series()
    first = throws(series)[0].flight
    middle = first.rows[len(first.rows) // 2]
    cut = {name: values[:middle] for name, values in series.items()}
    (throw,) = throws(cut)
    assert_allclose(throw.flight.angle, DETACH)
    assert not throw.flight.finished
    assert throw.flight.length < 0.6 * first.length


def test_bounces_below_the_axis_alone_are_no_throw(case):
    motion = Motion(case)
    motion.hop(0.6, 0.5)
    motion.hop(0.2, 0.3)
    motion.carry(math.radians(100.0))
    assert len(flights(motion.series())) == 2
    assert throws(motion.series()) == []


def test_lift_is_counted_once_for_each_cycle_on_the_rising_side(case):
    series = usual_motion(case, cycles=3).series()
    rows = lift_rows(series)
    assert len(rows) == 3
    assert all(series["x_m"][row] < 0.0 <= series["z_m"][row] for row in rows)
    assert all(series["z_m"][row - 1] < 0.0 for row in rows)


def test_rebound_above_the_axis_on_the_falling_side_is_no_lift(case):
    motion = Motion(case)
    motion.carry(DETACH)
    motion.throw()
    motion.hop(-0.4 * math.pi, 0.3)
    motion.hop(-0.6 * math.pi, 0.3)
    motion.hop(-0.4, 0.3)
    motion.carry(math.radians(100.0))
    series = motion.series()
    assert (series["z_m"][1:] > 0.0)[(series["z_m"][:-1] < 0.0)].sum() == 2
    assert len(lift_rows(series)) == 1


def test_events_between_two_samples_are_counted_as_unseen(motion):
    series = motion.series()
    assert unseen_events(series) == 0
    assert len(liner_offs(series)) == 2
    rows = [flight.rows[0] for flight in flights(series)]
    series["flight_count"][rows[1] :] += 1
    series["liner_off_count"][rows[2] :] += 2
    assert unseen_events(series) == 2  # one of two new flights, one of two new losses


def test_flight_between_two_samples_has_no_length(motion):
    series = motion.series()
    row = flights(series)[0].rows[0]
    series["time_in_flight_s"][series["flight_count"] == 1] = 0.0
    first = flights(series)[0]
    assert first.length == 0.0
    assert first.rows.size == 0
    assert series["flight_count"][row] == 1


def test_touch_between_samples_ends_a_flight(motion):
    """A rebound shorter than a sample shows only in the time of flight, which starts again."""
    series = motion.series()
    throw = throws(series)[0].flight
    touch = throw.rows[len(throw.rows) // 3]
    touched = slice(touch, throw.rows[-1] + 1)
    series["time_in_flight_s"][touched] -= series["time_in_flight_s"][touch - 1]
    shorter = next(f for f in flights(series) if f.mill_angle == throw.mill_angle)
    assert shorter.rows[-1] == touch - 1


def test_regions_are_bounded_by_settling_throw_and_impact(motion):
    series = motion.series()
    first = throws(series)[0]
    found = regions(series, first, motion.omega, 3.9)
    hops = [s for s in motion.segments if s.release]
    sample = 1.01 * motion.sample * motion.step * motion.omega
    expected = [hops[1].end, hops[3].begin, hops[3].end, hops[5].end]
    actual = [found.settled, found.thrown, found.impact, found.settled_again]
    assert_allclose(actual, motion.omega * (np.array(expected) - START), atol=sample)


def test_ball_carried_by_the_mill_has_no_relative_speed(motion):
    series = motion.series()
    carried = (series["state"] == 1) & (series["time_s"] > START)
    speed = mill_relative_speed(series, motion.omega)
    assert_allclose(speed[carried], 0.0, atol=1e-12)
    assert speed[series["state"] == 3].min() > 0.0
