"""Runs the stages of cases with Snakemake, in a runs folder."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from mill_campaign.case import Case
from mill_campaign.machine import Allocation
from mill_campaign.parent_death import end_with_parent
from mill_campaign.stage_table import CASES_FOLDER, STAGES

SNAKEFILE = Path(__file__).with_name("Snakefile")
WORKFLOW_LOG = "log.workflow"
_ENDING_S = 30.0
_ENDINGS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def snakemake_line(cases: Sequence[Case], allocation: Allocation) -> list[str]:
    """The command that brings cases to their results; works in the runs folder.

    Products decide alone: no trigger but their dates, and no mark of incomplete files, as a stage
    renames its products into place. Every product is a target: Snakemake would not miss one that
    only finished stages need. The runs folder has its own lock, which cannot go stale.
    """
    targets = [
        f"{CASES_FOLDER}/{case.id}/{product}"
        for case in cases
        for stage in STAGES[case.kind]
        for product in stage.products
    ]
    options = ["--keep-going", "--nolock", "--ignore-incomplete", "--quiet", "all", "--nocolor"]
    return [
        *(sys.executable, "-m", "snakemake", "--snakefile", str(SNAKEFILE)),
        *("--cores", str(allocation.cores), "--resources", f"case={allocation.jobs}"),
        *("--rerun-triggers", "mtime", "--max-checksum-file-size", "0", "--latency-wait", "0"),
        *("--scheduler", "greedy", "--profile", "none", "--workflow-profile", "none"),
        *("--config", f"ranks={allocation.ranks}"),
        *options,
        *("--", *targets),
    ]


def run_workflow(
    runs: Path,
    cases: Sequence[Case],
    allocation: Allocation,
    lock: int,
    watch: Callable[[], None],
) -> int:
    """Run what is missing of the cases; returns Snakemake's exit code.

    Ctrl-C ends the engines and returns when they are gone, by KeyboardInterrupt.

    Args:
        lock: descriptor of the lock of `runs`; the workflow inherits it.
        watch: called about once a second.
    """
    with (runs / WORKFLOW_LOG).open("wb") as log, _interruptible():
        # A session of its own: Ctrl-C reaches this process, which then ends the others in order.
        process = subprocess.Popen(
            snakemake_line(cases, allocation),
            cwd=runs,
            env={**os.environ, "PYTHONUNBUFFERED": "1"},
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
    return process.returncode


def last_problem(runs: Path) -> str:
    """The last line of Snakemake's log, for a failure that no stage has recorded."""
    lines = (runs / WORKFLOW_LOG).read_text(errors="replace").strip().splitlines()
    return lines[-1].strip() if lines else "the workflow ended without a word"


@contextmanager
def _interruptible() -> Iterator[None]:
    """Let a closed terminal and `kill` end a run as Ctrl-C does.

    Ctrl-C is listed too: a shell makes its background jobs ignore it, and they would hand that
    down to the workflow.
    """

    def interrupt(number: int, frame: object) -> None:
        raise KeyboardInterrupt

    before = {number: signal.signal(number, interrupt) for number in _ENDINGS}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _end(process: subprocess.Popen) -> None:
    """Interrupt Snakemake and its stages; wait until the last one has ended its engine."""
    for number in _ENDINGS:
        signal.signal(number, signal.SIG_IGN)
    deadline = time.monotonic() + _ENDING_S
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGINT)
        while time.monotonic() < deadline:
            process.poll()
            os.killpg(process.pid, 0)
            time.sleep(0.1)
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()
