"""The temporary folder of a run, and its removal after kills."""

import os
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import psutil
import pytest

from millscale.engine import temporary_folder as temporary
from millscale.engine.temporary_folder import MPI_VARIABLES, own_folder, run_has_ended, sweep
from small_campaign import SINGLE_BALLS

HOLD = "from millscale.engine.temporary_folder import own_folder\nwith own_folder():\n    {}"


@pytest.fixture
def place(tmp_path, monkeypatch):
    """Return a temporary folder and one for shared memory, for this test alone."""
    here, memory = tmp_path / "tmp", tmp_path / "shm"
    here.mkdir()
    memory.mkdir()
    monkeypatch.setenv("TMPDIR", str(here))
    monkeypatch.setattr(tempfile, "tempdir", None)
    monkeypatch.setattr(temporary, "SHARED_MEMORY", memory)
    return here, memory


def left(place):
    return [path.name for folder in place for path in folder.iterdir()]


def killed(place):
    """Return the name of a folder whose process was killed while it held the folder's lock."""
    die = "import os; print(os.environ['TMPDIR'], flush=True); os.kill(os.getpid(), 9)"
    line = HOLD.format(die)
    done = subprocess.run([sys.executable, "-c", line], capture_output=True, text=True)
    assert done.returncode == -signal.SIGKILL
    return Path(done.stdout.strip())


def test_children_use_the_temporary_folder_and_it_is_deleted_at_the_end(place):
    with own_folder():
        line = [sys.executable, "-c", "import tempfile; print(tempfile.mkdtemp())"]
        made = subprocess.run(line, capture_output=True, text=True, check=True).stdout.strip()
        assert Path(made).parent.parent == place[0] and Path(made).is_dir()
        shared = Path(os.environ[MPI_VARIABLES[0]])
        assert shared.parent == place[1] and shared.is_dir()
    assert left(place) == []
    assert os.environ["TMPDIR"] == str(place[0])
    assert MPI_VARIABLES[0] not in os.environ


def test_the_folder_of_a_killed_process_is_removed_by_the_next(place):
    folder = killed(place)
    (folder / "ompi.host.0" / "pid.1").mkdir(parents=True)
    (place[0] / "of another program").mkdir()
    with own_folder():
        assert not folder.exists()
    assert left(place) == ["of another program"]


def test_the_folder_of_a_living_process_or_of_another_machine_stays(place):
    other = killed(place)
    host = other.name.split("-")[1]
    elsewhere = other.rename(other.with_name(other.name.replace(host, "0" * 8)))
    line = [sys.executable, "-c", HOLD.format("print(input('ready\\n'))")]
    with subprocess.Popen(line, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as living:
        assert living.stdout.readline() == "ready\n"
        sweep()
        assert len(list(place[0].iterdir())) == 2 and elsewhere.exists()
        living.communicate("done\n")
    assert left([place[0]]) == [elsewhere.name]


def test_a_link_of_such_a_name_is_not_followed(place, tmp_path):
    name = killed(place).name
    sweep()
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "file").touch()
    (place[0] / name).symlink_to(tmp_path / "mine")
    sweep()
    assert (tmp_path / "mine" / "file").exists()


def test_a_job_ends_at_once_if_its_run_has_ended(place, monkeypatch, finished):
    folder = killed(place)
    assert not run_has_ended()
    monkeypatch.setenv("TMPDIR", str(folder))
    assert run_has_ended()
    line = [sys.executable, "-m", "millscale.workflow.run_job", "none.json", "none"]
    done = subprocess.run(line, cwd=finished.runs, capture_output=True, text=True)
    assert done.returncode == 130
    assert "none: not begun, because the run that queued it has ended" in done.stderr


@pytest.mark.parametrize("victim", ["millscale", "snakemake"])
def test_a_killed_run_leaves_no_temporary_folder_and_no_job(place, finished, wait_for, victim):
    for case_id in SINGLE_BALLS:
        (finished.case(case_id) / "timing.json").unlink()
    series = finished.case(SINGLE_BALLS[0]) / "rotate.part" / "series.csv"
    process = finished.start("run", "--only", SINGLE_BALLS[0], STAND_IN_SECONDS="60")
    wait_for(lambda: series.exists() and len(series.read_text().splitlines()) > 1)
    if victim == "millscale":
        process.kill()
    else:
        (snakemake,) = (
            x for x in psutil.Process(process.pid).children() if "snakemake" in x.cmdline()
        )
        snakemake.kill()
    process.communicate(timeout=60)
    wait_for(lambda: left([place[0]]) == [], 30)
    length = series.stat().st_size
    assert finished("run").returncode == 0 and length > 0
    assert left([place[0]]) == []
