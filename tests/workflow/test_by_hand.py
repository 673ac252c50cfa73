"""Generated case folders, run by their mpirun.sh or by lines typed by hand, without millscale."""

import json
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
from millscale.engine.deck_run import ENGINE, find_engine
from millscale.runs.provenance import read_provenance
from millscale.workflow.run_job import run_case
from millscale.workflow.stage_record import read_record
from millscale.workflow.status import campaign_status
from millscale.workflow.verify import verify
from small_campaign import CHARGE, SINGLE_BALLS

pytestmark = pytest.mark.engine

BALL = SINGLE_BALLS[1]
# Some seconds of a charge, with restart files on the way.
LONG = kill_resume.campaign_text(rotation_angle=6.0, restart_angle=0.15, balls=150)


def millscale(command, *arguments):
    """Run the command line in a process of its own, with the real engine and analysis."""
    line = [sys.executable, "-m", "millscale", command, *map(str, arguments)]
    done = subprocess.run(line, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def campaign(folder, text=small_campaign.TEXT):
    file = folder / "small.toml"
    file.write_text(text)
    return file


def environment(**more):
    """Return the environment of a shell that finds the engine by its name only."""
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


def test_a_run_writes_the_script_too(generated, run_once):
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
    assert "move dump/* elsewhere" in by_script(case, RANKS="1", code=1)
    (case / "dump").rename(case / "dump.old")
    (case / "dump").mkdir()
    assert "settled.restart is there" in by_script(case, RANKS="1")
    assert (case / "settled.restart").stat().st_mtime_ns == settled
    assert (case / "series.csv").read_text() == (case / "series.old.csv").read_text()


@pytest.mark.parametrize("case_id", [CHARGE, BALL])
def test_a_finished_series_is_not_overwritten(generated, case_id):
    case = generated / case_id
    by_script(case, RANKS="1")
    before = made(case)
    printed = by_script(case, code=1).splitlines()[-1]
    assert "series.csv is there and complete: move it and dump/* elsewhere" in printed
    assert made(case) == before


def test_files_of_another_case_are_not_taken_for_this_one(generated):
    case = generated / CHARGE
    by_script(case, RANKS="1")
    text = (case / "parameters.in").read_text()
    changed = re.sub(r"case_digest string \S+", "case_digest string sha256-0", text)
    (case / "parameters.in").write_text(changed)
    assert "log.settle is not of this case" in by_script(case, code=1)
    (case / "settled.restart").unlink()
    printed = by_script(case, code=1)
    assert "series.csv is there, and no restart file" in printed or "is not of this case" in printed


def test_a_cut_bed_is_not_rotated(generated):
    case = generated / CHARGE
    by_script(case, RANKS="1")
    (case / "series.csv").unlink()
    shutil.rmtree(case / "dump")
    with (case / "settled.restart").open("r+b") as file:
        file.truncate((case / "settled.restart").stat().st_size - 5)
    assert "settled.restart is cut" in by_script(case, code=1)
    assert not (case / "series.csv").exists()


def test_the_script_does_not_use_slurm(generated):
    case = generated / BALL
    job = {
        "SLURM_JOB_ID": "1",
        "SLURM_JOBID": "1",
        "SLURM_NODELIST": "nowhere",
        "SLURM_NNODES": "1",
    }
    assert "done, series.csv is complete" in by_script(case, **job, SLURM_TASKS_PER_NODE="1")


def test_what_is_missing_is_named(generated, tmp_path):
    case = generated / BALL
    script = case / "mpirun.sh"
    assert "no parameters.in here" in by_script(_with(tmp_path / "elsewhere", script), code=1)
    printed = by_script(case, code=1, LIGGGHTS_MILL="/no/engine")
    assert "no /no/engine on the PATH" in printed
    (case / "rotate.part").mkdir()
    assert "rotate.part is of millscale run" in by_script(case, code=1)


def _with(folder, file):
    folder.mkdir()
    shutil.copy(file, folder)
    return folder


def test_the_script_and_a_run_lock_each_other_out(generated, wait_for):
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


def test_a_killed_script_resumes_and_gives_the_same_bytes(long_once, tmp_path, wait_for):
    whole, generated = long_once
    case = tmp_path / CHARGE
    shutil.copytree(generated, case)
    rows = len((whole / "series.csv").read_text().splitlines())
    for share in (0.3, 0.6):
        _kill_at(case, share * rows, wait_for)
    printed = by_script(case, code=1, RANKS="2")
    assert "begun with RANKS=1; RANKS=2 would change the results" in printed
    assert "goes on from step" in by_script(case)
    assert (
        (case / "log.rotate.2")
        .read_text(errors="replace")
        .splitlines()[-1]
        .startswith("millscale restart step")
    )
    found, expected = made(case), made(whole)
    assert [x for x in expected if not x.startswith("mill.") and found[x] != expected[x]] == []


def _kill_at(case, rows, wait_for, look=lambda: None):
    """Start mpirun.sh, and when series.csv has so many rows look and kill it and the engine."""
    process = psutil.Popen(
        ["sh", "mpirun.sh"], cwd=case, env=environment(RANKS="1"), stdout=subprocess.DEVNULL
    )
    wait_for(lambda: _rows(case) > rows or process.poll() is not None)
    assert process.poll() is None, "ended before it could be killed"
    look()
    for one in [*process.children(recursive=True), process]:
        one.send_signal(signal.SIGKILL)
    process.wait()
    time.sleep(0.2)


def _rows(case):
    series = Path(case) / "series.csv"
    return len(series.read_text().splitlines()) if series.exists() else 0


# The other tests are about millscale's use of runs by hand.

SEEDS = small_campaign.TEXT.replace("count = [50]", "count = [50]\nseeds = [1, 2]\nledger = true")
ONE, OTHER = f"{CHARGE}-seed1", f"{CHARGE}-seed2"


@pytest.fixture(scope="module")
def by_hand_once(tmp_path_factory):
    """Two charges that differ in their seed and a single ball, all run by hand."""
    folder = tmp_path_factory.mktemp("by_hand")
    millscale("generate", campaign(folder, SEEDS), "--runs", folder / "runs")
    for case_id in (ONE, OTHER, BALL):
        by_script(folder / "runs" / "cases" / case_id, RANKS="1")
    return folder / "runs"


@pytest.fixture
def by_hand(by_hand_once, tmp_path):
    """A copy of them, as it comes from another machine."""
    shutil.copytree(by_hand_once, tmp_path / "runs")
    campaign(tmp_path, SEEDS)
    return tmp_path / "runs"


def engine_files(case):
    """Return content and date of every file that the engine wrote."""
    files = [
        *case.glob("log.*"),
        *case.glob("*.restart"),
        *case.glob("dump/*"),
        case / "series.csv",
    ]
    return {x.name: (x.read_bytes(), x.stat().st_mtime_ns) for x in files if x.exists()}


def states(runs):
    """Rows of `millscale status`, by case."""
    return {row["id"]: row for row in json.loads(millscale("status", runs, "--json"))}


def test_a_run_after_runs_by_hand_does_only_what_is_missing(by_hand):
    before = {case: engine_files(by_hand / "cases" / case) for case in (ONE, OTHER, BALL)}
    rows = states(by_hand)
    assert {rows[case]["stage"] for case in before} == {"result"}
    assert rows[ONE]["by_hand"] == ["settle", "rotate"] and rows[BALL]["by_hand"] == ["rotate"]
    assert rows[SINGLE_BALLS[0]]["by_hand"] == [] and rows[ONE]["step"] == rows[ONE]["steps"]
    found = [str(x) for x in verify(by_hand).differences]
    assert len(found) == 5 and all("made by hand: millscale run or report" in x for x in found)
    file = by_hand.parent / "small.toml"
    dry = millscale("run", file, "--runs", by_hand, "--dry-run")
    assert dry.count("run by hand: taken over") == 5 and dry.count("mpirun -np") == 1
    printed = millscale("run", file, "--runs", by_hand)
    assert f"{ONE}: settle and rotate run by hand: taken over, only missing stages run" in printed
    for case, files in before.items():
        assert engine_files(by_hand / "cases" / case) == files
        assert (by_hand / "cases" / case / "result.json").exists()
    rows = states(by_hand)
    assert {row["state"] for row in rows.values()} == {"done"}
    assert rows[ONE]["by_hand"] == ["settle", "rotate"]
    made = read_provenance(by_hand / "cases" / ONE)["rotate"]
    assert (made["by"], made["ranks"]) == ("hand", 1) and "host" not in made
    assert "LIGGGHTS" in made["engine"]["version"] and "path" not in made["engine"]
    assert "no differences" in millscale("verify", by_hand)
    assert "done, by hand" in millscale("status", by_hand)


def test_the_report_uses_what_was_run_by_hand(by_hand, run_once):
    assert "report: " in millscale("report", by_hand)
    results = json.loads((by_hand / "report" / "results.json").read_text())
    assert {row["id"] for row in results["multi_ball"]} == {ONE, OTHER}
    assert [row["id"] for row in results["single_ball"]] == [BALL]
    _, run = run_once
    own, other = (
        json.loads((x / BALL / "result.json").read_text()) for x in (by_hand / "cases", run)
    )
    assert own == other
    timing = json.loads((by_hand / "cases" / ONE / "timing.json").read_text())
    planned = json.loads((by_hand / "cases" / ONE / "case.json").read_text())["time"]["steps"]
    assert timing["ranks"] == 1 and timing["balls"] == 50 and timing["steps"] == planned
    assert timing["loop_time_s"] > 0.0 and timing["hardware"]["cpu"] == "unknown"


def test_after_settling_by_hand_a_run_rotates(generated, run_once):
    ranks, run = run_once
    case = generated / CHARGE
    line = re.findall(
        r"^#   (mpirun .* settle.in .*)$", (run / CHARGE / "mpirun.sh").read_text(), re.M
    )
    root = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    subprocess.run(line[0], shell=True, cwd=case, env=environment(**root), check=True)
    settled = (case / "settled.restart").stat().st_mtime_ns
    assert states(generated.parent)[CHARGE]["stage"] == "rotate"
    run_case(case, ranks)
    assert (case / "settled.restart").stat().st_mtime_ns == settled
    record = read_provenance(case)
    assert record["settle"]["by"] == "hand" and "by" not in record["rotate"]
    assert (case / "series.csv").read_bytes() == (run / CHARGE / "series.csv").read_bytes()
    bed, other = (json.loads((x / "settled.json").read_text()) for x in (case, run / CHARGE))
    assert bed["settled_by"] == CHARGE
    assert bed["bulk_fraction"] == other["bulk_fraction"]
    assert bed["largest_overlap_m"] == other["largest_overlap_m"]


def _edit(name, pattern, by):
    def edit(case):
        text, edits = re.subn(
            pattern, by, (case / name).read_text(errors="replace"), count=1, flags=re.M
        )
        assert edits == 1
        (case / name).write_text(text)

    return edit


def _copy(*names):
    def copy(case):
        for name in names:
            if (case / name).is_dir():
                shutil.rmtree(case / name)
                shutil.copytree(case.parent / OTHER / name, case / name)
            else:
                shutil.copy(case.parent / OTHER / name, case / name)

    return copy


def _cut_series(case):
    lines = (case / "series.csv").read_text().splitlines(keepends=True)
    (case / "series.csv").write_text("".join(lines[:-3]))


def _one_dump_more(case):
    shutil.copy(next(iter((case / "dump").iterdir())), case / "dump" / "charge.000000708.liggghts")


def _signed_wrong(case):
    content = bytearray((case / "settled.restart").read_bytes())
    content[len(content) // 2] ^= 1
    (case / "settled.restart").write_bytes(content)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (_edit("mill.in", "^run ", "timestep 1e-5\nrun "), "mill.in was edited since"),
        (
            _edit("parameters.in", "time_step string .*", "time_step string 5e-05"),
            "parameters.in was",
        ),
        (
            _edit("log.rotate", "^timestep .*0001", "timestep 5e-05"),
            "has the line `timestep 5e-05`",
        ),
        (
            _edit("log.rotate", "^compute charge .*$", ""),
            "does not repeat the line `compute charge",
        ),
        (_edit("log.rotate", "^Loop time.*$", ""), "log.rotate ends at step 9569 of 9569"),
        (lambda case: (case / "log.rotate").unlink(), "no log.rotate shows how it was made"),
        (_cut_series, "series.csv has step"),
        (_edit("series.csv", r"^1190,.*\n", ""), "series.csv has step 1225, expected 1190"),
        (_copy("series.csv"), "they are of different runs"),
        (_copy("series.csv", "log.rotate"), "log.rotate is not of this case.json"),
        (_copy("ledger.csv"), "ledger.csv and series.csv are of different runs"),
        (_copy("dump"), "has its centre of mass at"),
        (lambda case: next(iter((case / "dump").iterdir())).unlink(), "no dump of step"),
        (_one_dump_more, "is of no step at which mill.in dumps"),
        (_edit("occupancy.csv", r"\n.*\n\Z", "\n0.5,"), "occupancy.csv is not whole"),
        (_copy("settled.restart"), "does not hold the balls of settled.dump"),
        (_copy("settled.restart", "settled.dump"), "they are of different runs"),
        (_copy("settled.restart", "settled.dump", "log.settle"), "log.settle is not of this case"),
        (_signed_wrong, "is not what was written: its signature differs"),
        (_edit("log.settle", "^Loop time.*$", ""), "log.settle ends at step"),
        (lambda case: (case / "settled.dump").unlink(), "no settled.dump"),
        (_copy("charge.data"), "charge.data is not the file that stage charge made"),
    ],
    ids=lambda value: value.replace(" ", "-") if isinstance(value, str) else "",
)
def test_files_not_proven_to_be_of_this_case_are_not_used(by_hand, change, reason):
    case = by_hand / "cases" / ONE
    change(case)
    before = engine_files(case)
    run_case(case, 1)
    record = read_record(case)
    assert (record.state, record.kind) == ("failed", "by hand")
    assert reason in record.cause and "move the named file to another folder" in record.advice
    assert engine_files(case) == before, "results made by hand were lost"
    assert not (case / "result.json").exists()
    # `status` reads no dumps, only the inputs of the next stage.
    if "centre of mass" not in reason and "charge.data" not in reason:
        (row,) = [x for x in campaign_status(by_hand) if x.id == ONE]
        assert (row.state, row.failure) == ("failed", "by hand") and reason in row.problem


def test_after_an_edit_of_the_campaign_runs_by_hand_are_those_of_before(by_hand):
    file = by_hand.parent / "small.toml"
    file.write_text(SEEDS.replace("rotation_angle_rad = 1.0", "rotation_angle_rad = 1.1"))
    millscale("generate", file, "--runs", by_hand)
    case = by_hand / "cases" / ONE
    before = engine_files(case)
    assert "log.settle is not of this case" in by_script(case, code=1)
    run_case(case, 1)
    assert "log.settle is not of this case.json" in read_record(case).cause
    assert engine_files(case) == before


def test_a_run_by_hand_that_ended_early_is_shown_and_resumed(long_once, tmp_path, wait_for):
    whole, generated = long_once
    runs = tmp_path / "runs"
    shutil.copytree(generated.parent.parent, runs)
    case = runs / "cases" / CHARGE
    rows = len((whole / "series.csv").read_text().splitlines())
    seen = []

    def look():
        (row,) = campaign_status(runs)
        seen.append(row)

    _kill_at(case, 0.5 * rows, wait_for, look)
    assert seen[0].state == "running" and seen[0].by_hand == ("settle",)
    assert seen[0].stage == "rotate" and 0 < seen[0].step < seen[0].steps
    (row,) = campaign_status(runs)
    assert (row.state, row.failure) == ("failed", "by hand") and "log.rotate ends at" in row.problem
    before = engine_files(case)
    run_case(case, 1)
    assert engine_files(case) == before and read_record(case).state == "failed"
    by_script(case)
    run_case(case, 1)
    assert (case / "result.json").exists()
    timing = json.loads((case / "timing.json").read_text())
    assert timing["attempts"] == 2 and timing["ranks"] == 1
    assert timing["steps"] == json.loads((case / "case.json").read_text())["time"]["steps"]
    assert (case / "series.csv").read_bytes() == (whole / "series.csv").read_bytes()
