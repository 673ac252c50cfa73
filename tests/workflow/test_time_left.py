"""The time left for a campaign."""

from dataclasses import dataclass
from types import SimpleNamespace

import pytest

from millscale.engine.machine import Allocation
from millscale.workflow.predictions import time_left


@dataclass
class Status:
    """Return the part of CaseStatus that these tests use, for a case of 1,000 steps."""

    id: str
    state: str = "waiting"
    kind: str = "single-ball"
    step: int = 0
    steps: int = 1000
    balls: int = 1
    particle_steps_per_s: float | None = None


# case.json expects 50 particle-steps/s.
CASES = {
    name: SimpleNamespace(predicted=SimpleNamespace(particle_steps=1000, wall_time_s=20.0))
    for name in "abcd"
}


def left(*statuses, ranks=2, jobs=2, cores=2):
    widths = {x.id: ranks if x.kind == "multi-ball" else 1 for x in statuses}
    return time_left(statuses, CASES, Allocation(widths, jobs, cores))


def test_a_waiting_case_takes_its_predicted_time():
    assert left(Status("a")) == pytest.approx(20.0)


def test_a_running_case_continues_at_its_rate():
    running = Status("a", "running", step=500, particle_steps_per_s=10.0)
    assert left(running) == pytest.approx(50.0)


def test_waiting_cases_run_at_the_mean_rate_of_the_running_cases():
    running = Status("a", "running", step=1000, particle_steps_per_s=10.0)
    assert left(running, Status("b"), jobs=1) == pytest.approx(100.0)


def test_single_balls_share_the_jobs_but_no_case_is_split():
    assert left(*(Status(x) for x in "abcd")) == pytest.approx(40.0)
    assert left(Status("a"), jobs=2) == pytest.approx(20.0)


def test_charges_that_take_all_cores_follow_each_other_and_the_single_balls():
    charges = [Status(x, kind="multi-ball") for x in "bc"]
    assert left(*charges) == pytest.approx(40.0)
    assert left(Status("a"), *charges) == pytest.approx(60.0)


def test_finished_and_failed_cases_take_no_time():
    assert left(Status("a", "done"), Status("b", "failed")) == 0.0
