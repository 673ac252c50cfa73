"""Cases against each other: windows, ratios, regression."""

import copy
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from numpy.testing import assert_allclose

from millscale.analysis.finished_campaign import load_campaign
from millscale.analysis.single_ball.comparison import (
    case_key,
    policy_models,
    regression_line,
    regressions,
    single_ball_rows,
)
from synthetic_case import MODELS, POLICIES, SCHEMES


@pytest.fixture
def single(runs):
    return copy.deepcopy(load_campaign(runs).single)


def row_of(rows, scheme, policy, S):
    return next(r for r in rows if (r["scheme"], r["policy"], r["S"]) == (scheme, policy, S))


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("policy", ["corrected", "offset-liner"])
def test_ratio_is_that_of_the_centre_path_when_the_path_is_similar(single, scheme, policy):
    rows = single_ball_rows(single)
    for S in MODELS:
        row = row_of(rows, scheme, policy, S)
        # Detach angle and mill angles are the same; ten digits in the series.
        assert_allclose(row["energy_ratio"], row["centre_path_ratio"], rtol=1e-7)
        assert_allclose(row["relative_error_to_centre_path"], 0.0, atol=1e-7)


def test_energy_ratio_is_inverse_s_with_the_offset_liner(single):
    rows = single_ball_rows(single)
    for (scheme, power), S in product(zip(SCHEMES, (1, 2), strict=True), MODELS):
        row = row_of(rows, scheme, "offset-liner", S)
        assert_allclose(row["energy_ratio"], S**-power, rtol=1e-7)
        assert_allclose(row["relative_error"], 0.0, atol=1e-7)


def test_rows_come_by_scheme_policy_and_s(single):
    rows = single_ball_rows(single[::-1])
    expected = list(product(SCHEMES, POLICIES, MODELS))
    assert [(r["scheme"], r["policy"], r["S"]) for r in rows] == expected


def test_reference_may_be_another_policy_which_is_the_same_mill_at_s_1(single):
    kept = [c for c in single if c.case["S"] > 1.0 or c.case["policy"] == "paper"]
    full, rows = single_ball_rows(single), single_ball_rows(kept)
    for row in rows:
        same = row_of(full, row["scheme"], row["policy"], row["S"])
        assert_allclose(row["energy_ratio"], same["energy_ratio"], rtol=1e-9)
        assert row["reference"].endswith("-paper-S1.000")


def test_policy_without_s_1_borrows_it_for_its_regression_and_figures(single):
    kept = [c for c in single if c.case["S"] > 1.0 or c.case["policy"] == "paper"]
    for fit, full in zip(
        regressions(single_ball_rows(kept)), regressions(single_ball_rows(single)), strict=True
    ):
        assert fit["models"] == len(MODELS)
        assert_allclose(fit["slope"], full["slope"], rtol=1e-9)
        assert fit["worst_case"] == full["worst_case"]
    models = policy_models(kept, case_key)
    assert list(models) == list(product(SCHEMES, POLICIES))
    for group in models.values():
        assert tuple(case.case["S"] for case in group) == MODELS
        assert len({case.case["scheme"] for case in group}) == 1


def test_energies_are_taken_between_the_same_mill_angles_in_a_scheme(single):
    """A model thrown later: the others are taken from then on, each on its own parabola."""
    late = next(c for c in single if c.id == "sb-cg-corrected-S2.600")
    throw = late.result["throws"][0]
    throw["mill_angle_rad"] += 0.2
    rows = single_ball_rows(single)
    gravity = [row for row in rows if row["scheme"] == "constant-gravity"]
    assert {row["energy_begin_rad"] for row in gravity} == {throw["mill_angle_rad"]}
    row, late_row = (row_of(gravity, "constant-gravity", p, 2.6) for p in POLICIES[:2])
    # Of a flight begun 0.2 rad earlier the stretch is a later one: it falls faster by then.
    case = next(c for c in single if c.id == row["id"]).case
    g, omega, mass = case["mill"]["gravity_m_s2"], case["mill"]["omega_rad_s"], 0.0897
    later = row["energy_change_J"] - row["from_throw_energy_change_J"]
    expected = mass * g**2 * (0.2 / omega) * (row["from_throw_window_rad"] / omega)
    assert_allclose(later, expected, rtol=2e-3)
    assert_allclose(late_row["energy_change_J"], late_row["from_throw_energy_change_J"], rtol=1e-9)


def test_without_s_1_there_is_no_ratio(single):
    rows = single_ball_rows([c for c in single if c.case["S"] > 1.0])
    assert all(row["energy_ratio"] is row["relative_error"] is None for row in rows)
    assert all(fit["correlation"] is fit["worst_case"] is None for fit in regressions(rows))


def test_case_without_a_throw_stays_in_the_table(single):
    idle = single[1]
    empty = {"throws": [], "throw_energy": None, "paper_angles": None, "problem": "no throw"}
    single[1] = replace(idle, result=idle.result | empty)
    row = next(r for r in single_ball_rows(single) if r["id"] == idle.id)
    assert row["problem"] == "no throw"
    assert row["energy_change_J"] is row["energy_ratio"] is row["from_throw_ratio"] is None


def test_regression_recovers_a_known_line_and_correlation():
    rng = np.random.default_rng(3)
    x = np.linspace(0.1, 1.0, 400)
    y = 0.9 * x + 0.05 + rng.normal(0.0, 0.1, x.size)
    found = regression_line(x.tolist(), y.tolist())
    covariance = np.cov(x, y)
    slope = covariance[0, 1] / covariance[0, 0]
    assert_allclose(found["slope"], slope, rtol=1e-12)
    assert_allclose(found["intercept"], y.mean() - slope * x.mean(), rtol=1e-10)
    assert_allclose(found["correlation"], np.corrcoef(x, y)[0, 1], rtol=1e-12)


def test_two_points_make_no_regression():
    assert regression_line([1.0, 0.5], [1.0, 0.4])["correlation"] is None


def test_worst_deviation_and_spread_are_the_largest(single):
    rows = single_ball_rows(single)
    for row, error, angle in zip(rows[:3], (0.0, -0.03, 0.02), (35.0, 36.0, 35.5), strict=True):
        row["relative_error"], row["detach_angle_deg"] = error, angle
    fit = regressions(rows)[0]
    assert (fit["worst_relative_error"], fit["worst_case"]) == (-0.03, rows[1]["id"])
    assert_allclose(fit["detach_angle_spread_deg"], 1.0)
