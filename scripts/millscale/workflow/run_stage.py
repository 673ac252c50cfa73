"""Run one stage of a case: `python -m millscale.workflow.run_stage STAGE CASE_FOLDER [--ranks N]`.

A stage writes into CASE_FOLDER/STAGE.part and moves its products into the case folder at the end,
so that a failed or interrupted stage leaves no product. An engine stage resumes from the files of
an earlier attempt in that folder. Output goes to out.STAGE.
"""

from __future__ import annotations

import argparse
import os
import shutil
import signal
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path

from millscale.engine import provenance
from millscale.engine.ending_signals import INTERRUPTED, interrupt_once_on_ending_signals
from millscale.engine.environment import TIME_LIMIT_VARIABLE
from millscale.engine.log import error_line, read_log
from millscale.engine.machine import Spread
from millscale.engine.parent_death import end_with_parent
from millscale.engine.resume import OF_ATTEMPTS
from millscale.engine.temporary_folder import own_folder
from millscale.errors import CampaignError
from millscale.runs.case_file import load_case
from millscale.runs.layout import STAGES, stage_of
from millscale.runs.lock import hold
from millscale.runs.provenance import read_provenance, write_provenance
from millscale.runs.untrusted import RunFolderError
from millscale.terminal import escape_unencodable
from millscale.workflow import failures, stage_record
from millscale.workflow.by_hand import HandRun, check_replaced, hand_provenance, is_there, take_over
from millscale.workflow.stage_work import WORK, Task, is_complete, provenance_of

# A stage of a killed command ends within seconds; a repeated command waits for it [s].
PATIENCE_S = 10.0


def run_stage(folder: Path, name: str, ranks: int = 1, spread: Spread | None = None) -> int:
    """Run one stage; return 0, or 1 if it failed, or 130 if it was interrupted.

    Args:
        folder: case folder with its case.json.
        ranks: MPI ranks, for the stages that run the engine.
        spread: nodes of a batch job for the ranks; None for ranks on this machine.
    """
    case = load_case(folder)
    stage = stage_of(case.kind, name)
    with hold(folder, patience_s=PATIENCE_S) as lock:
        record, kills = stage_record.begin(folder, name, case.digest), failures.memory_kills()
        task = Task(stage, case, folder, ranks, lock, spread)
        try:
            with _output_to(task.screen):
                _make(task)
        except KeyboardInterrupt:
            stage_record.end(folder, record, "interrupted")
            return INTERRUPTED
        except Exception as error:
            failure = failures.diagnose(error, folder, name, failures.memory_kills() - kills)
            record = replace(record, kind=failure.kind, advice=failure.advice)
            log = _log_of(task)
            stage_record.end(folder, record, "failed", failure.cause, log)
            return 1
        stage_record.end(folder, record, "done")
    if task.screen.stat().st_size == 0:
        task.screen.unlink()
    return 0


def _make(task: Task) -> None:
    """Do the work of a stage in its part folder, then move its files into the case folder."""
    by_hand = None
    check_replaced(task.folder, task.case, task.stage)
    if task.stage.deck and is_complete(task):
        print("complete before: only its products had to be moved", flush=True)
    elif is_there(task.folder, task.stage):
        by_hand = take_over(task)
    else:
        _work(task)
    if by_hand or all((task.part / x).exists() for x in task.stage.products):
        _record_provenance(task, by_hand)
    _publish(task)
    shutil.rmtree(task.part)


def _work(task: Task) -> None:
    for product in task.stage.products:
        (task.folder / product).unlink(missing_ok=True)
    if not task.stage.deck:
        shutil.rmtree(task.part, ignore_errors=True)
    task.part.mkdir(exist_ok=True)
    try:
        provenance.check_inputs(task.folder, task.stage.inputs)
        WORK[task.stage.name](task)
        missing = [x for x in task.stage.products if not (task.part / x).exists()]
        if missing:
            raise RuntimeError(f"stage {task.stage.name} ended without {', '.join(missing)}")
    except Exception:
        traceback.print_exc()
        raise
    finally:
        log = task.part / task.log
        if log.exists():
            log.replace(task.folder / task.log)


def _record_provenance(task: Task, by_hand: HandRun | None) -> None:
    # The log shows whether this engine has run: not one of an earlier run, nor one made by hand.
    log = (task.folder if task.stage.deck and not by_hand else task.part) / task.log
    files = _made(task)
    if by_hand:
        files |= {name: task.folder / name for name in by_hand.files}
    made = provenance_of(task, files, log)
    if by_hand:
        made = hand_provenance(made, by_hand, task.stage.name)
    write_provenance(task.part, read_provenance(task.folder) | {task.stage.name: made})


def _made(task: Task) -> dict[str, Path]:
    """Return the files of the stage, by name, without links to inputs and files of attempts."""
    return {
        path.name: path
        for path in task.part.iterdir()
        if not path.is_symlink() and path.name not in OF_ATTEMPTS
    }


def _publish(task: Task) -> None:
    """Move the files of the stage into the case folder, its products last and in their order."""
    made, products = _made(task), list(task.stage.products)
    for name in [*sorted(set(made).difference(products)), *(x for x in products if x in made)]:
        target = task.folder / name
        if target.is_dir():
            shutil.rmtree(target)
        (task.part / name).replace(target)


def _log_of(task: Task) -> str:
    """Return the name of the file that explains a failure best."""
    in_log = task.stage.deck and error_line(read_log(task.folder / task.log))
    return task.log if in_log else task.screen.name


@contextmanager
def _output_to(path: Path) -> Iterator[None]:
    """Redirect the output of this process, its children and C libraries to a file."""
    sys.stdout.flush()
    sys.stderr.flush()
    saved = os.dup(1), os.dup(2)
    with path.open("wb") as file:
        os.dup2(file.fileno(), 1)
        os.dup2(file.fileno(), 2)
    try:
        yield
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        for descriptor, original in zip((1, 2), saved, strict=True):
            os.dup2(original, descriptor)
            os.close(original)


def limit_time() -> None:
    """Let the stage that begins now fail at its time limit."""
    limit = float(os.environ.get(TIME_LIMIT_VARIABLE, 0.0))

    def too_long(number: int, frame: object) -> None:
        raise failures.TimeLimitError(f"longer than the time limit of {limit:g} s")

    signal.signal(signal.SIGALRM, too_long)
    signal.setitimer(signal.ITIMER_REAL, limit)


def main() -> int:
    names = sorted({stage.name for stages in STAGES.values() for stage in stages})
    parser = argparse.ArgumentParser(
        prog="python -m millscale.workflow.run_stage", description=__doc__
    )
    parser.add_argument("stage", choices=names)
    parser.add_argument("folder", type=Path, help="case folder with case.json")
    parser.add_argument("--ranks", type=int, default=1, help="MPI ranks of the engine")
    options = parser.parse_args()
    escape_unencodable()
    interrupt_once_on_ending_signals()
    limit_time()
    end_with_parent()()
    with suppress(KeyboardInterrupt):
        try:
            with own_folder():
                code = run_stage(options.folder, options.stage, options.ranks)
        except (CampaignError, RunFolderError) as error:
            print(f"error: {error}", file=sys.stderr)
            return 2
        record = stage_record.read_record(options.folder)
        if code == 1 and record:
            print(f"{record.stage} failed: {record.cause}; see {record.log}", file=sys.stderr)
            print(f"to do: {record.advice}", file=sys.stderr)
        return code
    return INTERRUPTED


if __name__ == "__main__":
    sys.exit(main())
