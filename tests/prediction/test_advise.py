"""Plans for a wanted error: the cheapest design that reaches it, and its campaign file."""

import contextlib
import itertools
import math
from dataclasses import replace

import pytest
from typer.testing import CliRunner

from millscale.campaign.build import load_campaign
from millscale.cases.case import cases_of
from millscale.cases.cost import wall_time
from millscale.cli.advise import seconds_of, share_of
from millscale.cli.main import app
from millscale.errors import CampaignError, PredictionError
from millscale.prediction.advise import LEAST_SPREAD, RATIOS, advise, names_of
from millscale.prediction.error_model import (
    ErrorModel,
    ObservableError,
    built_in,
    expected_half_width,
    learn,
    nearest_model,
    planned_noise,
    read_models,
    write_model,
)
from millscale.prediction.extrapolation import ExtrapolationError, scale_function
from millscale.prediction.planned import PlannedMills, PlannedRun, RunSize
from millscale.prediction.predict import predict
from millscale.prediction.table import advice_lines
from paper_campaign import CAMPAIGNS, REPOSITORY, write_campaign
from synthetic_mills import EXPONENT, SEEDS, SLOPE, TORQUE, charge_case, write_mills

SLICES = CAMPAIGNS / "slices.toml"
# A twentieth at S = 2.6, as the power of the paper's mill.
POWER = ObservableError("power", 0.05 / (2.0 * (math.sqrt(2.6) - 1.0)), 2e-3, 20.0)
TOE = ObservableError("toe_angle_rad", -0.08, 2e-3, 20.0)
SOLID = ObservableError("solid_fraction", -0.04, 8e-4, 4.0)
CONTOUR = ObservableError("contour", 0.033, 2e-3, 4.0)
BALLS = 9000.0
ERRORS = ErrorModel(
    0.02 / 3.9,
    "constant-gravity",
    "paper",
    BALLS,
    5.0,
    (POWER, TOE, CONTOUR, SOLID),
    {"command": "a test", "date": "today"},
)


def plan(error, observables=("power",), **changes):
    return advise(SLICES, error, (ERRORS,), observables, **changes)


def run(S, balls=BALLS, window_rad=5.0):
    return PlannedRun(S, balls, window_rad, 20.0, 100.0)


def test_a_looser_error_costs_less():
    costs = [plan(error).chosen.cost_s for error in (0.01, 0.02, 0.05)]
    assert costs == sorted(costs, reverse=True)
    assert costs[0] > 2.0 * costs[-1]


def test_the_chosen_design_is_the_cheapest_that_reaches_the_error_with_an_interval():
    found = plan(0.02)
    assert found.met and found.chosen.worst <= 0.02 and found.chosen.has_interval
    for design in found.cheapest:
        assert (
            not design.has_interval or design.worst > 0.02 or design.cost_s >= found.chosen.cost_s
        )
    names = {design.name for design in found.cheapest}
    assert names == {
        "slice of the physical mill", "one scaled mill", "two scaled mills, extrapolated",
    }  # fmt: skip


def test_the_search_finds_the_cheapest_of_all_designs():
    """Trying every pair, size and number of seeds, without the shortcuts of the search."""
    mills, error = PlannedMills(SLICES), 0.02
    known = []
    for near, far in itertools.combinations(RATIOS, 2):
        if far < LEAST_SPREAD * near:
            continue
        for longer, more, seeds in itertools.product((1.0, 2.0, 4.0), (0.0, 5.0, 15.0), (1, 2)):
            size = RunSize(4.0 * longer, 12.0 + more)
            runs = [mills.run(near, size), *[mills.run(far, size)] * seeds]
            with contextlib.suppress(ExtrapolationError):
                if None not in runs and expected_half_width(POWER, ERRORS, runs, 0.95) <= error:
                    known.append(sum(x.cost_s for x in runs))
    two = next(x for x in plan(error).cheapest if x.name.startswith("two"))
    assert two.cost_s == pytest.approx(min(known), rel=1e-12)


def test_extrapolation_is_cheaper_than_one_scaled_mill_of_the_same_error():
    by_name = {design.name: design for design in plan(0.015).cheapest}
    two = by_name["two scaled mills, extrapolated"]
    one = by_name["one scaled mill"]
    assert two.worst <= 0.015
    assert one.worst > 0.015 or one.cost_s > two.cost_s


def test_the_campaign_of_a_plan_has_its_mills_filled_alike(tmp_path):
    found = plan(0.02, ("solid_fraction",))
    path = tmp_path / "plan.toml"
    path.write_text(found.text)
    cases = cases_of(load_campaign(path))
    planned = {(S, seed) for S, seeds in found.chosen.mills for seed in range(1, seeds + 1)}
    assert {(case.S, case.seed) for case in cases} == planned
    assert len(cases) > 2  # its noise comes from seeds
    filling = [case.ball.count * case.S**2 / case.mill.simulated_length_m for case in cases]
    assert max(filling) / min(filling) == pytest.approx(1.0, abs=2e-3)
    length = found.chosen.size.diameters * 0.04
    assert [case.mill.simulated_length_m for case in cases] == [pytest.approx(length)] * len(cases)
    rotation = found.chosen.size.rotation_rad
    assert {case.time.rotation_angle_rad for case in cases} == {rotation}
    assert {case.time.step_s for case in cases} == {2e-4}


def test_the_cost_of_a_planned_run_is_that_of_its_case(tmp_path):
    """At another rotation and length than the search begins with."""
    mills, size = PlannedMills(SLICES), RunSize(8.0, 17.0)
    path = tmp_path / "plan.toml"
    path.write_text(mills.campaign_text([(2.0, [1])], size, "one", ""))
    (case,) = cases_of(load_campaign(path))
    planned = mills.run(2.0, size)
    assert planned.balls == case.ball.count
    assert planned.cost_s == pytest.approx(wall_time(case, 1), rel=1e-3)
    assert planned.pitches == pytest.approx(10.0 * 25 / (2.0 * math.pi))


def test_all_runs_have_the_step_of_the_physical_mill(tmp_path):
    """The advised step of each mill alone would differ."""
    text = SLICES.read_text().replace("step_s = 2e-4", "")
    file = tmp_path / "campaign.toml"
    file.write_text(text)
    mills = PlannedMills(file)
    steps = set()
    for S in (1.0, 2.0, 3.0):
        path = tmp_path / f"{S}.toml"
        path.write_text(mills.campaign_text([(S, [1])], RunSize(), "one", ""))
        steps |= {case.time.step_s for case in cases_of(load_campaign(path))}
    assert len(steps) == 1
    assert not mills.is_step_given and mills.step_s in steps


def test_seeds_that_no_campaign_holds_are_refused():
    with pytest.raises(ValueError, match="no campaign holds"):
        PlannedMills(SLICES).campaign_text([(1.5, [2]), (2.6, [1, 3])], RunSize(), "x", "")


def test_a_budget_that_is_too_small_says_what_it_takes():
    found = plan(0.002, budget_s=180.0)
    assert not found.met
    assert found.chosen.cost_s <= 180.0
    assert found.chosen.worst > 0.002
    first = next(advice_lines(found, None))
    assert first.startswith("not reached in 3 min 0 s: the chosen runs give")
    assert "it takes" in first


def test_a_budget_for_no_interval_gives_the_cheapest_runs_that_have_one():
    found = plan(0.02, budget_s=5.0)
    assert not found.met
    assert found.chosen.has_interval and found.chosen.cost_s > 5.0
    assert found.chosen.cost_s < plan(0.02, budget_s=600.0).chosen.cost_s


def test_what_no_design_reaches_is_said():
    found = plan(1e-4)
    assert not found.met
    assert "no design that was compared reaches it" in next(advice_lines(found, None))


def test_each_choice_has_a_reason():
    shown = "\n".join(advice_lines(plan(0.02), None))
    for choice in ("S = ", "seed", "slice of 4", "rotation of", "time step of 0.0002", "precision"):
        assert f"  {choice}" in shown or choice in shown
    assert "given in the campaign" in shown


def test_mixed_precision_is_chosen_where_the_campaign_states_none(tmp_path):
    file = tmp_path / "campaign.toml"
    file.write_text(SLICES.read_text().replace('precision = "mixed"', ""))
    assert PlannedMills(file).is_precision_chosen
    assert PlannedMills(file).case.deck.precision == "mixed"
    assert not PlannedMills(SLICES).is_precision_chosen


def test_mills_beyond_the_range_of_the_law_are_not_planned(tmp_path):
    """3.9 m over 0.08 m is 48.75, which must be 30 at least."""
    file = tmp_path / "campaign.toml"
    text = SLICES.read_text().replace("radius_m = 0.020", "radius_m = 0.080")
    text = text.replace("length_m = 1.0", "length_m = 4.0")
    file.write_text(text.replace("count = [231461, 47446, 13169]", "filling = 0.3"))
    mills = PlannedMills(file)
    assert mills.run(1.6, RunSize()) is not None
    assert mills.run(1.7, RunSize()) is None


def test_larger_balls_make_larger_errors():
    """The error is a power of S a / R, so twice the a / R has 2^p times the slope."""
    moved = ERRORS.of_mill(0.04 / 3.9)
    power = moved.observables[0]
    assert power.slope == pytest.approx(math.sqrt(2.0) * POWER.slope)
    mills = [run(1.7), run(2.6)]
    wide = expected_half_width(power, moved, mills, 0.95)
    assert wide > expected_half_width(POWER, ERRORS, mills, 0.95)


def test_noise_falls_with_balls_and_rotation():
    usual = planned_noise(POWER, ERRORS, [run(1.7), run(2.6)])
    assert usual.deviation == pytest.approx(POWER.deviation)
    longer = planned_noise(POWER, ERRORS, [run(1.7, 4.0 * BALLS), run(2.6, window_rad=20.0)])
    assert longer.deviation == pytest.approx(0.5 * POWER.deviation)


def test_single_seeds_are_planned_with_the_noise_of_their_lifter_pitches():
    """As a prediction finds it; with two seeds more it comes from the seeds."""
    power = replace(POWER, pitch_deviation=3.0 * POWER.deviation)
    single = planned_noise(power, ERRORS, [run(1.7), run(2.6)])
    assert single.deviation == pytest.approx(3.0 * POWER.deviation)
    seeds = planned_noise(power, ERRORS, [run(1.7), run(2.6), run(2.6), run(2.6)])
    assert seeds.deviation == pytest.approx(POWER.deviation)
    wide, narrow = (
        expected_half_width(x, ERRORS, [run(1.7), run(2.6)], 0.95) for x in (power, POWER)
    )
    assert wide > narrow


def test_the_nearest_mill_that_is_known_gives_the_errors():
    """Of the policy, then the scheme, then a / R."""
    near, other = replace(ERRORS, ball_over_mill=0.01), replace(ERRORS, policy="friction-matched")
    known = (ERRORS, near, other)
    chosen = nearest_model(known, 0.009, "constant-gravity", "paper")
    assert chosen == near.of_mill(0.009)
    chosen = nearest_model(known, 0.009, "constant-gravity", "friction-matched")
    assert chosen == other.of_mill(0.009)


def test_errors_of_several_mills_share_a_file(tmp_path):
    path = tmp_path / "errors.json"
    other = replace(ERRORS, ball_over_mill=0.01)
    write_model(path, other)
    write_model(path, ERRORS)
    again = replace(ERRORS, balls=1.0)
    write_model(path, again)
    assert read_models(path) == (again, other)


def test_errors_are_learnt_from_finished_runs(tmp_path):
    cases = [charge_case(S, seed) for S in (1.0, 1.696, 2.6) for seed in SEEDS]
    model = learn(predict([write_mills(tmp_path, *cases)]), {})
    torque = next(row for row in model.observables if row.name == "torque")
    far = SLOPE * float(scale_function(2.6, EXPONENT)) / TORQUE
    assert torque.bias(2.6) == pytest.approx(far, rel=0.02)
    assert torque.deviation == pytest.approx(1e-3 * math.sqrt(2.0), rel=0.1)
    # The made-up torque is nearly the same in every pitch.
    assert 0.0 <= torque.pitch_deviation < 0.1 * torque.deviation
    assert (model.scheme, model.policy) == ("constant-gravity", "paper")
    counts = [round(20_000 / S**3) for S in (1.0, 1.696, 2.6)]
    assert model.balls == pytest.approx(3.0 / sum(1.0 / n for n in counts))


def test_the_built_in_errors_are_those_of_a_command():
    for model in built_in():
        assert {"command", "commit", "machine", "date"} <= model.origin.keys()
        assert {"power", "contour"} <= {row.name for row in model.observables}


def test_what_cannot_be_planned_is_refused(tmp_path):
    with pytest.raises(PredictionError, match='observable: got "powr", nearest is "power"'):
        plan(0.02, ["powr"])
    with pytest.raises(CampaignError, match="multi_ball: missing"):
        advise(write_campaign(tmp_path), 0.02, (ERRORS,))


def test_observables_are_named_in_short_and_separated_by_commas():
    assert names_of(["power,toe", "contour"], ERRORS) == ["power", "toe_angle_rad", "contour"]
    assert names_of(["toe_angle_rad, toe"], ERRORS) == ["toe_angle_rad"]
    assert names_of([], ERRORS) == ["power", "toe_angle_rad", "solid_fraction"]


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


def test_friction_matched_mills_are_not_planned(tmp_path):
    """Their intervals do not hold; a policy that comes before is planned, without the exponent."""

    def campaign(*policies):
        changes = {"scaling__policies": list(policies), "scaling__friction_exponent": 1.2}
        charge = {"filling": 0.3, "rotation_angle_rad": 12.0, "step_s": 2e-4}
        return write_campaign(tmp_path, single_ball=None, multi_ball=charge, **changes)

    with pytest.raises(CampaignError, match=r"friction-matched comes first.* such as paper"):
        advise(campaign("friction-matched"), 0.02, (ERRORS,))
    file = campaign("paper", "friction-matched")
    file.write_text(advise(file, 0.02, (ERRORS,)).text)
    assert load_campaign(file).parts[0].policies == ("paper",)
    assert load_campaign(file).friction_exponent == 1.0
