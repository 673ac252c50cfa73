"""A small campaign, generated, finished or begun, for every test of the command line."""

import shutil
import time

import pytest

from small_command import small


@pytest.fixture
def millscale(tmp_path):
    """Nothing generated yet."""
    return small(tmp_path)


@pytest.fixture(scope="session")
def finished_once(tmp_path_factory):
    command = small(tmp_path_factory.mktemp("finished"))
    done = command("run")
    assert done.returncode == 0, done.stdout + done.stderr
    return command


@pytest.fixture
def finished(finished_once, tmp_path):
    """A copy of a finished run, dates included."""
    shutil.copytree(finished_once.runs, tmp_path / "runs", symlinks=True)
    return small(tmp_path)


@pytest.fixture(scope="session")
def wait_for():
    """Waits until a function gives something true, and returns it."""

    def wait(condition, seconds=60.0):
        deadline = time.monotonic() + seconds
        while not (found := condition()):
            assert time.monotonic() < deadline, "waited in vain"
            time.sleep(0.02)
        return found

    return wait
