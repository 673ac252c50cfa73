"""End walls from a campaign to its results: power of the ends, torque balance, energy budget."""

import math

import pytest
from test_left_out import NOTHING_FORCED, ran, run_decks

from millscale.analysis.charge.energy_budget import energy_budget, read_ledger
from millscale.analysis.charge.result import charge_result
from millscale.campaign.build import load_campaign
from millscale.cases.case import cases_of
from millscale.runs.series import read_series
from paper_campaign import REPOSITORY

pytestmark = pytest.mark.engine

CAMPAIGN = REPOSITORY / "campaigns" / "ends.toml"
SHORT = {
    "count": [300],
    "slice_diameters": 3.0,
    "settle_s": 0.5,
    "rotation_angle_rad": 0.6,
    "ramp_turns": 0.02,
    "dump_angle_rad": 0.1,
    "step_s": 1e-4,
    "ledger": True,
}


def _result(folder, ends, **mill):
    """Result, energy budget and case of a short rotation between such ends."""
    changes = {f"mill__{key}": value for key, value in mill.items()}
    run = ran(folder, "analytic", {"multi_ball": SHORT}, NOTHING_FORCED, mill__ends=ends, **changes)
    case = cases_of(load_campaign(run / "campaign.toml"))[0]
    series = read_series(run / "series.csv", "multi-ball")
    return charge_result(case, series), energy_budget(read_ledger(run)), case, run


@pytest.mark.parametrize("ends", ["periodic", "turning", "resting"])
def test_torque_and_energy_are_accounted_for_between_any_ends(tmp_path, ends):
    result, budget, case, run = _result(tmp_path / ends, ends)
    # Rows of the series, 0.01 rad apart, resolve the weight's arm; the impulses are exact.
    assert abs(result.torque_balance.difference) < 2e-3
    assert abs(budget.closure_of_forces) < 1e-5
    assert abs(budget.closure) < 0.02
    assert case.time.speed_changes == ((0.0, 0.02 * math.tau, 1.0),)
    # Dumps are at whole multiples of their angle, also after the ramp.
    dumps = sorted(path.name for path in (run / "dump").iterdir())
    assert len(dumps) == 7
    if ends == "periodic":
        assert result.ends is None
        assert result.torque_balance.resting_ends_Nm is None
        return
    turning = ends == "turning"
    assert result.ends is not None
    assert (result.ends.torque_Nm > 0.0) == turning  # they lift the charge, or hold it back
    assert (result.ends.power_W > 0.0) == turning
    assert (result.torque_balance.resting_ends_Nm is None) == turning


def test_frictionless_ends_take_no_torque(tmp_path):
    result, _, case, _ = _result(
        tmp_path / "smooth", "turning", end_static_friction=0.0, end_rolling_friction=0.0
    )
    assert case.mill.end_static_friction == 0.0
    assert result.ends is not None
    assert abs(result.ends.torque_Nm) < 1e-9 * result.torque_balance.summed_Nm


@pytest.mark.validate
def test_power_of_a_short_mill_with_three_kinds_of_ends(tmp_path):
    """A mill of L / D = 0.3: turning ends lift more than periodic ones, resting ends brake."""
    text, found = CAMPAIGN.read_text(encoding="utf-8"), {}
    for ends in ("periodic", "turning", "resting"):
        folder = tmp_path / ends
        folder.mkdir()
        file = folder / "ends.toml"
        assert 'ends = "periodic"' in text
        file.write_text(text.replace('ends = "periodic"', f'ends = "{ends}"'), encoding="utf-8")
        case = cases_of(load_campaign(file))[0]
        assert case.groups.length_over_mill_radius == (None if ends == "periodic" else 0.6)
        run_decks(folder, case)
        result = charge_result(case, read_series(folder / "series.csv", "multi-ball"))
        budget = energy_budget(read_ledger(folder))
        assert abs(result.torque_balance.difference) < 1e-3
        assert abs(budget.closure) < 0.01
        assert abs(budget.closure_of_forces) < 1e-5
        found[ends] = result
        ends_power = result.ends.power_W if result.ends else 0.0
        print(
            f"{ends:9}{result.mean['power_W']:9.2f} W of which ends {ends_power:9.3f} W, closure"
            f" {budget.closure:.2e}, of forces {budget.closure_of_forces:.2e}, {result.ends}"
        )
    power = {ends: result.mean["power_W"] for ends, result in found.items()}
    assert power["periodic"] < power["turning"]
    of_turning, of_resting = found["turning"].ends, found["resting"].ends
    assert 0.02 < of_turning.power_share < 0.5
    assert of_resting.power_W == 0.0
    assert of_resting.torque_Nm < 0.0 < of_turning.torque_Nm
