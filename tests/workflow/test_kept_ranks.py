"""A resumed case keeps its number of ranks; another number is refused."""

import json

import pytest

from millscale.engine.machine import available_cores
from millscale.engine.resume import begin
from millscale.runs.case_file import load_case
from millscale.runs.layout import stage_of
from millscale.workflow import stage_record
from millscale.workflow.run_stage import run_stage
from millscale.workflow.stage_work import run_of
from signed_restart import restart_file
from small_campaign import CHARGE
from small_command import STAND_IN


@pytest.fixture
def stopped(finished, monkeypatch):
    """Return a function that leaves the charge as if its rotation had stopped on some ranks."""
    monkeypatch.setenv("MILLSCALE_ENGINE", str(STAND_IN / "liggghts_mill"))

    def stop(ranks):
        folder = finished.case(CHARGE)
        case = load_case(folder)
        for name in ("series.csv", "timing.json", "result.json"):
            (folder / name).unlink(missing_ok=True)
        run = run_of(stage_of("multi-ball", "rotate"), case, folder, ranks)
        begin(run)
        every = case.output.sample_steps
        first = run.first // every * every + every
        rows = "".join(f"{first + i * every},0.1\n" for i in range(4))
        (run.part / "series.csv").write_text(f"step,time_s\n{rows}")
        restart_file(run.part, "mill.1.restart", first + 2 * every)
        return folder, first + 2 * every

    return stop


def content(folder):
    return {p: p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def test_the_ranks_of_an_attempt_are_the_default_whatever_else_runs(finished, stopped):
    folder, step = stopped(2)
    for only in ([], ["--only", CHARGE], ["--only", "*-S2.000", "--jobs", "1"]):
        printed = finished("run", "--dry-run", *only).stdout
        assert f"in {folder}: mpirun -np 2 " in printed
    done = finished("run", "--only", CHARGE)
    assert done.returncode == 0, done.stdout + done.stderr
    assert f"{CHARGE}: goes on from step {step:,} of" in done.stdout
    record = json.loads((folder / "provenance.json").read_text())["stages"]["rotate"]
    assert record["ranks"] == 2


def test_other_ranks_are_refused_with_what_to_do_and_nothing_is_written(finished, stopped):
    folder, _ = stopped(2)
    before = content(finished.runs)
    for more in ([], ["--dry-run"]):
        refused = finished("run", "--ranks", "1", *more)
        assert refused.returncode == 2 and refused.stderr.count("\n") == 1
        assert f"--ranks 1: stage rotate of {CHARGE} goes on from step" in refused.stderr
        assert "--ranks 2 or no --ranks to resume, --start-over to start it again" in refused.stderr
    assert content(finished.runs) == before
    assert run_stage(folder, "rotate", 1) == 1
    assert "ran on 2 ranks, not on 1" in stage_record.read_record(folder).cause
    assert finished("run", "--ranks", "2").returncode == 0


def test_start_over_deletes_the_attempt(finished, stopped):
    folder, _ = stopped(2)
    assert "mpirun -np 1 " in finished("run", "--ranks", "1", "--start-over", "--dry-run").stdout
    assert (folder / "rotate.part").exists()
    done = finished("run", "--ranks", "1", "--start-over")
    assert done.returncode == 0 and "goes on" not in done.stdout
    assert not (folder / "rotate.part").exists()
    assert json.loads((folder / "timing.json").read_text())["attempts"] == 1


def test_an_attempt_on_more_ranks_than_cores_is_refused_with_the_options(finished, stopped):
    ranks = available_cores() + 1
    stopped(ranks)
    refused = finished("run", "--only", CHARGE)
    assert refused.returncode == 2
    assert f"resumes on the {ranks} ranks it began with" in refused.stderr
    assert "--oversubscribe, or --start-over" in refused.stderr
    assert f"-np {ranks} " in finished("run", "--dry-run", "--oversubscribe").stdout


def test_an_attempt_at_another_case_is_ignored(finished, stopped):
    stopped(2)
    text = finished.file.read_text()
    finished.file.write_text(text.replace("settle_s = 0.1", "settle_s = 0.2"))
    done = finished("run", "--ranks", "1", "--only", CHARGE)
    assert done.returncode == 0, done.stderr
    assert "goes on" not in done.stdout
