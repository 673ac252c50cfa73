"""Curtains whose balls, lifters and profiles are known."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from millscale.analysis.shapes.comparison import overlap
from millscale.analysis.shapes.curtain import (
    FEWEST_BALLS,
    Lifters,
    band_profile,
    curtains,
    densest_region,
    longest_flight,
    may_have_thrown,
)
from millscale.analysis.shapes.solid_fraction import Grid

MILL = Lifters(count=25, phase=0.1, first=1.1)


def test_lifter_is_where_it_was_turned_to():
    # Lifter 3 trails groove 3 by half a pitch; the bottom (180 deg) rises towards smaller angles.
    angle = MILL.angle_from_vertical(3, 0.7)
    assert_allclose(angle, np.pi - (2.5 * 2.0 * np.pi / 25 + 0.1 + 0.7))
    assert MILL.angle_from_vertical(3, 0.8) < angle


def test_curtains_are_counted_from_the_detaching_angle_in_the_sense_of_rotation():
    angle = 4.321
    heights = {k: MILL.angle_from_vertical(k, angle) for k in range(25)}
    past = sorted((k for k in heights if 0 <= heights[k] <= 1.1), key=lambda k: -heights[k])
    assert [MILL.number(k, angle) for k in past] == list(range(1, len(past) + 1))
    assert sorted(MILL.number(k, angle) for k in range(25)) == list(range(1, 26))
    # A pitch later each lifter's curtain has moved on by one.
    assert MILL.number(past[0], angle + MILL.pitch) == 2


def test_longest_flight_is_that_of_a_vertical_throw():
    froude, g, R = 0.398, 9.81, 3.9
    omega = np.sqrt(froude * g / R)
    t = longest_flight(froude) / omega
    assert_allclose(R + omega * R * t - 0.5 * g * t**2, -R, rtol=1e-12)


def test_only_lifters_that_were_high_within_a_flight_may_have_thrown():
    angle, longest = 6.0, 1.7
    lifters = np.arange(25.0)
    found = may_have_thrown(lifters, MILL, angle, longest)
    # Naive: follow each lifter back in small steps of rotation.
    for k in range(25):
        past = MILL.angle_from_vertical(k, angle - np.linspace(0.0, longest, 2000))
        assert found[k] == bool(np.any((past >= 0.0) & (past <= 0.5 * np.pi))), k


def test_balls_are_sorted_by_the_lifter_that_carried_them():
    angle, generator = 6.0, np.random.default_rng(2)
    lifter = np.array([3] * 40 + [17] * 30 + [5] * (FEWEST_BALLS - 1))
    centres = generator.uniform(-0.5, 0.5, (lifter.size, 2))
    found = curtains(centres, lifter, MILL, angle)
    # Naive: one by one.
    assert {c.lifter: len(c.centres) for c in found} == {3: 40, 17: 30}
    assert [c.number for c in found] == sorted(MILL.number(k, angle) for k in (3, 17))
    for c in found:
        assert_allclose(c.centres, centres[lifter == c.lifter])


def parabola_curtain(count: int, spread: float, seed: int = 0) -> np.ndarray:
    """Balls evenly in time along a fall of 0.9, and evenly within `spread` of it in x."""
    generator = np.random.default_rng(seed)
    t = generator.uniform(0.1, 1.0, count)
    x = -0.2 + 0.5 * t + generator.uniform(-spread, spread, count)
    return np.column_stack([x, 0.5 - 0.9 * t**2])


def parabola_region(grid: Grid, spread: float) -> np.ndarray:
    x, z = np.meshgrid(grid.nodes, grid.nodes)
    t = np.sqrt(np.maximum(0.0, (0.5 - z) / 0.9))
    inside = (np.abs(x + 0.2 - 0.5 * t) < spread) & (t > 0.1) & (t < 1.0)
    return inside


@pytest.mark.parametrize("count", [100, 1000, 10000])
def test_densest_region_of_a_parabola_is_the_band_it_was_drawn_from(count):
    grid = Grid(0.03)
    truth = parabola_region(grid, 0.12)
    found = densest_region(parabola_curtain(count, 0.12), grid)
    # The lower end is thin (balls are fast there): a share of it lies beyond the 90 %.
    least = {100: 0.6, 1000: 0.75, 10000: 0.75}[count]
    assert overlap(found, truth) > least
    again = densest_region(parabola_curtain(count, 0.12, seed=1), grid)
    assert overlap(found, again) > {100: 0.55, 1000: 0.8, 10000: 0.92}[count]


def test_densest_region_is_the_smallest_that_holds_its_share():
    grid = Grid(0.05)
    centres = np.random.default_rng(1).normal(0.0, 0.15, (3000, 2))
    region = densest_region(centres, grid)
    # Of a Gaussian of variance s^2 it is a disc: radius^2 = -2 s^2 ln(1 - 0.9).
    variance = 0.15**2 + 0.05**2
    expected = np.pi * -2.0 * variance * np.log(0.1)
    # Noise of the level, n^-1/2 of the balls outside: sqrt(300) / 300 of a tenth, 3 % in area.
    assert_allclose(region.sum() * grid.step**2, expected, rtol=0.06)


def test_two_methods_agree_on_a_full_curtain():
    grid = Grid(0.03)
    balls = parabola_curtain(3000, 0.12)
    outline, _ = band_profile(balls)
    assert overlap(densest_region(balls, grid), grid.inside(outline)) > 0.75


@pytest.mark.parametrize("spread", [0.05, 0.15])
def test_width_is_that_of_the_balls_about_their_path(spread):
    balls = np.column_stack([np.zeros(4000), np.random.default_rng(0).uniform(-0.5, 0.5, 4000)])
    balls[:, 0] = np.random.default_rng(1).uniform(-spread, spread, 4000)
    _, width = band_profile(balls)
    # Standard deviation of a uniform spread; its own error is 1 / sqrt(2 n) = 1 %.
    assert_allclose(width, spread / np.sqrt(3.0), rtol=0.04)


def test_lifters_with_given_angles_are_numbered_as_equal_ones():
    equal = MILL
    angles = tuple((np.arange(25) - 0.5) * equal.pitch + equal.phase)
    given = Lifters(25, equal.phase, equal.first, angles)
    for mill_angle in (0.0, 1.3, 40.0):
        for lifter in range(25):
            assert given.number(lifter, mill_angle) == equal.number(lifter, mill_angle)
            np.testing.assert_allclose(
                given.angle_from_vertical(lifter, mill_angle),
                equal.angle_from_vertical(lifter, mill_angle),
                atol=1e-12,
            )


def test_unequal_lifters_are_numbered_in_their_order():
    mill = Lifters(3, 0.0, 1.0, (0.0, 0.3, 3.0))
    numbers = [mill.number(lifter, 0.5) for lifter in range(3)]
    angles = [mill.angle_from_vertical(lifter, 0.5) for lifter in range(3)]
    past = np.mod(1.0 - np.array(angles), 2.0 * np.pi)
    assert numbers == (np.argsort(np.argsort(past)) + 1).tolist()
