"""The first screen of a report: the physical mill in its own units, and how far to trust it."""

import json
import math
import shutil

import pytest

from millscale.analysis.charge.comparison import compare_charges
from millscale.analysis.finished_campaign import load_campaign
from millscale.power_models import MODELS, models_for
from millscale.report import overview as first_screen
from millscale.report.overview import BAD, GOOD, LOOK, Predicted, nearest, overview, physical_rows
from synthetic_result import with_case, with_result


@pytest.fixture(scope="module")
def campaign(runs):
    return load_campaign(runs)


def estimate_of(row, name):
    names = [quantity.label for quantity in first_screen.QUANTITIES]
    return row.estimates[names.index(name)]


def test_power_of_the_physical_mill_is_its_scale_times_the_dimensionless_power(campaign):
    """M g R omega of the full mill, written out from case.json; and by the factors of the law."""
    rows = physical_rows(campaign.comparison)
    assert len(rows) == 2  # both schemes
    for row in rows:
        charge = row.mill.first
        case, mill = charge.case, charge.case.physical
        balls = case.ball.count * case.S**2 * mill.length_m / case.mill.simulated_length_m
        scale = balls * case.ball.mass_kg * mill.gravity_m_s2 * mill.radius_m * mill.omega_rad_s
        expected = scale * charge.result.dimensionless["power"]
        found = estimate_of(row, "power")
        assert 1e3 * found.value == pytest.approx(expected, rel=1e-12)
        factor = case.factors.energy / case.factors.time * case.ball.count / balls
        assert 1e3 * found.value == pytest.approx(
            charge.result.mean["power_W"] / factor, rel=2e-3
        )  # the policy paper leaves the ball radius out of the speed
        per_tonne = estimate_of(row, "power per tonne of balls")
        assert per_tonne.value == pytest.approx(expected / (balls * case.ball.mass_kg))
        torque = estimate_of(row, "torque")
        assert torque.value * mill.omega_rad_s == pytest.approx(found.value)


def test_published_models_stand_beside_the_answer(campaign):
    screen = overview(campaign)
    assert screen.models == models_for(nearest(screen.rows).mill.first.case)
    assert [model.name for model in screen.models] == [model.name for model in MODELS]


def with_power(charge, seed, power):
    changed = with_case(charge, seed=seed)
    numbers = charge.finished.result["dimensionless"] | {"power": power}
    return with_result(changed, dimensionless=numbers)


def test_the_interval_is_that_of_the_seeds(campaign):
    charge = campaign.charges[0]
    powers = (0.36, 0.37, 0.40)
    seeds = [with_power(charge, i, power) for i, power in enumerate(powers)]
    (row,) = physical_rows(compare_charges(seeds))
    found = estimate_of(row, "power")
    scale = 1e-3 * row.physical.power_scale
    mean = sum(powers) / 3
    spread = math.sqrt(sum((x - mean) ** 2 for x in powers) / 2)
    assert found.value == pytest.approx(scale * mean)
    # Student's factor of two degrees of freedom, 95 %.
    assert found.half_width == pytest.approx(scale * 4.302653 * spread / math.sqrt(3), rel=1e-6)
    assert found.source == "3 seeds"


def test_a_prediction_takes_the_place_of_one_scaled_mill(campaign):
    screen = overview(campaign, [Predicted("power", 1234.5, 67.0)])
    power = next(x for x in screen.answers if x.label == "power")
    assert (power.estimate.text, power.estimate.error_text) == ("1,234", "± 67")
    assert "extrapolated to S = 1" in screen.source


def trust_of(campaign, charges):
    changed = first_screen.Campaign(campaign.runs, campaign.about, campaign.single, charges)
    return {item.question: item for item in overview(changed).trust}


def test_what_is_not_to_be_trusted_says_what_to_do(campaign):
    charge = campaign.charges[0]
    steady = {"is_steady": True, "reasons": []}
    sound = with_result(charge, steady=charge.finished.result["steady"] | steady)
    trust = trust_of(campaign, [sound])
    assert trust["Steady?"].state == GOOD and not trust["Steady?"].remedy
    assert trust["Seeds?"].state == LOOK and "seeds = " in trust["Seeds?"].remedy
    assert "ledger = true" in trust["Energy closed?"].remedy
    drifting = steady | {"is_steady": False, "reasons": ["it drifts"]}
    moved = with_result(charge, steady=charge.finished.result["steady"] | drifting)
    found = trust_of(campaign, [moved])["Steady?"]
    assert (found.state, found.remedy) == (BAD, "increase rotation_angle_rad")
    assert "it drifts" in found.found
    pressed = with_result(sound, largest_overlap_over_radius=0.2)
    found = trust_of(campaign, [pressed])["Overlap?"]
    assert found.state == BAD and "0.200" in found.found and "youngs_modulus_pa" in found.remedy
    assert trust_of(campaign, [with_result(sound, alternating_torque=0.1)])["Step?"].state == BAD
    for item in trust.values():
        assert item.state == GOOD or item.remedy


def test_a_charge_that_slips_is_said_before_the_answers(campaign):
    charge = campaign.charges[0]
    trust = trust_of(campaign, [charge])
    assert next(iter(trust)) == "Lifts?" and trust["Lifts?"].state == GOOD
    assert overview(campaign).slipping == ""
    slips = with_result(charge, liner_slip=0.91)
    found = trust_of(campaign, [slips])["Lifts?"]
    assert found.state == BAD and "91 %" in found.found and "friction" in found.remedy
    both = first_screen.Campaign(campaign.runs, campaign.about, campaign.single, [charge, slips])
    text = overview(both).slipping
    assert text.startswith("In 1 of 2 charges") and f"{charge.id}, 91 %" in text
    assert found.remedy in text
    unknown = trust_of(campaign, [with_result(charge, liner_slip=None)])["Lifts?"]
    assert unknown.state == first_screen.UNKNOWN and unknown.remedy


def test_the_steady_mill_nearest_to_the_physical_one_is_shown_first(throws):
    rows = physical_rows(load_campaign(throws).comparison)
    assert min(row.mill.name.S for row in rows) == first_screen.nearest(rows).mill.name.S
    assert any(estimate_of(row, "toe").value for row in rows)


def test_a_campaign_of_single_balls_has_the_mill_and_no_answer(runs, tmp_path):
    copy = shutil.copytree(runs, tmp_path / "runs", ignore=shutil.ignore_patterns("mb-*"))
    ids = sorted(path.name for path in (copy / "cases").iterdir())
    (copy / "campaign.json").write_text(json.dumps({"cases": ids}))
    screen = overview(load_campaign(copy))
    assert ("inner diameter", "7.8 m") in screen.facts
    assert screen.answers == [] and screen.trust == []
