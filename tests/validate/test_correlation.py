"""Correlation over seeds, control variates and extrapolation, by closed forms and by drawing."""

import math

import numpy as np
import pytest

from millscale.validate.correlation import (
    correlation,
    cost_at_equal_variance,
    fisher_interval,
    least_correlation,
    pooled_correlation,
    richardson,
)


def test_equal_runs_correlate_by_one_and_a_mean_of_each_window_does_not_count():
    runs = np.random.default_rng(1).normal(size=(6, 4))
    found = correlation(runs, 3.0 * runs + [10.0, 20.0, -5.0, 0.0])
    assert found.value == pytest.approx(1.0)
    assert found.chance == pytest.approx(1.0 / 720.0)
    assert pooled_correlation(runs, -runs) == pytest.approx(-1.0)


def test_of_one_window_it_is_pearsons_r():
    first, second = np.random.default_rng(2).normal(size=(2, 7, 1))
    expected = np.corrcoef(first[:, 0], second[:, 0])[0, 1]
    assert correlation(first, second).value == pytest.approx(expected)


def test_runs_that_share_nothing_have_a_chance_spread_evenly():
    generator = np.random.default_rng(3)
    chances = [correlation(*generator.normal(size=(2, 4, 3))).chance for _ in range(400)]
    assert np.mean(chances) == pytest.approx(0.5 + 0.5 / 24.0, abs=0.04)


def test_one_window_is_worth_its_seeds_and_equal_windows_no_more():
    first, second = np.random.default_rng(7).normal(size=(2, 6, 1))
    assert correlation(first, second).samples == pytest.approx(6.0)
    repeated = correlation(np.tile(first, 5), np.tile(second, 5))
    assert repeated.samples == pytest.approx(6.0)


def test_independent_windows_are_worth_their_degrees_of_freedom():
    generator = np.random.default_rng(8)
    found = [correlation(*generator.normal(size=(2, 6, 8))).samples for _ in range(30)]
    assert np.mean(found) == pytest.approx(1.0 + 8 * 5, rel=0.15)


@pytest.mark.parametrize("truth", [0.0, 0.7])
def test_the_interval_of_windows_covers_the_truth_in_95_of_100_draws(truth):
    generator = np.random.default_rng(9)
    inside = 0
    for _ in range(200):
        a, b = generator.normal(size=(2, 5, 6))
        found = correlation(a, truth * a + math.sqrt(1.0 - truth**2) * b)
        inside += found.low <= truth <= found.high
    assert inside / 200 == pytest.approx(0.95, abs=0.04)


def test_many_seeds_are_paired_at_random():
    runs = np.random.default_rng(10).normal(size=(12, 1))
    found = correlation(runs, runs)
    assert found.chance < 1e-3
    assert found.samples == pytest.approx(12.0, rel=0.1)


def test_a_setting_that_does_not_vary_has_no_correlation():
    runs = np.random.default_rng(4).normal(size=(5, 2))
    found = correlation(runs, np.ones((5, 2)))
    assert (found.value, found.chance) == (None, None)


def test_fishers_interval_covers_the_truth_in_95_of_100_draws():
    generator, truth, seeds = np.random.default_rng(5), 0.6, 6
    inside = 0
    for _ in range(2000):
        a, b = generator.normal(size=(2, seeds))
        r = float(np.corrcoef(a, truth * a + math.sqrt(1.0 - truth**2) * b)[0, 1])
        low, high = fisher_interval(r, seeds)
        inside += low <= truth <= high
    assert inside / 2000 == pytest.approx(0.95, abs=0.02)
    assert fisher_interval(0.5, 3) == (None, None)


def test_the_cost_of_two_fidelities_is_the_least_over_their_numbers_of_runs():
    r, ratio = 0.9, 0.1
    ways = [
        ((1.0 - r**2) / dear + r**2 / cheap) * (dear + ratio * cheap)
        for dear in (1.0,)
        for cheap in np.linspace(1.0, 40.0, 4000)
    ]
    assert cost_at_equal_variance(r, ratio) == pytest.approx(min(ways), rel=1e-6)


@pytest.mark.parametrize("ratio", [0.1, 0.5, 0.9])
def test_at_the_least_correlation_nothing_is_gained_and_above_it_something(ratio):
    r = least_correlation(ratio)
    assert cost_at_equal_variance(r, ratio) == pytest.approx(1.0)
    assert cost_at_equal_variance(r + 0.001, ratio) < 1.0 < cost_at_equal_variance(r - 0.01, ratio)


@pytest.mark.parametrize("order", [1.0, 2.0])
def test_richardson_removes_an_error_of_its_order_and_widens_the_noise(order):
    def at(step):
        return 5.0 + 3.0 * step**order

    found = richardson((at(0.1), 0.0), (at(0.2), 0.0), 2.0, order)
    assert found.value == pytest.approx(5.0)
    generator = np.random.default_rng(6)
    draws = generator.normal(size=(2, 20000)) * [[0.02], [0.03]]
    values = [richardson((a, 0.0), (b, 0.0), 2.0, order).value for a, b in draws.T]
    assert richardson((0.0, 0.02), (0.0, 0.03), 2.0, order).error == pytest.approx(
        np.std(values), rel=0.02
    )
