"""Cases against each other: windows, ratios, regression."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from numpy.testing import assert_allclose

from millscale.analysis.finished_campaign import load_campaign
from millscale.analysis.measures import COMMON_ANGLES, FROM_THROW
from millscale.analysis.single_ball.comparison import (
    by_policy,
    regression_line,
    regressions,
    single_ball_rows,
)
from synthetic_case import MODELS, POLICIES, SCHEMES
from synthetic_result import with_result, with_throw


@pytest.fixture
def single(runs):
    return load_campaign(runs).single


def row_of(rows, scheme, policy, S):
    return next(r for r in rows if (r.scheme, r.policy, r.S) == (scheme, policy, S))


def ratio(row, window=COMMON_ANGLES):
    return row.energies[window].ratio


def change(row, window=COMMON_ANGLES):
    return row.energies[window].change_J


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("policy", ["corrected", "offset-liner"])
def test_ratio_is_that_of_the_centre_path_when_the_path_is_similar(single, scheme, policy):
    rows = single_ball_rows(single)
    for S in MODELS:
        row = row_of(rows, scheme, policy, S).document()
        # Detach angle and mill angles are the same; ten digits in the series.
        assert_allclose(row["energy_ratio"], row["centre_path_ratio"], rtol=1e-7)
        assert_allclose(row["relative_error_to_centre_path"], 0.0, atol=1e-7)


def test_energy_ratio_is_inverse_s_with_the_offset_liner(single):
    rows = single_ball_rows(single)
    for (scheme, power), S in product(zip(SCHEMES, (1, 2), strict=True), MODELS):
        row = row_of(rows, scheme, "offset-liner", S)
        assert_allclose(ratio(row), S**-power, rtol=1e-7)
        assert_allclose(row.energies[COMMON_ANGLES].relative_error, 0.0, atol=1e-7)


def test_rows_come_by_scheme_policy_and_s(single):
    rows = single_ball_rows(single[::-1])
    expected = list(product(SCHEMES, POLICIES, MODELS))
    assert [(r.scheme, r.policy, r.S) for r in rows] == expected


def test_reference_may_be_another_policy_which_is_the_same_mill_at_s_1(single):
    kept = [c for c in single if c.S > 1.0 or c.policy == "paper"]
    full, rows = single_ball_rows(single), single_ball_rows(kept)
    for row in rows:
        same = row_of(full, row.scheme, row.policy, row.S)
        assert_allclose(ratio(row), ratio(same), rtol=1e-9)
        assert row.reference.endswith("-paper-S1.000")


def test_policy_without_s_1_borrows_it_for_its_regression_and_figures(single):
    kept = [c for c in single if c.S > 1.0 or c.policy == "paper"]
    for fit, full in zip(
        regressions(single_ball_rows(kept)), regressions(single_ball_rows(single)), strict=True
    ):
        assert fit.mills == len(MODELS)
        ours, whole = fit.fits[COMMON_ANGLES], full.fits[COMMON_ANGLES]
        assert_allclose(ours.line.slope, whole.line.slope, rtol=1e-9)
        assert ours.worst_case == whole.worst_case
    mills = by_policy(kept)
    assert list(mills) == list(product(SCHEMES, POLICIES))
    for group in mills.values():
        assert tuple(ball.S for ball in group) == MODELS
        assert len({ball.scheme for ball in group}) == 1


def test_energies_are_taken_between_the_same_mill_angles_in_a_scheme(single):
    """A mill thrown later: the others are taken from then on, each on its own parabola."""
    number = next(i for i, ball in enumerate(single) if ball.id == "sb-cg-corrected-S2.600")
    late = single[number].result.throws[0].mill_angle_rad + 0.2
    single[number] = with_throw(single[number], mill_angle_rad=late)
    rows = single_ball_rows(single)
    gravity = [row for row in rows if row.scheme == "constant-gravity"]
    assert {row.throw.energy_begin_rad for row in gravity} == {late}
    row, late_row = (row_of(gravity, "constant-gravity", p, 2.6) for p in POLICIES[:2])
    # Of a flight begun 0.2 rad earlier the stretch is a later one: it falls faster by then.
    mill, mass = row.ball.case.mill, 0.0897
    g, omega = mill.gravity_m_s2, mill.omega_rad_s
    later = change(row) - change(row, FROM_THROW)
    expected = mass * g**2 * (0.2 / omega) * (row.throw.from_throw_window_rad / omega)
    assert_allclose(later, expected, rtol=2e-3)
    assert_allclose(change(late_row), change(late_row, FROM_THROW), rtol=1e-9)


def test_without_s_1_there_is_no_ratio(single):
    rows = single_ball_rows([c for c in single if c.S > 1.0])
    assert all(ratio(row) is row.energies[COMMON_ANGLES].relative_error is None for row in rows)
    fits = [fit.fits[COMMON_ANGLES] for fit in regressions(rows)]
    assert all(fit.line.correlation is fit.worst_case is None for fit in fits)


def test_case_without_a_throw_stays_in_the_table(single):
    idle = single[1]
    empty = {"throws": [], "throw_energy": None, "paper_angles": None, "problem": "no throw"}
    single[1] = with_result(idle, **empty)
    row = next(r for r in single_ball_rows(single) if r.id == idle.id).document()
    assert row["problem"] == "no throw"
    assert row["energy_change_J"] is row["energy_ratio"] is row["from_throw_ratio"] is None


def test_regression_recovers_a_known_line_and_correlation():
    rng = np.random.default_rng(3)
    x = np.linspace(0.1, 1.0, 400)
    y = 0.9 * x + 0.05 + rng.normal(0.0, 0.1, x.size)
    found = regression_line(x.tolist(), y.tolist())
    covariance = np.cov(x, y)
    slope = covariance[0, 1] / covariance[0, 0]
    assert_allclose(found.slope, slope, rtol=1e-12)
    assert_allclose(found.intercept, y.mean() - slope * x.mean(), rtol=1e-10)
    assert_allclose(found.correlation, np.corrcoef(x, y)[0, 1], rtol=1e-12)


def test_two_points_make_no_regression():
    assert regression_line([1.0, 0.5], [1.0, 0.4]).correlation is None


def test_worst_deviation_and_spread_are_the_largest(single):
    angles = (35.0, 36.0, 35.5)
    balls = [with_result(b, detach_angle_deg=a) for b, a in zip(single, angles, strict=False)]
    rows = single_ball_rows(balls)
    for i, error in enumerate((0.0, -0.03, 0.02)):
        found = replace(rows[i].energies[COMMON_ANGLES], relative_error=error)
        rows[i] = replace(rows[i], energies=rows[i].energies | {COMMON_ANGLES: found})
    fit = regressions(rows)[0]
    common = fit.fits[COMMON_ANGLES]
    assert (common.worst_relative_error, common.worst_case) == (-0.03, rows[1].id)
    assert_allclose(fit.spread_deg["detach_angle"], 1.0)
