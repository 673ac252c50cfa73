"""Generated case folders, run by their mpirun.sh or by lines typed by hand, without millscale."""

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import kill_resume
import psutil
import pytest
import small_campaign
from small_campaign import CHARGE, SINGLE_BALLS

from mill_campaign.engine_run import ENGINE, find_engine

pytestmark = pytest.mark.engine

BALL = SINGLE_BALLS[1]
# Some seconds of a charge, with restart files on the way.
LONG = kill_resume.campaign_text(rotation_angle=3.0, restart_angle=0.15, balls=150)


def millscale(command, *arguments):
    """Run the command line in a process of its own, with the real engine and analysis."""
    line = [sys.executable, "-m", "mill_campaign.cli", command, *map(str, arguments)]
    done = subprocess.run(line, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def campaign(folder, text=small_campaign.TEXT):
    file = folder / "small.toml"
    file.write_text(text)
    return file


def environment(**more):
    """Of a shell that knows the engine by its name only."""
    own = {k: v for k, v in os.environ.items() if not k.startswith(("OMPI_", "MILLSCALE_"))}
    path = f"{find_engine().parent}{os.pathsep}{own['PATH']}"
    return {**own, "PATH": path, **more}


def by_script(case, *options, code=0, **more):
    """Run mpirun.sh in a case folder; returns what it printed on both streams."""
    line = ["sh", "mpirun.sh", *options]
    done = subprocess.run(line, cwd=case, env=environment(**more), capture_output=True, text=True)
    assert done.returncode == code, done.stdout[-2000:] + done.stderr
    return done.stdout + done.stderr


def made(case):
    """Bytes of what the engine made of a case, without the times that sign a restart file."""
    names = ("series.csv", "occupancy.csv", "settled.restart", "mill.1.restart", "mill.2.restart")
    files = [*(case / name for name in names), *(case / "dump").glob("*")]
    return {
        path.name: re.sub(rb" loop_time_s [^\n]*\n\Z", b"", path.read_bytes())
        for path in files
        if path.exists()
    }


@pytest.fixture(scope="module")
def generated_once(tmp_path_factory):
    folder = tmp_path_factory.mktemp("generated")
    millscale("generate", campaign(folder), "--runs", folder / "runs")
    return folder / "runs"


@pytest.fixture
def generated(generated_once, tmp_path):
    """A copy of generated folders, as someone takes them to another machine."""
    shutil.copytree(generated_once, tmp_path / "runs")
    campaign(tmp_path)
    return tmp_path / "runs" / "cases"


@pytest.fixture(scope="module", params=[1, 2])
def run_once(request, tmp_path_factory):
    """The same campaign by `millscale run`: number of ranks, folder of the cases."""
    folder = tmp_path_factory.mktemp("run")
    options = ("--ranks", request.param, "--jobs", 1)
    millscale("run", campaign(folder), "--runs", folder / "runs", *options)
    return request.param, folder / "runs" / "cases"


def test_the_script_makes_the_bytes_of_a_run(generated, run_once):
    ranks, run = run_once
    by_script(generated / CHARGE, RANKS=str(ranks))
    by_script(generated / BALL)
    for case_id, files in ((CHARGE, 6), (BALL, 1)):
        found, expected = made(generated / case_id), made(run / case_id)
        assert found.keys() == expected.keys() and len(found) >= files
        assert [name for name in found if found[name] != expected[name]] == []


def test_a_run_leaves_the_script_too(generated, run_once):
    ranks, run = run_once

    def text(case):
        return re.sub(r"-np \d+|RANKS:-\d+|\d+ MPI ranks", "", (case / "mpirun.sh").read_text())

    for case_id in (CHARGE, *SINGLE_BALLS):
        assert text(run / case_id) == text(generated / case_id)
        default = f"ranks=${{RANKS:-{ranks if case_id == CHARGE else 1}}}\n"
        assert default in (run / case_id / "mpirun.sh").read_text()


def test_the_lines_of_the_script_typed_by_hand_make_the_same(generated, run_once):
    _, run = run_once
    case = generated / CHARGE
    text = (run / CHARGE / "mpirun.sh").read_text()
    lines = re.findall(r"^#   (mpirun -np .*)$", text, re.M)
    assert len(lines) == 2 and f" {ENGINE} -in settle.in " in lines[0]
    root = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    for line in lines:
        subprocess.run(line, shell=True, cwd=case, env=environment(**root), check=True)
    found, expected = made(case), made(run / CHARGE)
    assert [name for name in expected if found[name] != expected[name]] == []


def test_the_script_is_plain_posix_shell(generated):
    if not shutil.which("shellcheck"):
        pytest.skip("no shellcheck")
    scripts = [str(generated / name / "mpirun.sh") for name in (CHARGE, BALL)]
    done = subprocess.run(["shellcheck", "-s", "sh", *scripts], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


def test_a_settled_charge_is_not_settled_again(generated):
    case = generated / CHARGE
    by_script(case, RANKS="1")
    settled = (case / "settled.restart").stat().st_mtime_ns
    (case / "series.csv").rename(case / "series.old.csv")
    assert "settled.restart is there" in by_script(case, RANKS="1")
    assert (case / "settled.restart").stat().st_mtime_ns == settled
    assert (case / "series.csv").read_text() == (case / "series.old.csv").read_text()


@pytest.mark.parametrize("case_id", [CHARGE, BALL])
def test_a_finished_series_is_not_overwritten(generated, case_id):
    case = generated / case_id
    by_script(case, RANKS="1")
    before = made(case)
    said = by_script(case, code=1).splitlines()[-1]
    assert "series.csv is there and complete: move it to another folder" in said
    assert made(case) == before


def test_files_of_another_case_are_not_taken_for_this_one(generated):
    case = generated / CHARGE
    by_script(case, RANKS="1")
    text = (case / "parameters.in").read_text()
    changed = re.sub(r"case_digest string \S+", "case_digest string sha256-0", text)
    (case / "parameters.in").write_text(changed)
    assert "log.settle is not of this case" in by_script(case, code=1)
    (case / "settled.restart").unlink()
    said = by_script(case, code=1)
    assert "series.csv is there, and no restart file" in said or "is not of this case" in said


def test_a_cut_bed_is_not_rotated(generated):
    case = generated / CHARGE
    by_script(case, RANKS="1")
    (case / "series.csv").unlink()
    with (case / "settled.restart").open("r+b") as file:
        file.truncate((case / "settled.restart").stat().st_size - 5)
    assert "settled.restart is cut" in by_script(case, code=1)
    assert not (case / "series.csv").exists()


def test_what_is_missing_is_named(generated, tmp_path):
    case = generated / BALL
    script = case / "mpirun.sh"
    assert "no parameters.in here" in by_script(_with(tmp_path / "elsewhere", script), code=1)
    said = by_script(case, code=1, LIGGGHTS_MILL="/no/engine")
    assert "no /no/engine on the PATH" in said
    (case / "rotate.part").mkdir()
    assert "rotate.part is of a millscale run" in by_script(case, code=1)


def _with(folder, file):
    folder.mkdir()
    shutil.copy(file, folder)
    return folder


def test_the_script_and_a_run_keep_each_other_out(generated, wait_for):
    case = generated / BALL
    holder = subprocess.Popen(["flock", ".millscale.lock", "sleep", "30"], cwd=case)
    try:
        wait_for(lambda: not _free(case))
        assert "another run is in this folder" in by_script(case, code=1)
    finally:
        holder.terminate()
        holder.wait()


def _free(case):
    return subprocess.run(["flock", "-n", ".millscale.lock", "true"], cwd=case).returncode == 0


@pytest.fixture(scope="module")
def long_once(tmp_path_factory):
    """A longer charge, generated, and the same run by its script without interruption."""
    folder = tmp_path_factory.mktemp("long")
    millscale("generate", campaign(folder, LONG), "--runs", folder / "runs")
    whole = folder / "whole"
    shutil.copytree(folder / "runs" / "cases" / CHARGE, whole)
    by_script(whole, RANKS="1")
    return whole, folder / "runs" / "cases" / CHARGE


def test_a_killed_script_goes_on_to_the_same_bytes(long_once, tmp_path, wait_for):
    whole, generated = long_once
    case = tmp_path / CHARGE
    shutil.copytree(generated, case)
    rows = len((whole / "series.csv").read_text().splitlines())
    for share in (0.3, 0.6):
        _kill_at(case, share * rows, wait_for)
    said = by_script(case, code=1, RANKS="2")
    assert "begun with RANKS=1; RANKS=2 would change the results" in said
    assert "goes on from step" in by_script(case)
    assert (
        (case / "log.rotate.2")
        .read_text(errors="replace")
        .splitlines()[-1]
        .startswith("millscale restart step")
    )
    found, expected = made(case), made(whole)
    assert [x for x in expected if not x.startswith("mill.") and found[x] != expected[x]] == []


def _kill_at(case, rows, wait_for):
    """Start mpirun.sh and kill it and the engine when series.csv has so many rows."""
    process = psutil.Popen(
        ["sh", "mpirun.sh"], cwd=case, env=environment(RANKS="1"), stdout=subprocess.DEVNULL
    )
    wait_for(lambda: _rows(case) > rows or process.poll() is not None)
    assert process.poll() is None, "ended before it could be killed"
    for one in [*process.children(recursive=True), process]:
        one.send_signal(signal.SIGKILL)
    process.wait()
    time.sleep(0.2)


def _rows(case):
    series = Path(case) / "series.csv"
    return len(series.read_text().splitlines()) if series.exists() else 0
