"""The start of a process."""

import os
import subprocess
import sys
import time

import psutil

from millscale.engine.process_start import process_start


def test_it_is_the_same_seen_from_any_process():
    line = "from millscale.engine.process_start import process_start; import sys"
    line += "; print(process_start(int(sys.argv[1])))"
    seen = subprocess.run([sys.executable, "-c", line, str(os.getpid())], capture_output=True)
    assert int(seen.stdout) == process_start(os.getpid())


def test_it_does_not_move_with_the_clock_of_the_machine(monkeypatch):
    """The date that psutil derives from it does."""
    boot, date = psutil.boot_time(), psutil.Process().create_time()
    start = process_start(os.getpid())
    monkeypatch.setattr("psutil._pslinux.boot_time", lambda: boot + 1.0)
    assert psutil.Process().create_time() == date + 1.0
    assert process_start(os.getpid()) == start


def test_a_name_with_brackets_and_spaces_is_read(tmp_path):
    program = tmp_path / "a) (b 1 2"
    program.symlink_to("/bin/sleep")
    begin = time.clock_gettime(time.CLOCK_BOOTTIME)
    with subprocess.Popen([program, "60"]) as process:
        try:
            started = process_start(process.pid) / os.sysconf("SC_CLK_TCK")
        finally:
            process.kill()
    assert begin - 0.02 <= started <= time.clock_gettime(time.CLOCK_BOOTTIME)
    assert process_start(process.pid) is None
