"""Claims of a campaign."""

import re
from dataclasses import replace

import pytest
from msgspec import structs

from millscale.analysis.checks import campaign_checks
from millscale.analysis.finished import Settled
from millscale.analysis.finished_campaign import load_campaign
from millscale.analysis.measures import COMMON_ANGLES
from synthetic_result import with_case, with_result


@pytest.fixture
def campaign(runs):
    return load_campaign(runs)


def checks_of(campaign, rows=None, fits=None, charges=None, missing=None):
    return campaign_checks(
        campaign.rows if rows is None else rows,
        campaign.fits if fits is None else fits,
        campaign.charges if charges is None else charges,
        missing or {},
    )


def with_common(fit, **changes):
    """A regression that differs in the common mill angles."""
    return replace(
        fit, fits=fit.fits | {COMMON_ANGLES: replace(fit.fits[COMMON_ANGLES], **changes)}
    )


def test_similar_mills_pass(campaign):
    checks = checks_of(campaign)
    assert len(checks) > 10
    # The made-up charges turn by 1 rad.
    short = {f"steady/{case.id}" for case in campaign.charges}
    assert {name for name, check in checks.items() if not check.passed} == short


def test_every_check_is_about_the_runs_or_the_law_and_has_a_remedy(campaign):
    checks = checks_of(campaign)
    of_law = {name for name, check in checks.items() if check.about == "law"}
    assert of_law == {name for name in checks if "constant-" in name}
    assert {check.about for check in checks.values()} == {"run", "law"}
    assert all(check.remedy for check in checks.values())
    assert checks[f"steady/{campaign.charges[0].id}"].case == campaign.charges[0].id


def test_missing_case_fails(campaign):
    checks = checks_of(campaign, missing={"sb-cg-paper-S1.000": "no series.csv yet"})
    assert checks["all_cases_finished"].passed is False


@pytest.mark.parametrize(
    ("change", "check"),
    [
        ({"off_parabola": 0.01}, "flight_is_a_parabola"),
        ({"energy_imbalance": 0.01}, "kinetic_gain_is_potential_loss"),
    ],
)
def test_one_bad_throw_fails(campaign, change, check):
    rows = list(campaign.rows)
    rows[4] = replace(rows[4], throw=replace(rows[4].throw, **change))
    assert checks_of(campaign, rows)[check].passed is False


def test_one_ball_that_is_not_thrown_fails(campaign):
    rows = list(campaign.rows)
    rows[4] = replace(rows[4], ball=with_result(rows[4].ball, problem="no throw"))
    assert checks_of(campaign, rows)["every_ball_is_thrown"].passed is False


def test_worst_deviation_of_the_better_policy_counts(campaign):
    worst = {"paper": 0.03, "corrected": -0.012, "offset-liner": 0.02}
    fits = [
        replace(
            with_common(fit, worst_relative_error=worst[fit.policy]),
            spread_deg=fit.spread_deg | {"detach_angle": {"corrected": 1.6}.get(fit.policy, 0.1)},
        )
        for fit in campaign.fits
    ]
    checks = checks_of(campaign, fits=fits)
    assert checks["worst_deviation/constant-speed/paper"].passed is True
    better = checks["worst_deviation/constant-speed/better"]
    assert (better.value, better.passed) == (0.012, True)
    assert "corrected" in better.text
    assert checks["detach_angle_spread/constant-speed/better"].passed is False
    assert checks["liner_off_angle_spread/constant-speed/better"].passed is True


def test_what_the_campaign_does_not_show_neither_passes_nor_fails(campaign):
    line = campaign.fits[0].fits[COMMON_ANGLES].line
    fits = [with_common(fit, line=replace(line, correlation=None)) for fit in campaign.fits]
    checks = checks_of(campaign, fits=fits)
    assert checks["linear_in_prediction/constant-gravity/paper"].passed is None


def test_a_slipping_charge_is_the_first_failure_and_an_unknown_slip_is_no_check(campaign):
    charge = campaign.charges[0]
    spoiled = with_result(charge, liner_slip=0.93, problem="lost", alternating_torque=1.0)
    checks = checks_of(campaign, rows=[], fits=[], charges=[spoiled])
    failed = [name for name, check in checks.items() if check.passed is False]
    assert failed[0] == f"liner_slip/{charge.id}"
    assert "does not lift" in checks[failed[0]].remedy
    unknown = with_result(charge, liner_slip=None)
    assert f"liner_slip/{charge.id}" not in checks_of(campaign, charges=[unknown])


def test_lost_balls_fail(campaign):
    spoiled = {"problem": "two balls fewer", "largest_overlap_over_radius": 0.2}
    charge = with_result(campaign.charges[0], **spoiled)
    checks = checks_of(campaign, charges=[charge])
    assert checks[f"balls_kept/{charge.id}"].passed is False
    assert checks[f"overlap/{charge.id}"].passed is False


def test_an_overlap_that_impacts_explain_asks_for_stiffer_balls_and_not_for_a_shorter_step(
    campaign,
):
    charge = campaign.charges[0]
    time = structs.replace(
        charge.case.time, impact_speed_m_s=6.65, collision_time_s=2.94 * 0.159 / 6.65
    )
    ball = structs.replace(charge.case.ball, radius_m=1.0)
    soft = with_case(charge, time=time, ball=ball)  # impacts overlap by 0.159

    def check(largest, at_rest=0.04):
        one = with_result(soft, largest_overlap_over_radius=largest)
        vars(one)["settled"] = Settled(largest_overlap_over_radius=at_rest)
        return checks_of(campaign, charges=[one])[f"overlap/{charge.id}"]

    modulus = charge.case.material.youngs_modulus_pa
    found = check(0.108)
    assert found.passed is False
    assert "impacts at 6.65 m/s compress balls as soft as these by 0.16" in found.text
    least = float(re.search(r"youngs_modulus_pa of (\S+),", found.remedy)[1])
    assert modulus * 1.08**2.5 <= least < 1.1 * modulus * 1.08**2.5
    assert found.remedy.endswith("a shorter step does not")
    assert check(0.2).remedy.startswith("reduce step_s")
    assert check(0.2, at_rest=0.15).remedy.startswith("increase settle_s")
    assert "impacts" not in check(0.09).text


@pytest.mark.parametrize(
    ("section", "change", "check"),
    [
        ("torque_balance", {"difference": -0.002}, "torque_balance"),
        ("", {"alternating_torque": 0.02}, "alternating_torque"),
        ("", {"liner_slip": 0.51}, "liner_slip"),
        ("steady", {"reasons": ["it drifts"]}, "steady"),
    ],
)
def test_a_torque_that_cannot_be_trusted_fails(campaign, section, change, check):
    charge = campaign.charges[0]
    steady = charge.finished.result["steady"] | {"reasons": []}
    sound = with_result(charge, steady=steady)
    name = f"{check}/{charge.id}"
    assert checks_of(campaign, charges=[sound])[name].passed
    result = sound.finished.result
    spoiled = with_result(sound, **({section: result[section] | change} if section else change))
    assert checks_of(campaign, charges=[spoiled])[name].passed is False
