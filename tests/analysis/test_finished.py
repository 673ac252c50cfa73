"""Finished cases: their place in tables, files that are damaged."""

import pytest

from millscale.analysis.finished import Charge, damage
from millscale.analysis.finished_campaign import load_campaign
from millscale.campaign.keys import POLICIES
from millscale.runs.case_folder import FinishedCase
from synthetic_result import with_case, with_result


@pytest.fixture
def charge(runs):
    return load_campaign(runs).charges[0]


def test_places_are_by_scheme_policy_and_s_whatever_the_policy(charge):
    names = [*POLICIES, "another", "strange"]
    policies = [with_case(charge, policy=name) for name in names]
    assert sorted(policies[::-1], key=lambda one: one.place) == policies
    small, large = with_case(charge, S=2.0), with_case(charge, S=10.0)
    assert small.place < large.place < with_case(charge, scheme="constant-speed").place


def test_a_result_that_is_not_one_is_damage_with_a_cause(charge):
    assert damage(charge) == ""
    for spoiled in ({"pitches": "many"}, {"mean": None}, {"steady": {"is_steady": True}}):
        cause = damage(with_result(charge, **spoiled))
        assert cause.startswith("result.json: ") and next(iter(spoiled)) in cause
        assert f"--only {charge.id}" in cause


def test_a_timing_that_is_not_one_is_damage_with_a_cause(charge):
    timing = charge.finished.timing | {"ranks": "two"}
    finished = FinishedCase(charge.folder, charge.case, charge.finished.result, timing)
    assert damage(Charge(finished, "")).startswith("timing.json: ranks: got 'two'")


def test_a_bed_without_a_record_has_no_numbers(charge):
    assert charge.settled.bulk_fraction is charge.settled.wall_time_s is None


def test_the_label_of_a_mill_states_its_policy_and_exponent(charge):
    matched = with_case(charge, S=2.6, policy="friction-matched")
    assert matched.label == "S = 2.6, friction-matched"
    assert with_case(matched, friction_exponent=1.2).label == "S = 2.6, friction-matched, k = 1.2"
