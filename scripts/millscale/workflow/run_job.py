"""Run the cases of a job: `python -m millscale.workflow.run_job JOBS_FILE JOB`, for Snakemake.

It works in a runs folder. Cases run one after the other, each in a child process that is forked
after all modules are loaded. So a case costs no start of Python, and a case that crashes its
process does not stop the others. Finished stages are skipped, so a job can be ended and repeated.

Exit codes: 0 every case has a result or a failure in stage.json; 1 a case has neither; 130
interrupted.
"""

from __future__ import annotations

import argparse
import importlib
import os
import signal
import sys
import traceback
from collections.abc import Callable
from functools import partial
from pathlib import Path

from millscale.engine.ending_signals import (
    INTERRUPTED,
    ending_signals_to,
    interrupt_once_on_ending_signals,
)
from millscale.engine.machine import Spread
from millscale.engine.parent_death import end_with_parent
from millscale.engine.temporary_folder import own_folder, run_has_ended
from millscale.errors import CampaignError
from millscale.runs.case_file import load_case
from millscale.runs.current import unfinished
from millscale.runs.layout import CASES_FOLDER, STAGES, Stage
from millscale.runs.untrusted import RunFolderError
from millscale.terminal import escape_unencodable
from millscale.workflow.jobs import job_named, read_jobs
from millscale.workflow.run_stage import limit_time, run_stage
from millscale.workflow.targets import spread_of

FAILED = 1
REPORTED = 2  # the child has printed the error


def run_case(
    folder: Path,
    ranks: int,
    stop: Callable[[Stage], bool] = lambda stage: False,
    spread: Spread | None = None,
) -> int:
    """Run the stages that a case still needs; return the exit code of the last one.

    Args:
        folder: case folder.
        ranks: MPI ranks, for the stages that run the engine.
        stop: function of a stage; return true to end before it.
        spread: nodes of a batch job for the ranks; None for ranks on this machine.
    """
    kind = load_case(folder).kind
    for stage in STAGES[kind]:
        # Checked before each stage: the stage before may have changed the files it reads.
        if all(left != stage for left, _ in unfinished(folder, kind)):
            continue
        if stop(stage):
            break
        limit_time()
        code = run_stage(folder, stage.name, ranks, spread)
        if code:
            return code
    return 0


def run_job(folders: list[Path], ranks: int, spread: Spread | None = None) -> int:
    """Run the cases of a job; return the exit code of the module's docstring."""
    if len(folders) > 1:
        load()
    lost = False
    for folder in folders:
        code = _in_child(partial(run_case, folder, ranks, spread=spread))
        if code == INTERRUPTED:
            print(f"{folder.name}: ended by a signal", file=sys.stderr)
            return INTERRUPTED
        if code not in (0, FAILED):
            if code != REPORTED:
                print(f"{folder.name}: its process ended with {code}", file=sys.stderr)
            lost = True
    return 1 if lost else 0


def load() -> None:
    """Load the modules that the stages use, once for all cases."""
    for module in ("packing.charge", "cases.parameters", "cases.wall_panels", "analysis.case"):
        importlib.import_module(f"millscale.{module}")


def _in_child(work: Callable[[], int]) -> int:
    """Call a function in a child process; return its code, or minus the signal that ended it."""
    sys.stdout.flush()
    sys.stderr.flush()
    child = os.fork()
    if child == 0:
        os._exit(_guarded(work))
    interrupted = False

    def hand_on(number: int, frame: object) -> None:
        nonlocal interrupted
        interrupted = True
        os.kill(child, signal.SIGTERM)

    with ending_signals_to(hand_on):
        _, status = os.waitpid(child, 0)
    return INTERRUPTED if interrupted else os.waitstatus_to_exitcode(status)


def _guarded(work: Callable[[], int]) -> int:
    """Call a function in the child; return an exit code whatever happens."""
    end_with_parent()()
    interrupt_once_on_ending_signals()
    try:
        return work()
    except KeyboardInterrupt:
        return INTERRUPTED
    except (CampaignError, RunFolderError) as error:
        print(f"error: {error}", file=sys.stderr)
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
    return REPORTED


def main() -> int:
    parser = argparse.ArgumentParser(
        prog="python -m millscale.workflow.run_job", description=__doc__
    )
    parser.add_argument("file", type=Path, help="DIR/.jobs/<run>/jobs.json")
    parser.add_argument("job", help="name of a job in it")
    options = parser.parse_args()
    escape_unencodable()
    end_with_parent()()
    if run_has_ended():
        ended = "not begun, because the run that queued it has ended"
        print(f"{options.job}: {ended}", file=sys.stderr)
        return INTERRUPTED
    job = job_named(read_jobs(options.file), options.job)
    spread = spread_of(job.ranks, job.nodes)
    with own_folder():
        return run_job([Path(CASES_FOLDER) / case for case in job.cases], job.ranks, spread)


if __name__ == "__main__":
    sys.exit(main())
