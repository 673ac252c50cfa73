"""Means over a charge's rotation."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from synthetic_case import case_document
from synthetic_charge import charge_columns

from mill_analysis.charge import charge_result, mean_over_rotation


@pytest.fixture
def charge_case():
    return case_document("multi-ball", "constant-gravity", "paper", 2.6, balls=150)


def test_means_are_those_put_in(charge_case):
    result = charge_result(charge_case, charge_columns(charge_case))
    expected = {"kinetic": 0.3, "torque": 0.37, "power": 0.37, "centre_x": -0.2, "centre_z": -0.4}
    for name, value in expected.items():
        assert_allclose(result["dimensionless"][name], value, rtol=1e-9)
    assert_allclose(result["mean"]["flying_share"], 0.3)
    assert (result["mean_from_rad"], result["mean_to_rad"]) == (0.5, 1.0)
    assert result["problem"] is None


def test_drive_power_is_positive_when_the_charge_is_lifted(charge_case):
    columns = charge_columns(charge_case)
    mean = charge_result(charge_case, columns)["mean"]
    assert mean["drive_torque_Nm"] > 0.0 > columns["torque_Nm"].max()
    omega = charge_case["mill"]["omega_rad_s"]
    assert_allclose(mean["power_W"], mean["drive_torque_Nm"] * omega)


def test_start_up_does_not_enter_the_mean(charge_case):
    columns = charge_columns(charge_case)
    before = charge_result(charge_case, columns)["mean"]
    columns["power_W"][columns["mill_angle_rad"] < 0.4] *= 100.0
    assert charge_result(charge_case, columns)["mean"] == before


def test_mean_weighs_by_rotation_not_by_samples():
    angle = np.array([0.0, 0.1, 0.2, 1.0])
    assert_allclose(mean_over_rotation(angle, 3.0 * angle, 0.0), 1.5)


def test_mean_beyond_the_series_is_refused():
    with pytest.raises(ValueError, match=r"series ends at 1 rad, a mean from 2 rad needs two"):
        mean_over_rotation(np.linspace(0, 1, 5), np.ones(5), 2.0)


def test_lost_balls_and_deep_overlap_are_told(charge_case):
    columns = charge_columns(charge_case)
    columns["balls"][-3:] -= 2
    columns["largest_overlap_m"] = np.full(columns["balls"].size, 5e-3)
    result = charge_result(charge_case, columns)
    assert result["problem"] == "150 balls planned, 148 to 150 in the series: lost or added"
    assert_allclose(result["largest_overlap_over_radius"], 0.25)
