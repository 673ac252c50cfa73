"""The exponent at which an observable of two mills agrees, of laws with a known exponent."""

import math

import numpy as np
import pytest

from millscale.calibration.friction_exponent import match
from millscale.errors import PredictionError
from millscale.prediction.extrapolation import Group, Noise

REFERENCE = 0.37
NOISE = Noise(1e-4, math.inf)


def reference(*shifts):
    return Group(1.696, tuple(REFERENCE + shift for shift in shifts or (0.0,)))


def tried(law, *exponents, seeds=1):
    return {k: Group(2.6, (REFERENCE + law(k),) * seeds) for k in exponents}


def line(k):
    """Zero at 1.17."""
    return 0.01 * (1.0 - k / 1.17)


def parabola(k):
    """Zero at 1.2; friction counts for more the less there is."""
    return 0.008 * (1.0 - k / 1.2) * (1.0 + 0.5 * k)


def test_two_runs_give_the_zero_of_their_line():
    found = match(reference(), tried(line, 0.0, 2.0), NOISE)
    assert found.exponent == pytest.approx(1.17, rel=1e-12)
    assert found.differences == pytest.approx({0.0: line(0.0), 2.0: line(2.0)})
    assert found.next_exponent == 1.17


def test_three_runs_give_the_zero_of_their_parabola():
    found = match(reference(), tried(parabola, 0.0, 2.0, 1.5), NOISE)
    assert found.exponent == pytest.approx(1.2, rel=1e-9)
    assert found.next_exponent == 1.2


def test_a_run_at_the_exponent_confirms_it():
    assert match(reference(), tried(line, 0.0, 2.0, 1.16), NOISE).next_exponent is None
    assert match(reference(), tried(line, 0.0, 2.0, 1.5), NOISE).next_exponent == 1.17


def test_after_the_third_run_the_noise_decides_what_is_near_enough():
    loud = Noise(9e-4, math.inf)
    found = match(reference(), tried(line, 0.0, 2.0, 1.4), loud)
    assert 0.23 < found.half_width < 0.4
    assert found.next_exponent is None
    assert match(reference(), tried(line, 0.0, 2.0), loud).next_exponent == 1.17


def test_the_end_of_the_range_needs_no_third_run_where_it_matches():
    def law(k):
        return 0.01 * (1.0 - k / 1.97)

    assert match(reference(), tried(law, 0.0, 2.0), Noise(2e-4, math.inf)).next_exponent is None
    assert match(reference(), tried(law, 0.0, 2.0), Noise(2e-5, math.inf)).next_exponent == 1.97


@pytest.mark.parametrize("exponents", [(0.0, 2.0), (0.0, 2.0, 1.3)])
def test_the_interval_holds_the_exponent_as_often_as_it_states(exponents):
    generator = np.random.default_rng(1)
    inside = 0
    draws = 2000
    for _ in range(draws):
        noisy = {
            k: Group(2.6, tuple(REFERENCE + parabola(k) + 1e-4 * generator.normal(size=2)))
            for k in exponents
        }
        mill = reference(*(1e-4 * generator.normal(size=3)))
        found = match(mill, noisy, NOISE)
        line_root = 2.0 * parabola(0.0) / (parabola(0.0) - parabola(2.0))
        true = 1.2 if len(exponents) == 3 else line_root
        inside += abs(found.exponent - true) <= found.half_width
    # Two standard deviations of a share of 0.95, and the curvature of the fit.
    assert inside / draws == pytest.approx(0.95, abs=2.0 * math.sqrt(0.95 * 0.05 / draws) + 0.005)


def test_more_seeds_narrow_the_interval():
    one, four = (
        match(reference(*(0.0,) * n), tried(line, 0.0, 2.0, seeds=n), NOISE).half_width
        for n in (1, 4)
    )
    assert four == pytest.approx(0.5 * one, rel=0.02)


@pytest.mark.parametrize(
    ("law", "message"),
    [
        (lambda k: 1e-4 * (1.0 - k), r"differ by \+0.0001 in -x_c / R without matching"),
        (lambda k: 0.01 - 1e-5 * k, r"k = 2 changes -x_c / R by -2e-05"),
        (lambda k: -0.01 * (1.0 + k), "no k above 0 and up to 2 matches"),
        (lambda k: 0.01 * (1.0 - k / 2.6), "no k above 0 and up to 2 matches"),
    ],
)
def test_what_does_not_determine_an_exponent_is_refused(law, message):
    with pytest.raises(PredictionError, match=message):
        match(reference(), tried(law, 0.0, 2.0), NOISE)


def test_a_parabola_that_the_noise_lifts_off_zero_is_refused():
    def law(k):
        return 0.01 * (k / 1.5 - 1.0) ** 2 - 1e-5

    with pytest.raises(PredictionError, match="is not determined"):
        match(reference(), tried(law, 0.0, 1.3, 2.0), NOISE)
