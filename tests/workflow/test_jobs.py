"""Cases that share a job, and jobs that end at any moment without loss."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from millscale.cases.cost import BUILT_IN
from millscale.engine.machine import Allocation, CoreWish
from millscale.workflow.jobs import LEAST_TIME_S, jobs_of, read_jobs, write_jobs
from millscale.workflow.placement import place
from millscale.workflow.targets import Local, Slurm
from millscale.workflow.targets.batch_system import SHARED_JOB_S
from paper_campaign import MULTI_BALL, cases
from small_campaign import CHARGE, SINGLE_BALLS

MANY = {"scaling__S": [1.0 + 0.1 * i for i in range(50)]}


def shared(some, jobs=2):
    return Allocation({case.id: 1 for case in some}, jobs, jobs)


def test_every_case_is_in_one_job(tmp_path):
    some = cases(tmp_path, **MANY)
    made = jobs_of(some, shared(some), BUILT_IN, Local().shared_job_s)
    assert sorted(x for job in made for x in job.cases) == sorted(case.id for case in some)
    assert len({job.name for job in made}) == len(made)


def test_small_cases_share_jobs_enough_to_keep_the_cores_busy(tmp_path):
    some = cases(tmp_path, **MANY)
    made = jobs_of(some, shared(some), BUILT_IN, Local().shared_job_s)
    assert 8 <= len(made) <= 12
    times = [job.time_s for job in made]
    assert times == sorted(times, reverse=True)
    assert len(jobs_of(some, shared(some), BUILT_IN, Slurm().shared_job_s)) == 1


def test_large_cases_and_those_of_several_ranks_have_jobs_of_their_own(tmp_path):
    some = cases(tmp_path, **MULTI_BALL, single_ball__rotation_angle_rad=5e4)
    mills = [case for case in some if case.kind == "multi-ball"]
    allocation = Allocation({x.id: 2 if x in mills else 1 for x in some}, 4, 4)
    for job in jobs_of(some, allocation, BUILT_IN, Slurm().shared_job_s):
        assert len(job.cases) == 1 and job.name == job.cases[0]
        assert job.ranks == allocation.ranks[job.name]


def test_a_job_requests_twice_the_predicted_time_and_at_least_ten_minutes(tmp_path):
    some = cases(tmp_path, **MULTI_BALL, single_ball__rotation_angle_rad=5e4)
    made = jobs_of(some, place(some, CoreWish(jobs=1)), BUILT_IN, Slurm().shared_job_s)
    assert min(job.minutes for job in made) == LEAST_TIME_S / 60
    longest = made[0]
    assert longest.time_s > SHARED_JOB_S
    # Whole minutes.
    assert 2 * longest.time_s / 60 <= longest.minutes <= 2 * longest.time_s / 60 + 1


def test_jobs_are_read_as_written_and_those_of_earlier_runs_are_gone(tmp_path):
    some = cases(tmp_path, **MANY)
    made = jobs_of(some, shared(some), BUILT_IN, Local().shared_job_s)
    early = write_jobs(tmp_path, made[:1])
    early.parent.rename(early.parent.with_name("an-earlier-run"))
    file = write_jobs(tmp_path, made)
    assert read_jobs(file) == made
    assert list((tmp_path / ".jobs").iterdir()) == [file.parent]


def ready(command, *case_ids):
    """A job of these cases that have still to rotate; returns the line that runs it."""
    for case_id in case_ids:
        (command.case(case_id) / "timing.json").unlink()
    entry = {"name": "j", "cases": case_ids, "ranks": 1, "time_s": 1, "minutes": 1, "memory_mb": 1}
    file = command.runs / "jobs.json"
    file.write_text(json.dumps([entry]))
    return [sys.executable, "-m", "millscale.workflow.run_job", file.name, "j"]


def run(command, line, **more):
    return subprocess.run(
        line, cwd=command.runs, env=command.environment(**more), capture_output=True, text=True
    )


def test_a_case_that_fails_leaves_the_others_of_its_job_alone(finished):
    line = ready(finished, *SINGLE_BALLS)
    done = run(finished, line, STAND_IN_FAIL=SINGLE_BALLS[0])
    assert done.returncode == 0, done.stderr
    assert not (finished.case(SINGLE_BALLS[0]) / "timing.json").exists()
    assert json.loads((finished.case(SINGLE_BALLS[0]) / "stage.json").read_text())["cause"]
    assert (finished.case(SINGLE_BALLS[1]) / "result.json").exists()


def test_a_case_whose_process_is_killed_leaves_the_others_of_its_job_alone(finished, wait_for):
    line = ready(finished, *SINGLE_BALLS)
    environment = finished.environment(STAND_IN_SECONDS="2")
    process = subprocess.Popen(line, cwd=finished.runs, env=environment)
    record = finished.case(SINGLE_BALLS[0]) / "stage.json"

    def rotating():
        content = json.loads(record.read_text())
        return content["state"] == "running" and content["stage"] == "rotate" and content

    os.kill(wait_for(rotating)["process"], signal.SIGKILL)
    assert process.wait(60) == 1
    assert not (finished.case(SINGLE_BALLS[0]) / "timing.json").exists()
    assert (finished.case(SINGLE_BALLS[1]) / "result.json").exists()


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_finished_cases_of_a_job_that_is_ended_stay_and_the_rest_is_done_next(
    finished, wait_for, number
):
    line = ready(finished, *SINGLE_BALLS)
    environment = finished.environment(STAND_IN_SECONDS="2")
    process = subprocess.Popen(line, cwd=finished.runs, env=environment, start_new_session=True)
    first, second = (finished.case(x) for x in SINGLE_BALLS)
    wait_for(lambda: (second / "rotate.part" / "series.csv").exists())
    # As in Slurm, every process of the job gets the signal.
    engine = json.loads((second / "stage.json").read_text())["process"]
    for child in [*children(engine), process.pid]:
        os.kill(child, number)
    assert process.wait(60) == (130 if number == signal.SIGTERM else -number)
    assert not (second / "timing.json").exists()
    before = finished.dates()
    assert run(finished, line).returncode == 0
    after = finished.dates()
    changed = {Path(path).parts[1] for path in after if after[path] != before.get(path)}
    assert changed == {SINGLE_BALLS[1]}
    assert (first / "result.json").exists() and (second / "result.json").exists()


def children(process):
    import psutil

    found = psutil.Process(process)
    return [*(x.pid for x in found.children(recursive=True)), process]


def test_a_case_in_use_is_reported_and_left_alone(finished, wait_for):
    line = ready(finished, CHARGE)
    environment = finished.environment(STAND_IN_SECONDS="60")
    process = subprocess.Popen(line, cwd=finished.runs, env=environment)
    series = finished.case(CHARGE) / "rotate.part" / "series.csv"
    wait_for(series.exists)
    second = run(finished, line)
    assert second.returncode == 1 and "in use by" in second.stderr
    process.terminate()
    assert process.wait(60) == 130
