"""The shell scripts of the repository."""

import os
import shutil
import stat
import subprocess
import tempfile
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).parents[2]
SCRIPTS = [
    REPOSITORY / name
    for name in ("scripts/setup", "scripts/test", "scripts/demo", "scripts/notebook", ".ci/run")
]


def test_scripts_pass_shellcheck():
    done = subprocess.run(["shellcheck", *SCRIPTS], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.name)
def test_scripts_are_strict_and_executable(script):
    assert script.stat().st_mode & stat.S_IXUSR
    assert "\nset -euo pipefail\n" in script.read_text()


def command(folder, name, text):
    (folder / name).write_text(f"#!/bin/sh\n{text}\n")
    (folder / name).chmod(0o755)


@pytest.fixture
def bare_machine():
    """Return a copy of scripts/setup on a machine without its packages and without root."""
    folder = Path(tempfile.mkdtemp(prefix="millscale-"))
    folder.chmod(0o777)
    for name in ("scripts", "bin"):
        (folder / name).mkdir(mode=0o755)
    shutil.copy(REPOSITORY / "scripts" / "setup", folder / "scripts")
    command(folder / "bin", "dpkg-query", "exit 1")
    command(folder / "bin", "sudo", "exit 1")
    yield folder
    shutil.rmtree(folder)


def test_without_root_setup_prints_the_one_apt_line_and_changes_nothing(bare_machine):
    drop_root = (
        [] if os.geteuid() else ["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups"]
    )
    done = subprocess.run(
        [*drop_root, str(bare_machine / "scripts" / "setup")],
        env={"PATH": f"{bare_machine / 'bin'}:/usr/bin:/bin"},
        cwd="/",
        capture_output=True,
        text=True,
    )
    assert done.returncode == 1
    apt = [line for line in done.stderr.splitlines() if "apt-get" in line]
    assert len(apt) == 1 and apt[0].startswith("sudo apt-get install -y --no-install-recommends ")
    assert {"liggghts", "libliggghts-dev", "libopenmpi-dev", "cmake", "libegl1"} <= set(
        apt[0].split()
    )
    assert sorted(path.name for path in bare_machine.iterdir()) == ["bin", "scripts"]
