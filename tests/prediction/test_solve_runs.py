"""`millscale solve` with the engine on a small mill: rounds, a kill, the resume."""

import json
import subprocess
import sys

import pytest

import in_process
import small_campaign

HEAD = small_campaign.TEXT.split("[single_ball]")[0]
CHARGE = """[multi_ball]
S = [1.5]
filling = 0.1
settle_s = 0.2
rotation_angle_rad = 12.0
step_s = 2e-4
restart_angle_rad = 0.5
"""
ERROR = "25%"

pytestmark = pytest.mark.engine


def words(folder):
    file = folder / "mill.toml"
    file.write_text(HEAD + CHARGE)
    options = ("--error", ERROR, "--observable", "power", "--jobs", "1")
    return "solve", str(file), "--runs", str(folder / "solve"), *options


def series(folder):
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in (folder / "solve").glob("round-*/cases/*/series.csv")
    }


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A solve that was not interrupted. Read only."""
    folder = tmp_path_factory.mktemp("whole")
    done = in_process.millscale(*words(folder))
    assert done.returncode == 0, done.stdout + done.stderr
    return folder, done.stdout


def test_the_answer_comes_from_the_rounds(whole):
    folder, output = whole
    content = json.loads((folder / "solve/answer.json").read_text())
    assert content["is_met"] and content["half_widths"]["power"] <= 0.25
    rounds = content["rounds"]
    assert [x["number"] for x in rounds] == list(range(1, len(rounds) + 1))
    assert all(x["done"] for x in rounds)
    made = {path.split("/")[1] for path in series(folder)}
    assert made == {f"round-{x['number']}" for x in rounds}
    assert f"round {len(rounds)}: " in output
    power = next(x for x in content["prediction"]["numbers"] if x["name"] == "power")
    assert power["lower"] < power["value"] < power["upper"]


def test_the_same_command_again_runs_nothing(whole):
    folder, _ = whole
    before = {p: p.stat().st_mtime_ns for p in (folder / "solve").glob("round-*/**/*")}
    done = in_process.millscale(*words(folder))
    assert done.returncode == 0
    assert {p: p.stat().st_mtime_ns for p in (folder / "solve").glob("round-*/**/*")} == before


def test_a_kill_loses_nothing(whole, tmp_path, wait_for):
    """SIGKILL in the rotation of the first run; then the same rounds and series, bit by bit."""
    line = [sys.executable, "-m", "millscale", *words(tmp_path)]
    process = subprocess.Popen(line, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    part = "solve/round-1/cases/*/rotate.part/mill.*.restart"
    try:
        wait_for(lambda: list(tmp_path.glob(part)) or process.poll() is not None, seconds=300.0)
        assert process.poll() is None, "it ended before it could be killed"
    finally:
        process.kill()
        process.wait()
    assert not (tmp_path / "solve/answer.json").exists()
    done = in_process.millscale(*words(tmp_path))
    assert done.returncode == 0, done.stdout + done.stderr
    assert "goes on from step" in done.stdout
    ours, theirs = (
        {path: content for path, content in series(folder).items() if "round-1/" in path}
        for folder in (tmp_path, whole[0])
    )
    assert ours and ours == theirs


def test_a_failed_run_is_one_line(tmp_path, monkeypatch):
    """The engine is a program that fails at once."""
    monkeypatch.setenv("MILLSCALE_ENGINE", "/bin/false")
    done = in_process.millscale(*words(tmp_path))
    assert done.returncode == 1
    (line,) = done.stderr.splitlines()
    assert line.startswith("error: round 1: mb-cg-paper-S") and "settle failed" in line
    assert json.loads((tmp_path / "solve/solve.json").read_text())["rounds"][0]["done"] is False
