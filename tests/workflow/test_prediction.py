"""Predicted and measured times of runs."""

import json

import pytest

from millscale.cases.cost import Rates, run_time
from millscale.engine.machine import Allocation
from millscale.workflow.predictions import error_line, errors, record_predictions
from paper_campaign import cases


@pytest.fixture
def two(tmp_path):
    """A runs folder in which two cases are predicted, and the cases."""
    some = cases(tmp_path)[:2]
    record_predictions(tmp_path, some, Allocation({x.id: 1 for x in some}, 1, 1), Rates())
    return tmp_path, some


def took(runs, case, seconds, steps=None):
    folder = runs / "cases" / case.id
    folder.mkdir(parents=True)
    timing = {"wall_time_s": seconds, "steps": steps or case.time.steps}
    (folder / "timing.json").write_text(json.dumps(timing))


def test_nothing_is_reported_before_a_case_is_done(two):
    assert error_line(two[0]) == ""
    assert error_line(two[0] / "cases") == ""


def test_predictions_are_compared_with_the_measured_times(two):
    runs, (one, other) = two
    expected = run_time(one, one.time.steps, 1)
    took(runs, one, 2.0 * expected)
    assert errors(runs)[one.id] == pytest.approx((expected, 2.0 * expected))
    assert error_line(runs).startswith("rotation of 1 case: ")
    assert error_line(runs).endswith(" measured (2 times)")
    as_expected = run_time(other, other.time.steps, 1)
    took(runs, other, as_expected)
    line = error_line(runs)
    ratio = (2.0 * expected + as_expected) / (expected + as_expected)
    assert "rotation of 2 cases" in line and f"measured ({ratio:.2g} times); farthest" in line
    assert f"farthest {one.id}: " in line and line.endswith("(2 times)")


def test_a_resumed_run_counts_in_proportion_to_its_steps(two):
    runs, (one, _) = two
    took(runs, one, 3.0, steps=one.time.steps // 2)
    assert errors(runs)[one.id][1] == pytest.approx(6.0, rel=1e-4)


def test_predictions_of_earlier_runs_stay(two):
    runs, (one, other) = two
    before = json.loads((runs / "predicted.json").read_text())
    record_predictions(runs, [one], Allocation({one.id: 1}, 1, 1), Rates({"single-ball mesh": 2}))
    after = json.loads((runs / "predicted.json").read_text())
    assert after[other.id] == before[other.id]
