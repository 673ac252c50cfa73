"""A child process ends with its parent and then frees its lock."""

import os
import signal
import subprocess
import sys
import threading
import time

import psutil
import pytest

from millscale.errors import CampaignError
from millscale.runs.lock import hold
from millscale.workflow.snakemake_run import WORKFLOW_LOG, run_workflow

PARENT = """
import signal, subprocess, sys
from pathlib import Path
from millscale.runs.lock import hold
from millscale.engine.parent_death import end_with_parent
with hold(Path(sys.argv[1])) as lock:
    child = subprocess.Popen(
        [sys.executable, "-c", sys.argv[2]], pass_fds=(lock,), stdout=subprocess.PIPE,
        preexec_fn=end_with_parent(signal.SIGTERM), start_new_session=True)
    child.stdout.readline()
    print(child.pid, flush=True)
    child.wait()
"""
# Ends some time after it got the signal.
CHILD = """
import signal, sys, time
def end(*_):
    time.sleep({delay})
    sys.exit()
signal.signal(signal.SIGTERM, end)
print("ready", flush=True)
time.sleep(60)
"""


@pytest.fixture
def family(tmp_path):
    """Return a function that starts a parent and a child holding the folder's lock."""
    started = []

    def start(delay):
        line = [sys.executable, "-c", PARENT, str(tmp_path), CHILD.format(delay=delay)]
        parent = subprocess.Popen(line, stdout=subprocess.PIPE, text=True)
        child = psutil.Process(int(parent.stdout.readline()))
        started.extend([parent, child])
        return parent, child

    yield start
    for process in started:
        if (
            process.poll() is None
            if isinstance(process, subprocess.Popen)
            else process.is_running()
        ):
            process.kill()


def test_a_child_ends_with_its_parent_however_the_parent_ends(family):
    parent, child = family(delay=0)
    parent.kill()
    parent.wait()
    _, alive = psutil.wait_procs([child], timeout=10)
    assert not alive


def test_the_lock_of_a_killed_process_is_waited_for_while_its_children_end(family, tmp_path):
    parent, child = family(delay=1)
    parent.kill()
    parent.wait()
    begin = time.monotonic()
    with hold(tmp_path):
        assert not child.is_running() or child.status() == psutil.STATUS_ZOMBIE
    assert time.monotonic() - begin > 0.3


def test_the_lock_of_a_living_process_is_not_waited_for(family, tmp_path):
    parent, _ = family(delay=0)
    begin = time.monotonic()
    with pytest.raises(CampaignError, match=f"in use by process {parent.pid} on"), hold(tmp_path):
        pass
    assert time.monotonic() - begin < 5.0


def test_a_living_holder_is_waited_for_as_long_as_asked(family, tmp_path):
    """A stage of a killed command may still be ending when the command is repeated."""
    parent, _ = family(delay=0)
    end = threading.Timer(1.0, parent.kill)
    end.start()
    begin = time.monotonic()
    with hold(tmp_path, patience_s=20.0):
        assert time.monotonic() - begin > 0.5
    end.join()
    parent.wait()


def test_a_job_that_a_killed_workflow_had_just_begun_is_ended(tmp_path):
    """The job does not watch its parent yet, so it does not end with the parent."""
    job = "import time; time.sleep(60)"
    lines = (
        "import os, subprocess, sys",
        f"print(subprocess.Popen([sys.executable, '-c', {job!r}]).pid, flush=True)",
        "os.kill(os.getpid(), 9)",
    )
    lock = os.open(tmp_path / "lock", os.O_CREAT | os.O_RDWR)
    code = run_workflow(tmp_path, [sys.executable, "-c", "\n".join(lines)], lock, lambda: None)
    os.close(lock)
    assert code == -signal.SIGKILL
    begun = int((tmp_path / WORKFLOW_LOG).read_text().split()[0])
    assert not psutil.pid_exists(begun) or psutil.Process(begun).status() == psutil.STATUS_ZOMBIE
