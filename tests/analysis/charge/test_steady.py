"""The window of a charge's means: whole pitches, a start cut off by its scatter, trends."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

from millscale.analysis.charge.steady import (
    FEWEST_PITCHES,
    choose_window,
    lifter_pitch,
    standard_error,
    trend,
)

PITCH = lifter_pitch(25)


def test_a_window_holds_whole_pitches_at_the_same_phases_in_every_mill():
    for end, samples in ((8.0, 801), (7.9, 333), (6.31, 1000)):
        angle = np.linspace(0.003, end, samples)
        window = choose_window(angle, [np.ones_like(angle)], PITCH)
        assert_allclose(window.edges / PITCH, np.round(window.edges / PITCH), atol=1e-12)
        assert window.edges[0] >= angle[0]
        assert end - PITCH < window.end <= end
        assert_allclose(np.diff(window.edges), PITCH)


def test_the_mean_over_pitches_is_free_of_what_the_lifters_do():
    """A wave of the pitch's period moves the mean of a part of a pitch, not that of whole ones."""
    angle = np.linspace(0.0, 8.0, 2001)
    wave = np.sin(2.0 * math.pi * angle / PITCH + 0.4)
    window = choose_window(angle, [wave], PITCH)
    # Trapezoids of 63 samples a pitch.
    assert abs(window.mean(angle, 1.0 + wave) - 1.0) < 1e-5
    half = angle >= 4.0
    assert abs(np.trapezoid(wave[half], angle[half]) / 4.0) > 1e-3


def test_means_are_exact_for_lines_between_uneven_samples():
    angle = np.sort(np.random.default_rng(1).uniform(0.0, 8.0, 300))
    angle[[0, -1]] = 0.0, 8.0
    window = choose_window(angle, [np.ones_like(angle)], PITCH)
    assert_allclose(window.mean(angle, 3.0 * angle - 1.0), 1.5 * (window.begin + window.end) - 1.0)
    assert_allclose(window.pitch_means(angle, angle), 0.5 * (window.edges[1:] + window.edges[:-1]))
    assert_allclose(window.change(angle, 2.0 * angle), 2.0 * (window.end - window.begin))


@pytest.mark.parametrize("spin_up", [0.6, 1.2, 2.0])
def test_a_start_that_decays_is_cut_off_where_noise_hides_it(spin_up):
    random, angle = np.random.default_rng(5), np.linspace(0.0, 12.0, 3000)
    noise = np.repeat(random.normal(0.0, 0.01, 300), 10)
    values = 1.0 - np.exp(-angle / (0.3 * spin_up)) + noise
    window = choose_window(angle, [values], PITCH)
    assert 0.5 * spin_up < window.begin < 3.0 * spin_up
    assert abs(window.mean(angle, values) - 1.0) < 0.004


def test_the_latest_start_of_several_quantities_counts_and_two_thirds_are_the_most():
    angle = np.linspace(0.0, 8.0, 801)
    early, late = np.where(angle < 1.0, 0.0, 1.0), np.where(angle < 3.0, 0.0, 1.0)
    assert 3.0 <= choose_window(angle, [early, late], PITCH).begin < 3.0 + 2.0 * PITCH
    window = choose_window(angle, [np.where(angle < 5.1, 0.0, 1.0)], PITCH)
    assert window.begin == pytest.approx(20 * PITCH)
    assert window.pitches == 11


def test_few_pitches_give_the_second_half():
    angle = np.linspace(0.0, (FEWEST_PITCHES - 0.5) * PITCH, 100)
    window = choose_window(angle, [np.ones_like(angle)], PITCH)
    assert (window.begin, window.end, window.pitches) == (0.5 * angle[-1], angle[-1], 1)


def test_a_trend_is_found_with_an_error_that_holds():
    random, slope = np.random.default_rng(2), 0.01
    found = [trend(slope * np.arange(20) + random.normal(0.0, 0.05, 20)) for _ in range(2000)]
    change = np.array([one.change for one in found])
    assert_allclose(change.mean(), 20 * slope, atol=0.01)
    # Lengthened for correlation that there is not: never shorter than the scatter.
    assert 1.0 < np.mean([one.error for one in found]) / change.std() < 1.2


def test_correlated_values_have_a_longer_standard_error():
    random = np.random.default_rng(3)
    means, errors = [], []
    for _ in range(500):
        values = np.zeros(64)
        for k in range(1, 64):
            values[k] = 0.6 * values[k - 1] + random.normal()
        means.append(values.mean())
        errors.append(standard_error(values))
    assert_allclose(np.mean(errors), np.std(means), rtol=0.15)


def test_a_plain_drum_has_blocks_instead_of_pitches():
    assert lifter_pitch(0) == 0.25
    assert_allclose(lifter_pitch(8), 2.0 * math.pi / 8)
