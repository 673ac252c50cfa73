"""A killed and resumed run is bit-identical to an uninterrupted run."""

import contextlib
import json
import os
import random
import shutil
import subprocess
import sys
import time

import kill_resume
import psutil
import pytest

import small_campaign
from millscale.cases.generate import generate
from millscale.engine.deck_run import ENGINE
from millscale.engine.restart_file import NotWholeError, read_restart
from millscale.runs.layout import IMPACTS_FILES, LOADS_FILES, STAGES

pytestmark = pytest.mark.engine

BALL = small_campaign.SINGLE_BALLS[0]
# Some seconds of a charge; a single ball for as long.
CHARGE_TEXT = kill_resume.campaign_text(rotation_angle=3.0, restart_angle=0.15, balls=150)
LOADS_TEXT = CHARGE_TEXT + "impacts = true\nliner_loads = true\n"
RECORDED = (*IMPACTS_FILES, *LOADS_FILES)
BALL_TEXT = (
    small_campaign.TEXT.split("[single_ball]")[0]
    + "[single_ball]\nS = [1.0]\nrotation_angle_rad = 10.0\nstep_s = 1e-5\n"
    + "restart_angle_rad = 0.5\n"
)


def begin(case, name):
    # One rank: on a busy machine two wait for each other. The campaign below has two.
    line = [sys.executable, "-m", "millscale.workflow.run_stage", name, str(case), "--ranks", "1"]
    return psutil.Popen(line, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)


def run(case, name):
    process = begin(case, name)
    _, errors = process.communicate(timeout=300)
    assert process.returncode == 0, errors.decode()


@pytest.fixture(
    scope="module",
    params=[
        (CHARGE_TEXT, kill_resume.CASE),
        pytest.param((LOADS_TEXT, kill_resume.CASE), id="impacts-and-loads"),
        (BALL_TEXT, BALL),
    ],
)
def whole(request, tmp_path_factory):
    """A case that ran without interruption."""
    text, case_id = request.param
    folder = tmp_path_factory.mktemp("whole")
    (folder / "small.toml").write_text(text)
    generate(folder / "small.toml", folder / "runs")
    case = folder / "runs" / "cases" / case_id
    kind = json.loads((case / "case.json").read_text())["kind"]
    for name in [stage.name for stage in STAGES[kind] if stage.name != "result"]:
        run(case, name)
    return case


@pytest.fixture
def case(whole, tmp_path):
    """A copy of the case, ready to rotate."""
    copy = tmp_path / whole.name
    shutil.copytree(whole, copy, symlinks=True)
    for path in copy.glob("mill.?.restart"):
        path.unlink()
    for name in ("series.csv", "timing.json", "occupancy.csv", *RECORDED):
        (copy / name).unlink(missing_ok=True)
    shutil.rmtree(copy / "dump", ignore_errors=True)
    return copy


def started(case, share):
    """A rotation that has made at least a share of its steps in this attempt or an earlier one."""
    document = json.loads((case / "case.json").read_text())["time"]
    wanted = document["settle_steps"] + share * document["steps"]
    process, series = begin(case, "rotate"), case / "rotate.part" / "series.csv"
    while process.poll() is None and (
        kill_resume._last_step(series) < wanted or not engines(process)
    ):
        time.sleep(0.01)
    assert process.poll() is None, "it ended before it could be killed"
    return process


def engines(process):
    return [x for x in process.children(recursive=True) if x.name() == ENGINE]


def whole_files(case):
    """Restart files of the rotation; one may just have been begun when its engine was killed."""
    for k in (1, 2):
        path = case / "rotate.part" / f"mill.{k}.restart"
        with contextlib.suppress(NotWholeError, FileNotFoundError):
            read_restart(path)
            yield path


def held_between_files(case, process):
    """One of the engines, stopped at a moment at which both restart files are whole."""
    engine = random.choice(engines(process))
    while True:
        engine.suspend()
        if len(list(whole_files(case))) == 2:
            return engine
        engine.resume()
        time.sleep(0.01)


def note_of(case):
    return (case / "out.rotate").read_text().splitlines()[0]


def test_three_kills_change_nothing(case, whole):
    process = started(case, 0.3)
    held_between_files(case, process).kill()
    assert process.wait(60) == 1
    newest = max(whole_files(case), key=lambda path: read_restart(path).step)
    os.truncate(newest, newest.stat().st_size // 2)

    process = started(case, 0.5)
    assert note_of(case).startswith("goes on from step")
    assert f"{newest.name} is not whole" in note_of(case)
    process.kill()
    process.wait(60)

    process = started(case, 0.7)  # waits for what the killed stage has left
    assert note_of(case).startswith("goes on from step")
    process.terminate()
    assert process.wait(60) == 130

    run(case, "rotate")
    assert note_of(case).startswith("goes on from step")
    files = ["series.csv", *(f"dump/{path.name}" for path in whole.glob("dump/*"))]
    if (whole / "occupancy.csv").exists():
        files.append("occupancy.csv")
        assert len(files) > 5
    if json.loads((whole / "case.json").read_text())["deck"].get("impacts") == "on":
        files += RECORDED
    for name in files:
        assert (case / name).read_bytes() == (whole / name).read_bytes(), name
    assert len(list(case.glob("dump/*"))) == len(list(whole.glob("dump/*")))
    timing, expected = (json.loads((x / "timing.json").read_text()) for x in (case, whole))
    assert timing["attempts"] == 4 and expected["attempts"] == 1
    for name in ("steps", "particle_steps", "balls"):
        assert timing[name] == expected[name]


@pytest.mark.validate
def test_twenty_kills_of_a_campaign_change_nothing(tmp_path):
    """kill_resume.py does the same and writes docs/results/kill-resume.json."""
    ways = [*kill_resume.OF_ENGINE, *kill_resume.OF_WORKFLOW]
    kinds = [ways[i % len(ways)] for i in range(20)]
    random.Random(7).shuffle(kinds)
    text = kill_resume.campaign_text(rotation_angle=5.0, restart_angle=0.1, balls=500)
    record = kill_resume.kill_and_resume(tmp_path, kinds, 7, text)
    assert len(record["kills"]) == 20
    for kill in record["kills"]:
        assert kill["rows_that_differ"] == 0 and not kill["made_again"], kill
        assert kill["lock_free_s"] < 60, kill
        assert kill["other_ranks_refused"] == kill["next_said"].startswith("goes on"), kill
    assert any(kill["other_ranks_refused"] for kill in record["kills"])
    for finished in record["finished"]:
        assert finished["series_rows"] == finished["dumps"] == 0
        assert not finished["series_largest"] and not finished["files_that_differ"]
        assert not finished["results_that_differ"] and not finished["left_in_temporary_folder"]
