"""Run the jobs of a campaign with Snakemake."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

from millscale.engine.ending_signals import ending_signals_to, ignore_ending_signals, interrupt
from millscale.engine.parent_death import end_with_parent
from millscale.runs.untrusted import read_tail
from millscale.terminal import one_line

SNAKEFILE = Path(__file__).with_name("Snakefile")
WORKFLOW_LOG = "log.workflow"
_TAIL_BYTES = 1 << 16
# Engines that do not end within this time after an interruption are killed [s].
ENDING_S = 30.0


def snakemake_line(jobs: Path, executor: Sequence[str]) -> list[str]:
    """Return the command that runs the jobs of a file; it works in the runs folder.

    A job is done when its .done file exists; the files of a case decide whether a case is. So
    Snakemake uses no trigger but dates and no marks of incomplete files. The runs folder has its
    own lock, which cannot become stale.

    Args:
        executor: options of the target.
    """
    return [
        # -P: do not run a module of that name in the runs folder.
        *(sys.executable, "-P", "-m", "snakemake", "--snakefile", str(SNAKEFILE)),
        *("--rerun-triggers", "mtime", "--max-checksum-file-size", "0"),
        *("--scheduler", "greedy", "--workflow-profile", "none"),
        *("--keep-going", "--nolock", "--ignore-incomplete", "--quiet", "all", "--nocolor"),
        *executor,
        *("--config", f"jobs={jobs}"),
    ]


def run_workflow(
    runs: Path,
    line: list[str],
    lock: int,
    watch: Callable[[], None],
    ending: Callable[[], None] = lambda: None,
) -> int:
    """Run Snakemake in a runs folder; return its exit code.

    Ctrl-C raises KeyboardInterrupt after the engines have ended.

    Args:
        line: of `snakemake_line`.
        lock: descriptor of the lock of `runs`; the workflow inherits it.
        watch: called about once a second.
        ending: called at once after Ctrl-C, before the engines have ended.
    """
    with (runs / WORKFLOW_LOG).open("wb") as log, ending_signals_to(interrupt):
        # In a session of its own, so that Ctrl-C reaches only this process, which ends the others.
        process = subprocess.Popen(
            line,
            cwd=runs,
            env=_environment(),
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=subprocess.STDOUT,
            pass_fds=(lock,),
            start_new_session=True,
            preexec_fn=end_with_parent(signal.SIGKILL),
        )
        try:
            while process.poll() is None:
                watch()
                time.sleep(0.5)
        except BaseException:
            # A second signal would disturb the end, a closed terminal must not.
            ignore_ending_signals()
            with suppress(OSError):
                ending()
            _end(process)
            raise
        if process.returncode < 0:
            # It was killed: a job that it had just begun may not know that its parent has died.
            _end(process)
    return process.returncode


def _environment() -> dict[str, str]:
    """Return the environment of the workflow, in which no Python runs modules of the runs folder.

    Python resolves relative and empty entries of PYTHONPATH in the folder where it runs.
    """
    entries = filter(None, os.environ.get("PYTHONPATH", "").split(os.pathsep))
    path = os.pathsep.join(str(Path(entry).absolute()) for entry in entries)
    return {**os.environ, "PYTHONPATH": path, "PYTHONUNBUFFERED": "1", "PYTHONSAFEPATH": "1"}


def last_problem(runs: Path) -> str:
    """Return the last line of Snakemake's log, for a failure that no stage has recorded."""
    lines = read_tail(runs / WORKFLOW_LOG, _TAIL_BYTES).strip().splitlines()
    return one_line(lines[-1]) if lines else "the workflow ended without a message"


def _end(process: subprocess.Popen) -> None:
    """Interrupt Snakemake and its stages; wait until the last stage has ended its engine."""
    ignore_ending_signals()
    deadline = time.monotonic() + ENDING_S
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGINT)
        while time.monotonic() < deadline:
            process.poll()
            os.killpg(process.pid, 0)
            time.sleep(0.1)
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()
