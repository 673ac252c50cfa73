"""Extrapolation to S = 1: exact cases, the coverage of the interval, refusals."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

from millscale.prediction.extrapolation import (
    ExtrapolationError,
    Group,
    Noise,
    Prior,
    exact_exponent,
    extrapolate,
    pooled_noise,
    reverses,
    scale_function,
)
from millscale.prediction.kinds import Kind

TWO, THREE = (1.696, 2.6), (1.3, 1.696, 2.6)
TINY = Noise(1e-9, math.inf)


def law(S, p, b=0.5):
    return 1.0 + b * scale_function(S, p)


def groups(S, p, b=0.5):
    return [Group(x, (float(law(x, p, b)),)) for x in S]


def test_the_weights_of_two_groups_are_those_of_a_straight_line():
    """At p = 1: q(1) = 1.77 q(1.696) - .77 q(2.6), by hand. The interval mixes all p."""
    found = extrapolate([Group(1.696, (1.0,)), Group(2.6, (1.0,))], TINY)
    near, far = found.weights
    p = found.exponent
    assert p == pytest.approx(0.5)
    assert near == pytest.approx((2.6**p - 1.0) / (2.6**p - 1.696**p))
    assert near + far == pytest.approx(1.0)


def test_the_logarithm_is_the_limit_of_small_exponents():
    assert_allclose(scale_function(2.6, 1e-9), math.log(2.6), rtol=1e-8)
    assert scale_function(2.6, 0.0) == math.log(2.6)
    assert scale_function(1.0, 0.3) == 0.0


@pytest.mark.parametrize("p", [0.1, 0.5, 0.9])
def test_without_noise_the_interval_of_two_groups_holds_every_exponent(p):
    found = extrapolate(groups(TWO, p), TINY)
    assert found.lower < 1.0 < found.upper
    assert found.noise_error < 1e-7 < found.exponent_error


@pytest.mark.parametrize("p", [0.1, 0.5, 0.9])
def test_three_groups_tell_the_exponent(p):
    """With noise far below the differences, only exponents near the true one are left."""
    noise = Noise(1e-4, math.inf)
    found = extrapolate(groups(THREE, p), noise)
    assert found.exponent == pytest.approx(p, abs=0.03)
    error = math.hypot(found.noise_error, found.exponent_error)
    assert found.value == pytest.approx(1.0, abs=3.0 * error)
    assert found.half_width < 0.2 * extrapolate(groups(THREE[1:], p), noise).half_width


def test_a_run_of_the_physical_mill_narrows_to_itself():
    near = [Group(1.0, (1.0,)), Group(2.6, (2.0,))]
    found = extrapolate(near, Noise(0.01, math.inf))
    assert found.weights == pytest.approx((1.0, 0.0), abs=1e-12)
    assert found.half_width == pytest.approx(1.96 * 0.01, rel=1e-3)


def test_the_physical_mill_alone_has_the_interval_of_its_mean():
    """t s / sqrt(n), by hand: t = 4.303 at 97.5 % and 2 degrees of freedom."""
    found = extrapolate([Group(1.0, (0.9, 1.1, 1.0))])
    assert found.value == pytest.approx(1.0)
    assert found.half_width == pytest.approx(4.303 * 0.1 / math.sqrt(3.0), rel=1e-3)
    assert found.weights == (1.0,)
    assert found.residual_probability is None


def test_few_seeds_widen_the_interval_as_students_t_does():
    runs = [Group(1.0, (0.0,)), Group(2.6, (0.0,))]
    known = extrapolate(runs, Noise(1.0, math.inf)).half_width
    assert known == pytest.approx(1.959964, rel=1e-4)
    assert extrapolate(runs, Noise(1.0, 2.0)).half_width == pytest.approx(4.302653, rel=1e-4)


def test_the_noise_is_pooled_over_the_groups():
    noise = pooled_noise([Group(1.5, (1.0, 3.0)), Group(2.5, (0.0, 0.0, 3.0)), Group(3.0, (7.0,))])
    assert noise.freedom == 3
    assert noise.deviation == pytest.approx(math.sqrt((2.0 + 6.0) / 3.0))


def coverage(drawn, assumed, S, seeds, trials=500):
    """Share of intervals of 95 % that hold the truth, for exponents drawn from one prior and
    intervals that assume another; noise a tenth of the error at S = 2.6."""
    random = np.random.default_rng(20)
    inside = 0
    for _ in range(trials):
        p, b = random.uniform(drawn.lower, drawn.upper), random.normal()
        deviation = 0.1 * abs(b)
        runs = [Group(x, tuple(law(x, p, b) + deviation * random.normal(size=seeds))) for x in S]
        found = extrapolate(runs, prior=assumed)
        inside += found.lower <= 1.0 <= found.upper
    return inside / trials


def is_honest(share):
    """The standard deviation of a share of 500 is 1 %; few seeds and a flat p make intervals wider
    than needed, never narrower."""
    return 0.92 <= share <= 0.99


@pytest.mark.parametrize("kind", Kind)
@pytest.mark.parametrize(("S", "seeds"), [(TWO, 2), ((1.5, 2.0, 3.0, 4.0), 3)])
def test_the_interval_covers_what_it_says(kind, S, seeds):
    assert is_honest(coverage(kind.prior, kind.prior, S, seeds))


@pytest.mark.parametrize("kind", Kind)
def test_the_coverage_shows_an_interval_that_is_too_narrow(kind):
    """A fixed exponent in the middle of the prior leaves the noise alone."""
    middle = 0.5 * (kind.prior.lower + kind.prior.upper)
    fixed = Prior(middle - 1e-3, middle + 1e-3)
    assert coverage(kind.prior, fixed, (1.3, 2.6), seeds=8) < 0.92


def test_the_coverage_shows_a_prior_that_misses_the_exponents():
    """Spin is linear in S, which a prior around 0 misses."""
    assert coverage(Prior(0.999, 1.001), Prior(-0.5, 0.5), TWO, seeds=8, trials=200) < 0.8


@pytest.mark.parametrize(("y", "p"), [(1e-6, 1.0), (1.0, 0.0), (3.0, -0.5)])
def test_the_friction_prior_is_the_local_exponent_of_mu(y, p):
    """mu ~ 1 / (1 + I_0 / I) at I = y I_0: p - 1 = S q'' / q', here by finite differences."""

    def mu(S):
        return 1.0 / (1.0 + 1.0 / (y * S))

    h = 1e-3
    slope = (mu(1.0 + h) - mu(1.0 - h)) / (2.0 * h)
    bend = (mu(1.0 + h) - 2.0 * mu(1.0) + mu(1.0 - h)) / h**2
    assert 1.0 + bend / slope == pytest.approx(p, abs=1e-3)
    prior = Kind.FRICTION.prior
    assert prior.lower <= p + 1e-9 and p - 1e-9 <= prior.upper


@pytest.mark.parametrize("S", [TWO, THREE])
@pytest.mark.parametrize("p", [-0.4, 0.5, 1.2])
def test_the_exponent_of_a_known_mill_is_found(S, p):
    assert exact_exponent(groups(S, p), 1.0) == pytest.approx(p, abs=1e-6)


def test_a_mill_that_no_exponent_gives_has_none():
    assert exact_exponent(groups(TWO, 0.5), 1.9) is None
    assert exact_exponent(groups(TWO, 0.5, 0.0), 1.0) is None


def test_values_that_rise_and_fall_are_not_monotonic():
    noise = Noise(0.1, math.inf)
    rising = [Group(1.3, (1.0,)), Group(1.7, (1.1,)), Group(2.6, (2.0,))]
    assert not reverses(rising, noise)
    within_noise = [Group(1.3, (1.1,)), Group(1.7, (1.0,)), Group(2.6, (2.0,))]
    assert not reverses(within_noise, noise)
    falling = [Group(1.3, (1.5,)), Group(1.7, (1.0,)), Group(2.6, (2.0,))]
    assert reverses(falling, noise)


def test_residuals_tell_when_the_law_does_not_hold():
    noise = Noise(0.01, math.inf)
    met = extrapolate(groups((1.3, 1.7, 2.6, 3.5), 0.4), noise)
    assert met.residual_probability > 0.9
    bent = [Group(1.3, (1.0,)), Group(1.7, (1.3,)), Group(2.6, (0.9,)), Group(3.5, (1.4,))]
    assert extrapolate(bent, noise).residual_probability < 1e-6
    assert extrapolate(groups(TWO, 0.4), noise).residual_probability is None


@pytest.mark.parametrize(
    ("given", "noise", "message"),
    [
        ([Group(2.6, (1.0, 1.1))], None, "S = 2.6 alone"),
        ([], None, "no scaled mill"),
        ([Group(2.5, (1.0, 1.1)), Group(2.6, (1.0,))], None, "too close together"),
        ([Group(1.7, (1.0,)), Group(2.6, (1.0,))], None, "no value of S has two seeds"),
        ([Group(2.6, (1.0,)), Group(2.6, (1.1,))], TINY, "stands in two groups"),
        ([Group(0.5, (1.0,)), Group(2.6, (1.1,))], TINY, "below 1"),
    ],
)
def test_what_cannot_be_extrapolated_is_refused(given, noise, message):
    with pytest.raises(ExtrapolationError, match=message):
        extrapolate(given, noise)
