"""Runs the jobs of a campaign with Snakemake, in a runs folder."""

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
_ENDING_S = 30.0


def snakemake_line(jobs: Path, executor: Sequence[str]) -> list[str]:
    """The command that runs the jobs of a file; works in the runs folder.

    Whether a case is done is for its products to say, whether a job is, for its mark: no trigger
    but dates, no mark of incomplete files. The runs folder has its own lock, which cannot go stale.

    Args:
        executor: options of the target.
    """
    return [
        # -P: a module of that name in the runs folder must not be run instead.
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
) -> int:
    """Run Snakemake in a runs folder; returns its exit code.

    Ctrl-C ends the engines and returns when they are gone, by KeyboardInterrupt.

    Args:
        line: of `snakemake_line`.
        lock: descriptor of the lock of `runs`; the workflow inherits it.
        watch: called about once a second.
    """
    with (runs / WORKFLOW_LOG).open("wb") as log, ending_signals_to(interrupt):
        # A session of its own: Ctrl-C reaches this process, which then ends the others in order.
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
            _end(process)
            raise
        if process.returncode < 0:
            # Killed: a job that it had just begun does not know yet that its parent has died.
            _end(process)
    return process.returncode


def _environment() -> dict[str, str]:
    """Of the workflow: no module in the runs folder is run, whoever starts a Python there.

    Python looks up relative entries of its path where it runs, an empty one too.
    """
    entries = filter(None, os.environ.get("PYTHONPATH", "").split(os.pathsep))
    path = os.pathsep.join(str(Path(entry).absolute()) for entry in entries)
    return {**os.environ, "PYTHONPATH": path, "PYTHONUNBUFFERED": "1", "PYTHONSAFEPATH": "1"}


def last_problem(runs: Path) -> str:
    """The last line of Snakemake's log, for a failure that no stage has recorded."""
    lines = read_tail(runs / WORKFLOW_LOG, _TAIL_BYTES).strip().splitlines()
    return one_line(lines[-1]) if lines else "the workflow ended without a word"


def _end(process: subprocess.Popen) -> None:
    """Interrupt Snakemake and its stages; wait until the last one has ended its engine."""
    ignore_ending_signals()
    deadline = time.monotonic() + _ENDING_S
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGINT)
        while time.monotonic() < deadline:
            process.poll()
            os.killpg(process.pid, 0)
            time.sleep(0.1)
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()
