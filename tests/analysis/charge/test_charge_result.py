"""Means over the steady part of a charge's rotation, and whether it is steady."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from millscale.analysis.charge.result import charge_result, charge_scales
from synthetic_case import case_document, typed
from synthetic_charge import charge_columns


@pytest.fixture
def charge_case():
    return case_document("multi-ball", "constant-gravity", "paper", 2.6, balls=150)


def result_of(case, columns):
    return charge_result(typed(case), columns)


def test_means_are_those_put_in(charge_case):
    result = result_of(charge_case, charge_columns(charge_case, end=8.0))
    expected = {"kinetic": 0.3, "torque": 0.37, "power": 0.37, "centre_x": -0.37, "centre_z": -0.4}
    for name, value in expected.items():
        assert_allclose(result.dimensionless[name], value, rtol=2e-3)
    assert_allclose(result.mean["flying_share"], 0.3)
    assert_allclose(result.liner_slip, 0.04)
    assert result.problem is None
    assert result.steady.is_steady, result.steady.reasons


def test_the_slip_is_that_of_the_rows_with_a_ball_on_the_liner(charge_case):
    columns = charge_columns(charge_case, end=8.0)
    columns["liner_slip"][::2] = np.nan
    columns["liner_slip"][1::2] = 0.6
    assert_allclose(result_of(charge_case, columns).liner_slip, 0.6)
    columns["liner_slip"][:] = np.nan
    assert result_of(charge_case, columns).liner_slip is None
    del columns["liner_slip"]  # of an earlier version
    assert result_of(charge_case, columns).liner_slip is None


def test_a_short_rotation_has_means_of_its_second_half_and_is_not_called_steady(charge_case):
    result = result_of(charge_case, charge_columns(charge_case))
    assert_allclose(result.dimensionless["torque"], 0.37, rtol=1e-9)
    assert (result.mean_from_rad, result.mean_to_rad) == (0.5, 1.0)
    assert result.steady.reasons == (
        "the rotation of 1 rad has fewer than 8 lifter pitches: too few to show whether the charge "
        "is steady",
    )


def test_torque_and_power_are_those_of_the_work_whatever_the_rows_show(charge_case):
    columns = charge_columns(charge_case, end=8.0)
    before = result_of(charge_case, columns).mean
    columns["drive_torque_Nm"] = columns["drive_power_W"] = np.full(201, np.pi)
    after = result_of(charge_case, columns).mean
    assert after == before
    omega = charge_case["mill"]["omega_rad_s"]
    assert_allclose(after["power_W"], after["drive_torque_Nm"] * omega)


def test_the_mass_is_that_of_the_balls_there_are(charge_case):
    columns = charge_columns(charge_case, end=8.0)
    columns["mass_kg"] *= 1.01
    assert_allclose(charge_scales(typed(charge_case), columns).mass, columns["mass_kg"][0])
    result = result_of(charge_case, columns)
    assert_allclose(result.dimensionless["torque"], 0.37 / 1.01, rtol=2e-3)


def test_the_two_ways_to_the_torque_agree_and_a_torque_that_is_off_shows(charge_case):
    columns = charge_columns(charge_case, end=8.0)
    balance = result_of(charge_case, columns).torque_balance
    assert abs(balance.difference) < 1e-9
    columns["drive_work_J"] *= 1.01
    balance = result_of(charge_case, columns).torque_balance
    assert_allclose(balance.difference, 0.0037, rtol=2e-2)


def test_the_alternating_part_is_a_root_mean_square(charge_case):
    result = result_of(charge_case, charge_columns(charge_case, end=8.0))
    assert_allclose(result.alternating_torque, 1e-3)


def test_a_start_that_differs_does_not_enter_the_means(charge_case):
    columns = charge_columns(charge_case, end=8.0)
    begun = columns["mill_angle_rad"] > 2.5
    for name in ("centre_x_m", "kinetic_translation_J"):
        columns[name] = np.where(begun, columns[name], 0.2 * columns[name])
    result = result_of(charge_case, columns)
    assert 2.5 < result.mean_from_rad < 2.8
    assert_allclose(result.dimensionless["kinetic"], 0.3, rtol=1e-9)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ("drift", "its centre of mass drifts by "),
        ("momentum", "its angular momentum changes: "),
        ("late", "its centre of mass drifts by "),
    ],
)
def test_a_charge_that_is_not_steady_has_reasons(charge_case, change, reason):
    columns = charge_columns(charge_case, end=8.0)
    share = columns["mill_angle_rad"] / 8.0
    if change == "drift":
        columns["centre_x_m"] = columns["centre_x_m"] * (1.0 + 0.1 * share)
    elif change == "late":
        columns["centre_x_m"] = columns["centre_x_m"] * np.where(share < 0.75, 0.5, 1.0)
    else:
        torque = charge_scales(typed(charge_case), columns).torque
        columns["angular_momentum_Nms"] += 0.02 * torque * columns["time_s"]
    steady = result_of(charge_case, columns).steady
    assert not steady.is_steady
    assert any(text.startswith(reason) for text in steady.reasons), steady.reasons


def test_lost_balls_and_deep_overlap_are_in_the_result(charge_case):
    columns = charge_columns(charge_case)
    columns["balls"][-3:] -= 2
    columns["largest_overlap_m"] = np.full(columns["balls"].size, 5e-3)
    result = result_of(charge_case, columns)
    assert result.problem == "150 balls planned, 148 to 150 in the series: lost or added"
    assert_allclose(result.largest_overlap_over_radius, 0.25)
