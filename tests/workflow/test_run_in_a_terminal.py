"""`millscale run` in a terminal: the bar, the case that runs, Ctrl-C."""

import fcntl
import os
import pty
import re
import signal
import subprocess
import sys
import termios
import threading
import time
from pathlib import Path

import pytest

from small_campaign import CHARGE, SINGLE_BALLS

CONTROL = re.compile(r"\x1b\[[0-9;?]*[A-Za-z]|\r")
WIDTH = 100


class Terminal:
    """A command in a terminal of its own, and what it has written so far."""

    def __init__(self, line, environment):
        self._screen, child = pty.openpty()
        termios.tcsetwinsize(child, (30, WIDTH))
        self.process = subprocess.Popen(
            line,
            env={**environment, "TERM": "xterm"},
            stdin=child,
            stdout=child,
            stderr=child,
            start_new_session=True,
            preexec_fn=self._begin,
        )
        os.close(child)
        self._parts = []
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    @staticmethod
    def _begin():
        fcntl.ioctl(0, termios.TIOCSCTTY, 0)
        # Ignored if the tests run in the background of a shell.
        signal.signal(signal.SIGINT, signal.SIG_DFL)

    def _read(self):
        while True:
            try:
                part = os.read(self._screen, 65536)
            except OSError:
                return
            if not part:
                return
            self._parts.append(part)

    @property
    def text(self):
        return CONTROL.sub("", b"".join(self._parts).decode(errors="replace"))

    def press(self, keys):
        os.write(self._screen, keys)

    def end(self, seconds=60):
        code = self.process.wait(seconds)
        self._reader.join(seconds)
        os.close(self._screen)
        return code


@pytest.fixture
def terminal(finished):
    """Return a function that starts `millscale run` for cases whose rotation is missing."""
    started = []

    def start(*ids, seconds):
        for case_id in ids:
            (finished.case(case_id) / "timing.json").unlink()
        line = [sys.executable, "-m", "millscale", *finished.line("run")]
        environment = finished.environment(STAND_IN_SECONDS=seconds)
        environment.pop("COLUMNS", None)
        started.append(Terminal(line, environment))
        return started[-1]

    yield start
    for one in started:
        if one.process.poll() is None:
            one.process.terminate()
            one.process.wait(60)


def test_a_bar_and_the_running_case_first_are_shown(terminal):
    shown = terminal(CHARGE, SINGLE_BALLS[1], seconds="3")
    assert shown.end() == 0
    text = shown.text
    assert "2 cases to run, " in text and " predicted" in text
    assert "starting, 1 of 3 cases done" in text
    frames = [frame.splitlines() for frame in re.split(r"(?=\d of 3 cases done)", text)]
    running = [lines for lines in frames if " running" in lines[0]]
    assert running
    for lines in running:
        assert "━" in lines[0] and len(lines[0]) <= WIDTH
        assert lines[1].split()[0] == "case" and lines[2].split()[1] in ("running", "starting")
    # The bar is gone at the end; the table and the next command stay.
    assert "next: millscale report" in text.splitlines()[-1]
    assert "1 cases" not in text and "error -" not in text


def test_ctrl_c_is_answered_before_the_engines_have_ended(terminal, finished, wait_for):
    shown = terminal(CHARGE, seconds="60")
    series = finished.case(CHARGE) / "rotate.part" / "series.csv"
    wait_for(lambda: series.exists() and len(series.read_text().splitlines()) > 1)
    shown.press(b"\x03")
    begin = time.monotonic()
    wait_for(lambda: "ending the running cases, within 30 s" in shown.text)
    answered = time.monotonic() - begin
    assert shown.end() == 130
    took = time.monotonic() - begin
    print(f"answered after {answered:.2f} s, ended after {took:.2f} s")
    first, _, second = shown.text.partition("ending the running cases")
    assert "interrupted: finished stages are kept; repeat the command to resume" in second
    assert "interrupted" not in first
    # 0.1 s on an idle machine.
    assert answered < 5.0
    assert finished("run").returncode == 0


@pytest.mark.parametrize("delay", [0.0, 0.5, 1.0])
def test_ctrl_c_during_the_start_ends_without_a_traceback(terminal, wait_for, delay):
    shown = terminal(CHARGE, seconds="60")
    # Python itself has started, and modules of the command are being loaded.
    maps = Path("/proc") / str(shown.process.pid) / "maps"
    wait_for(lambda: "_core" in maps.read_text(errors="replace"))
    time.sleep(delay)
    shown.press(b"\x03")
    # 1: click's own "Aborted.", while it reads the options.
    assert shown.end() in (1, 130, -signal.SIGINT)
    assert "Traceback" not in shown.text
