"""Progress of a run: time left, counts, the bar, and the table beside it."""

import io
from dataclasses import dataclass
from itertools import pairwise
from types import SimpleNamespace

import pytest
from rich.console import Console

from millscale.engine.machine import Allocation
from millscale.workflow.display import status_table, status_view
from millscale.workflow.run_progress import (
    LARGEST_DELAY,
    SMOOTHING_S,
    Bar,
    RunProgress,
    SmoothedTimeLeft,
    percent,
)
from millscale.workflow.status import CaseStatus, share_done


def status(name, state="waiting", step=0, steps=1000, **more):
    content = dict.fromkeys(CaseStatus.__dataclass_fields__)
    content |= {"id": name, "kind": "multi-ball", "state": state, "stage": "", "balls": 10}
    content |= {"step": step, "steps": steps, "percent": 100.0 * step / steps}
    content |= {"simulated_s": 1.0, "predicted_wall_time_s": 100.0, "failure": "", "problem": ""}
    content |= {"advice": "", "log": "", "by_hand": ()}
    if state == "running":
        content |= {"silent_s": 0.0, "particle_steps_per_s": 100.0, "time_left_s": 50.0}
    return CaseStatus(**content | more)


@dataclass
class Clock:
    now: float = 0.0

    def __call__(self):
        return self.now


CASES = [
    SimpleNamespace(id=x, predicted=SimpleNamespace(particle_steps=10_000, wall_time_s=100.0))
    for x in "abcd"
]


def progress(clock=None):
    return RunProgress(CASES, Allocation(dict.fromkeys("abcd", 1), 2, 2), clock or Clock())


def console(width=80, height=25):
    return Console(
        file=io.StringIO(), width=width, height=height, force_terminal=True, color_system=None
    )


def printed(shown, on):
    on.print(shown)
    return on.file.getvalue()


def test_a_steady_estimate_counts_down():
    left = SmoothedTimeLeft()
    for now in range(60):
        assert left(100.0 - now, float(now)) == pytest.approx(100.0 - now)


def test_an_estimate_that_jumps_back_and_forth_hardly_moves_the_time_left():
    left = SmoothedTimeLeft()
    shown = [left(200.0 - now + (40.0 if now % 2 else 0.0), float(now)) for now in range(1, 60)]
    steps = [one - other for one, other in pairwise(shown)]
    assert max(map(abs, steps)) < 1.0 + 40.0 / SMOOTHING_S


def test_a_lasting_change_is_followed():
    left = SmoothedTimeLeft()
    left(100.0, 0.0)
    for now in range(1, 91):
        shown = left(300.0 - now, float(now))
    assert shown == pytest.approx(210.0, abs=200.0 * 2.0 ** (-90.0 / SMOOTHING_S))


def test_of_a_run_that_stands_still_the_time_left_stays():
    left = SmoothedTimeLeft()
    shown = [left(8.0, float(now)) for now in range(200)]
    assert min(shown) > (1.0 - LARGEST_DELAY) * 8.0 - 0.5


def test_time_left_is_never_negative():
    left = SmoothedTimeLeft()
    left(1.0, 0.0)
    assert left(0.0, 100.0) == 0.0


def test_the_share_is_of_the_predicted_time():
    """One step of a charge costs as much as many of a single ball."""
    done = status("a", "done", 1000, predicted_wall_time_s=299.8)
    assert share_done([done, status("b", predicted_wall_time_s=99.8)]) == pytest.approx(0.75)
    half = status("b", "running", 500, predicted_wall_time_s=99.8)
    assert share_done([done, half]) == pytest.approx(0.875, abs=1e-3)


def test_only_finished_cases_are_all_of_it():
    almost = status("a", "running", 1000)
    assert share_done([almost]) == pytest.approx(0.99) and percent(share_done([almost])) == 99
    assert share_done([status("a", "done", 1000)]) == 1.0 and percent(1.0) == 100
    assert percent(0.9999) == 99


def test_a_run_is_starting_until_a_case_runs_or_ends():
    found = progress()
    found.update([status("a", "done", 1000), status("b"), status("c")])
    assert found.counts == "starting, 1 of 3 cases done"
    found.update([status("a", "done", 1000), status("b", "running"), status("c", "failed")])
    assert found.counts == "1 of 3 cases done, 1 running, 1 failed"
    # Between two jobs no case runs for a moment.
    found.update([status("a", "done", 1000), status("b", "done", 1000), status("c", "failed")])
    assert found.counts == "2 of 3 cases done, 1 failed"


def test_one_case_is_no_plural_and_a_finished_run_has_no_time_left():
    found = progress()
    found.update([status("a", "running", 500)])
    assert found.line() == "0 of 1 case done, 1 running, 50 %, about 50 s left"
    found.update([status("a", "done", 1000)])
    assert found.line() == "1 of 1 case done, 100 %"


def test_the_last_analysis_is_not_predicted():
    found = progress()
    found.update([status("a", "running", 1000, time_left_s=0.0)])
    assert found.line() == "0 of 1 case done, 1 running, 99 %, ending"


@pytest.mark.parametrize("width", [60, 80, 140])
def test_the_bar_fills_the_line_and_shows_share_and_time_left(width):
    found = progress()
    found.update([status("a", "running", 500), status("b")])
    text = printed(Bar(found).update(), console(width)).rstrip("\n")
    assert len(text) == width and "━" in text
    assert text.startswith("0 of 2 cases done, 1 running") and " 25% " in text
    assert text.rstrip().endswith("left")


def test_running_cases_come_first_and_the_view_fits_the_screen(tmp_path):
    some = [status(f"done-{i}", "done", 1000) for i in range(30)]
    some += [status("failed", "failed", problem="lost ball", advice="less", log="log.rotate")]
    some += [status("waiting"), status("runs", "running", 10)]
    lines = printed(status_view(tmp_path, some, console()), console()).splitlines()
    assert len(lines) <= 22
    assert [line.split()[0] for line in lines[1:5]] == ["runs", "failed", "waiting", "done-0"]
    assert "lost ball" in lines[-2] and lines[-1].startswith("  to do:")


def test_an_engine_without_a_step_yet_is_starting():
    on = console(140)
    rows = [status("a", "running", particle_steps_per_s=None), status("b", "running", 5)]
    rows += [status("c", "running", silent_s=None, particle_steps_per_s=None)]
    lines = printed(status_table(rows, on), on).splitlines()
    assert [line.split()[1] for line in lines[1:]] == ["starting", "running", "running"]


@pytest.mark.parametrize(
    ("width", "absent"),
    [(140, ()), (90, ("particle-steps/s",)), (60, ("particle-steps/s", "simulated", "steps"))],
)
def test_a_narrow_terminal_shows_fewer_columns_and_cuts_none(width, absent):
    on = console(width)
    rows = [status("mb-cg-paper-S1.000-fixed-seed1", "running", 123_456, 7_654_321)]
    text = printed(status_table(rows, on), on)
    heading = text.splitlines()[0].split()
    names = {"case", "state", "stage", "steps", "%", "simulated", "particle-steps/s", "left"}
    assert names - set(heading) == set(absent)
    assert "…" not in text and len(text.splitlines()) == 2
    assert set(absent) <= names
