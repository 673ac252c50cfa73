"""Claims of a campaign."""

import copy

import pytest

from millscale.analysis.checks import campaign_checks
from millscale.analysis.finished_campaign import load_campaign


@pytest.fixture
def campaign(runs):
    return copy.deepcopy(load_campaign(runs))


def checks_of(campaign, missing=None):
    return campaign_checks(campaign.rows, campaign.fits, campaign.charges, missing or {})


def test_similar_mills_pass(campaign):
    checks = checks_of(campaign)
    assert len(checks) > 10
    # The made-up charges turn by 1 rad.
    short = {f"steady/{case.id}" for case in campaign.charges}
    assert {name for name, check in checks.items() if not check["passed"]} == short


def test_missing_case_fails(campaign):
    checks = checks_of(campaign, {"sb-cg-paper-S1.000": "no series.csv yet"})
    assert checks["all_cases_finished"]["passed"] is False


@pytest.mark.parametrize(
    ("key", "value", "check"),
    [
        ("off_parabola", 0.01, "flight_is_a_parabola"),
        ("energy_imbalance", 0.01, "kinetic_gain_is_potential_loss"),
        ("problem", "no throw", "every_ball_is_thrown"),
    ],
)
def test_one_bad_row_fails(campaign, key, value, check):
    campaign.rows[4][key] = value
    assert checks_of(campaign)[check]["passed"] is False


def test_worst_deviation_of_the_better_policy_counts(campaign):
    worst = {"paper": 0.03, "corrected": -0.012, "offset-liner": 0.02}
    for fit in campaign.fits:
        fit["worst_relative_error"] = worst[fit["policy"]]
        fit["detach_angle_spread_deg"] = {"corrected": 1.6}.get(fit["policy"], 0.1)
    checks = checks_of(campaign)
    assert checks["worst_deviation/constant-speed/paper"]["passed"] is True
    better = checks["worst_deviation/constant-speed/better"]
    assert (better["value"], better["passed"]) == (0.012, True)
    assert "corrected" in better["text"]
    assert checks["detach_angle_spread/constant-speed/better"]["passed"] is False
    assert checks["liner_off_angle_spread/constant-speed/better"]["passed"] is True


def test_what_cannot_be_told_neither_passes_nor_fails(campaign):
    for fit in campaign.fits:
        fit["correlation"] = None
    assert checks_of(campaign)["linear_in_prediction/constant-gravity/paper"]["passed"] is None


def test_lost_balls_fail(campaign):
    case = campaign.charges[0]
    case.result["problem"] = "two balls fewer"
    case.result["largest_overlap_over_radius"] = 0.2
    checks = checks_of(campaign)
    assert checks[f"balls_kept/{case.id}"]["passed"] is False
    assert checks[f"overlap/{case.id}"]["passed"] is False


@pytest.mark.parametrize(
    ("change", "check"),
    [
        ({"torque_balance": {"difference": -0.002}}, "torque_balance"),
        ({"alternating_torque": 0.02}, "alternating_torque"),
        ({"steady": {"reasons": ["it drifts"]}}, "steady"),
    ],
)
def test_a_torque_that_cannot_be_trusted_fails(campaign, change, check):
    case = campaign.charges[0]
    sound = {"torque_balance": {"difference": 1e-6}, "alternating_torque": 1e-3}
    case.result.update(sound | {"steady": {"reasons": []}})
    name = f"{check}/{case.id}"
    assert checks_of(campaign)[name]["passed"]
    case.result.update(change)
    assert checks_of(campaign)[name]["passed"] is False
