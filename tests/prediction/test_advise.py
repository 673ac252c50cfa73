"""Plans for a wanted error: the cheapest design that reaches it, and its campaign file."""

import math

import pytest
from typer.testing import CliRunner

from millscale.campaign.build import load_campaign
from millscale.cases.case import cases_of
from millscale.cli.advise import seconds_of, share_of
from millscale.cli.main import app
from millscale.errors import CampaignError, PredictionError
from millscale.prediction.advise import advise
from millscale.prediction.error_model import (
    ErrorModel,
    ObservableError,
    built_in,
    expected_half_width,
    learn,
)
from millscale.prediction.extrapolation import scale_function
from millscale.prediction.predict import predict
from paper_campaign import CAMPAIGNS, REPOSITORY, write_campaign
from synthetic_mills import EXPONENT, SEEDS, SLOPE, TORQUE, charge_case, write_mills

SLICES = CAMPAIGNS / "slices.toml"
# A twentieth at S = 2.6, as the power of the paper's mill.
POWER = ObservableError("power", 0.05 / (2.0 * (math.sqrt(2.6) - 1.0)), 2e-3, 20.0)
ERRORS = ErrorModel(0.02 / 3.9, 5.0, (POWER,), {"command": "a test", "date": "today"})


def test_a_looser_error_costs_less():
    costs = [advise(SLICES, error, ERRORS).chosen.cost_s for error in (0.01, 0.02, 0.05)]
    assert costs == sorted(costs, reverse=True)
    assert costs[0] > 2.0 * costs[-1]


def test_the_chosen_design_is_the_cheapest_that_reaches_the_error():
    found = advise(SLICES, 0.02, ERRORS)
    assert found.met and found.chosen.worst <= 0.02
    for design in found.cheapest:
        assert design.worst > 0.02 or design.cost_s >= found.chosen.cost_s
    names = {design.name for design in found.cheapest}
    assert names == {
        "slice of the physical mill", "one scaled mill", "two scaled mills, extrapolated",
    }  # fmt: skip


def test_extrapolation_is_cheaper_than_one_scaled_mill_of_the_same_error():
    by_name = {design.name: design for design in advise(SLICES, 0.015, ERRORS).cheapest}
    two = by_name["two scaled mills, extrapolated"]
    one = by_name["one scaled mill"]
    assert two.worst <= 0.015
    assert one.worst > 0.015 or one.cost_s > two.cost_s


def test_the_campaign_of_a_plan_has_its_mills_filled_alike(tmp_path):
    found = advise(SLICES, 0.015, ERRORS)
    path = tmp_path / "plan.toml"
    path.write_text(found.text)
    cases = cases_of(load_campaign(path))
    planned = {(S, seed) for S, seeds in found.chosen.mills for seed in range(1, seeds + 1)}
    assert {(case.S, max(case.seed, 1)) for case in cases} == planned
    filling = [case.ball.count * case.S**2 / case.mill.simulated_length_m for case in cases]
    assert max(filling) / min(filling) == pytest.approx(1.0, abs=2e-3)
    diameters = [case.mill.simulated_length_m / 0.04 for case in cases]
    assert diameters == [pytest.approx(4.0)] * len(cases)


def test_a_budget_that_is_too_small_says_what_it_takes():
    found = advise(SLICES, 0.002, ERRORS, budget_s=60.0)
    assert not found.met
    assert found.chosen.cost_s <= 60.0
    assert found.chosen.worst > 0.002


def test_larger_balls_make_larger_errors():
    """The error is a power of S a / R, so twice the a / R has 2^p times the slope."""
    moved = ERRORS.of_mill(0.04 / 3.9).observables[0]
    assert moved.slope == pytest.approx(math.sqrt(2.0) * POWER.slope)
    mills = ((1.7, 1), (2.6, 1))
    assert expected_half_width(moved, mills, 0.95) > expected_half_width(POWER, mills, 0.95)


def test_errors_are_learnt_from_finished_runs(tmp_path):
    cases = [charge_case(S, seed) for S in (1.0, 1.696, 2.6) for seed in SEEDS]
    model = learn(predict([write_mills(tmp_path, *cases)]), {})
    torque = next(row for row in model.observables if row.name == "torque")
    far = SLOPE * float(scale_function(2.6, EXPONENT)) / TORQUE
    assert torque.bias(2.6) == pytest.approx(far, rel=0.02)
    assert torque.deviation == pytest.approx(1e-3 * math.sqrt(2.0), rel=0.1)


def test_the_built_in_errors_are_those_of_a_command():
    model = built_in()
    assert {"command", "commit", "machine", "date"} <= model.origin.keys()
    assert "power" in {row.name for row in model.observables}


def test_what_cannot_be_planned_is_refused(tmp_path):
    with pytest.raises(PredictionError, match="observable powr, nearest is power"):
        advise(SLICES, 0.02, ERRORS, ["powr"])
    with pytest.raises(CampaignError, match="multi_ball: missing"):
        advise(write_campaign(tmp_path), 0.02, ERRORS)


@pytest.mark.parametrize(("text", "share"), [("2%", 0.02), ("0.02", 0.02), ("2 %", 0.02)])
def test_an_error_is_a_share_or_a_percentage(text, share):
    assert share_of(text) == pytest.approx(share)


@pytest.mark.parametrize("text", ["2", "0", "-1%", "two", "80%"])
def test_an_error_that_is_none_is_refused(text):
    with pytest.raises(PredictionError, match="--error"):
        share_of(text)


def test_budgets_are_times():
    assert seconds_of("10min") == 600.0
    assert seconds_of("1.5 h") == 5400.0
    with pytest.raises(PredictionError, match="--budget"):
        seconds_of("10")


def test_the_command_writes_the_campaign_and_overwrites_none(tmp_path):
    to = tmp_path / "plan.toml"
    line = ["advise", str(REPOSITORY / "campaigns/slices.toml"), "--error", "2%", "--to", str(to)]
    done = CliRunner().invoke(app, line)
    assert done.exit_code == 0, done.output
    assert "chosen" in done.output and "slice of the physical mill" in done.output
    assert load_campaign(to).name == "advised"
    again = CliRunner().invoke(app, line)
    assert isinstance(again.exception, PredictionError) and "exists" in str(again.exception)


@pytest.mark.parametrize("policies", [["paper", "friction-matched"], ["friction-matched"]])
def test_a_plan_keeps_the_friction_exponent_of_its_policy(tmp_path, policies):
    changes = {"scaling__policies": policies, "scaling__friction_exponent": 1.2}
    charge = {"filling": 0.3, "rotation_angle_rad": 12.0, "step_s": 2e-4}
    file = write_campaign(tmp_path, single_ball=None, multi_ball=charge, **changes)
    file.write_text(advise(file, 0.02, ERRORS).text)
    (policy,) = load_campaign(file).parts[0].policies
    assert policy == policies[0]
    assert load_campaign(file).friction_exponent == (1.2 if policy != "paper" else 1.0)
