"""`millscale run`: the stages that run, and the files that stay."""

import json
import shlex
import signal
import subprocess
import sys
import time

import pytest

from millscale.runs.layout import STAGES
from millscale.workflow import run_command
from small_campaign import CHARGE, SINGLE_BALLS, TEXT


def products(kind):
    return {product for stage in STAGES[kind] for product in stage.products}


def test_a_run_leaves_every_product_and_no_part(finished):
    for case_id, kind in ((SINGLE_BALLS[0], "single-ball"), (CHARGE, "multi-ball")):
        names = {path.name for path in finished.case(case_id).iterdir()}
        assert products(kind) <= names
        assert not [name for name in names if name.endswith(".part")]
    assert (finished.case(CHARGE) / "dump" / "charge.000000000.liggghts").exists()


def test_timing_holds_steps_balls_rate_and_shares(finished):
    timing = json.loads((finished.case(SINGLE_BALLS[0]) / "timing.json").read_text())
    assert timing["balls"] == 1 and timing["steps"] == 6000
    assert timing["particle_steps_per_s_core"] == pytest.approx(6000 / 2.0)
    assert timing["share"]["pair"] == 0.5
    assert sum(timing["share"].values()) == pytest.approx(1.0)
    assert timing["hardware"]["cores"] >= 1


def test_a_second_run_touches_nothing(finished):
    before = finished.dates()
    assert finished("run").returncode == 0
    assert finished.dates() == before


def test_a_missing_product_runs_its_stage_and_the_later_ones_again(finished):
    before = finished.dates()
    (finished.case(SINGLE_BALLS[0]) / "timing.json").unlink()
    assert finished("run").returncode == 0
    after = finished.dates()
    changed = {path for path in after if after[path] != before[path]}
    assert changed == {
        f"cases/{SINGLE_BALLS[0]}/{name}" for name in ("series.csv", "timing.json", "result.json")
    }


def test_a_missing_product_of_an_early_stage_is_made_again(finished):
    product = finished.case(CHARGE) / "liner.vtp"
    product.unlink()
    assert finished("run").returncode == 0
    assert product.exists()


def test_an_edit_of_a_deck_that_is_included_runs_the_stages_that_read_it(finished):
    """The edited deck is kept."""
    deck = finished.case(SINGLE_BALLS[0]) / "integrate.in"
    deck.write_text(deck.read_text() + "# mine\n")
    text = finished("run", "--dry-run").stdout
    assert f"{SINGLE_BALLS[0]}\n  rotate  (integrate.in has changed since stage rotate read" in text
    assert finished("run").returncode == 0
    assert deck.read_text().endswith("# mine\n")
    assert f"{SINGLE_BALLS[0]}: done" in finished("run", "--dry-run").stdout


def test_a_campaign_edit_runs_only_the_cases_it_changes(finished):
    before = finished.dates()
    # Another name and another charge: the single balls stay as they are.
    finished.file.write_text(TEXT.replace("count = [50]", "count = [40]"))
    assert finished("run").returncode == 0
    after = finished.dates()
    changed = {path.split("/")[1] for path in after if after[path] != before[path]}
    assert changed == {CHARGE}


def without_rotation(command, *case_ids):
    for case_id in case_ids:
        (command.case(case_id) / "timing.json").unlink()
    return command


def test_only_runs_the_case_it_names(finished):
    without_rotation(finished, *SINGLE_BALLS, CHARGE)
    assert finished("run", "--only", "*-S1.000", "--only", CHARGE).returncode == 0
    assert (finished.case(SINGLE_BALLS[0]) / "result.json").exists()
    assert (finished.case(CHARGE) / "result.json").exists()
    assert not (finished.case(SINGLE_BALLS[1]) / "timing.json").exists()


def test_a_failed_case_is_quoted_and_does_not_stop_the_others(finished):
    without_rotation(finished, *SINGLE_BALLS, CHARGE)
    done = finished("run", STAND_IN_FAIL=SINGLE_BALLS[0])
    assert done.returncode == 1
    assert "rotate failed: lost ball: ERROR: Lost atoms: original 2 current 1" in done.stdout
    failed = finished.case(SINGLE_BALLS[0])
    assert not (failed / "series.csv").exists() and not (failed / "timing.json").exists()
    assert "Lost atoms" in (failed / "log.rotate").read_text()
    for case_id in (SINGLE_BALLS[1], CHARGE):
        assert (finished.case(case_id) / "timing.json").exists()
    rows = {row["id"]: row for row in json.loads(finished("status", "--json").stdout)}
    assert rows[SINGLE_BALLS[0]]["state"] == "failed"
    assert rows[SINGLE_BALLS[0]]["failure"] == "lost ball"
    assert rows[SINGLE_BALLS[0]]["log"] == "log.rotate"
    assert finished("run").returncode == 0
    assert "failed" not in finished("status").stdout


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_run_ends_its_engines_and_resumes(finished, wait_for, number):
    case = finished.case(SINGLE_BALLS[0])
    series = case / "rotate.part" / "series.csv"
    process = without_rotation(finished, SINGLE_BALLS[0]).start("run", STAND_IN_SECONDS="60")
    wait_for(lambda: series.exists() and len(series.read_text().splitlines()) > 1)
    busy = finished("run")
    assert busy.returncode == 2 and f"in use by process {process.pid} on" in busy.stderr
    process.send_signal(number)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 130 and "repeat the command to resume" in errors
    length = series.stat().st_size
    time.sleep(1.5)
    assert series.stat().st_size == length, "the engine still writes"
    assert not (case / "series.csv").exists()
    row = json.loads(finished("status", "--json").stdout)[0]
    assert (row["state"], row["stage"]) == ("interrupted", "rotate") and row["step"] > 0
    mesh = (case / "liner.stl").stat().st_mtime_ns
    assert finished("run").returncode == 0
    assert (case / "series.csv").exists() and not series.exists()
    assert (case / "liner.stl").stat().st_mtime_ns == mesh


def test_progress_of_a_running_case_shows_in_the_status(finished, wait_for):
    series = finished.case(SINGLE_BALLS[0]) / "rotate.part" / "series.csv"
    process = without_rotation(finished, SINGLE_BALLS[0]).start("run", STAND_IN_SECONDS="60")
    try:
        wait_for(lambda: series.exists() and len(series.read_text().splitlines()) > 2)
        row = json.loads(finished("status", "--json").stdout)[0]
    finally:
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=60)
    assert row["state"] == "running" and row["stage"] == "rotate"
    assert 0 < row["step"] < row["steps"] == 6000
    assert row["simulated_s"] == pytest.approx(row["step"] * 1e-4)
    assert row["particle_steps_per_s"] > 0 and row["time_left_s"] > 0


@pytest.mark.parametrize(
    ("end", "words"),
    [
        ("os.kill(os.getpid(), 9)", "the workflow ended by signal 9: the workflow ended without a"),
        ("sys.exit(3)", "the workflow ended with exit code 3: the workflow ended without a"),
        ("print('no space'); sys.exit(3)", "the workflow ended with exit code 3: no space; see"),
        ("sys.exit(0)", "the workflow ended with exit code 0: the workflow ended without a"),
    ],
)
def test_a_workflow_that_runs_no_stage_is_reported_with_what_to_do(
    finished, monkeypatch, end, words
):
    """As if a job or Snakemake had been killed before any stage could record it."""
    without_rotation(finished, *SINGLE_BALLS)
    line = [sys.executable, "-c", f"import os, sys; {end}"]
    monkeypatch.setattr(run_command, "snakemake_line", lambda *_: line)
    done = finished("run")
    assert done.returncode == 1
    assert f"{SINGLE_BALLS[0]} and 1 more: rotate not run: {words}" in done.stdout
    advice = done.stdout.splitlines()[-1]
    assert advice.startswith("  to do: repeat the command; if this message comes again: ")
    monkeypatch.undo()
    # The advice shows the error, or runs the stage.
    by_hand = subprocess.run(
        shlex.split(advice.partition("again: ")[2]), env=finished.environment(), check=False
    )
    assert by_hand.returncode == 0
    assert (finished.case(SINGLE_BALLS[0]) / "timing.json").exists()


def test_a_workflow_that_was_killed_for_lack_of_memory_is_reported(finished, monkeypatch):
    without_rotation(finished, SINGLE_BALLS[0])
    line = [sys.executable, "-c", "import os; os.kill(os.getpid(), 9)"]
    monkeypatch.setattr(run_command, "snakemake_line", lambda *_: line)
    kills = iter((3, 5))
    monkeypatch.setattr("millscale.workflow.failures.memory_kills", lambda: next(kills))
    cause, advice = finished("run").stdout.splitlines()[-2:]
    assert (
        "ended by signal 9" in cause
        and "out of memory: processes killed by the system meanwhile: 2" in cause
    )
    assert advice.startswith("  to do: run fewer cases at a time (--jobs)")


def test_a_failed_case_does_not_hide_one_that_was_not_run(finished, monkeypatch):
    without_rotation(finished, *SINGLE_BALLS)
    assert finished("run", STAND_IN_FAIL=SINGLE_BALLS[0]).returncode == 1
    (finished.case(SINGLE_BALLS[1]) / "timing.json").unlink()
    line = [sys.executable, "-c", ""]
    monkeypatch.setattr(run_command, "snakemake_line", lambda *_: line)
    text = finished("run").stdout
    assert f"{SINGLE_BALLS[0]}: rotate failed" in text
    assert f"{SINGLE_BALLS[1]}: rotate not run: the workflow ended with exit code 0" in text
