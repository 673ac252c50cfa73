"""Run the stages without engine: those before it, and those after a run by hand."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from functools import partial
from multiprocessing import get_context
from pathlib import Path

from millscale.cases.generate import read_summary
from millscale.engine.ending_signals import INTERRUPTED
from millscale.engine.machine import available_cores
from millscale.engine.parent_death import end_with_parent
from millscale.errors import CampaignError
from millscale.runs.case_file import load_case
from millscale.runs.current import unfinished
from millscale.runs.layout import CASES_FOLDER, STAGES, Stage
from millscale.runs.untrusted import RunFolderError
from millscale.workflow.by_hand import is_recorded, is_there
from millscale.workflow.run_job import load, run_case
from millscale.workflow.stage_record import read_record


def prepare(ranks: Mapping[Path, int], made: Callable[[int, int], None]) -> tuple[int, list[str]]:
    """Run the stages before the engine of several cases, one case on each core.

    Args:
        ranks: MPI ranks to write into mpirun.sh, by case folder.
        made: called with the numbers of finished and of all folders, at the begin and after each.

    Returns:
        The number of folders that were incomplete, and a line for each that failed.

    Raises:
        CampaignError: a process was killed.
        KeyboardInterrupt: interrupted; finished folders stay.
    """
    waiting = [folder for folder in ranks if _is_left(folder)]
    if not waiting:
        return 0, []
    load()
    failed = []
    workers = min(available_cores(), len(waiting))
    with ProcessPoolExecutor(
        workers, mp_context=get_context("fork"), initializer=_begin
    ) as executor:
        futures = {executor.submit(_prepare, x, ranks[x]): x for x in waiting}
        try:
            made(0, len(waiting))
            for count, future in enumerate(as_completed(futures), 1):
                if problem := future.result():
                    failed.append(problem)
                made(count, len(waiting))
        except BrokenProcessPool:
            cause = "a process that wrote folders was killed"
            raise CampaignError("millscale generate", "", cause, "the same command again") from None
        except BaseException:
            executor.shutdown(wait=True, cancel_futures=True)
            raise
    return len(waiting), failed


def finish(runs: Path) -> list[str]:
    """Take over and analyse the results that were made by hand in a runs folder.

    Returns:
        A line for each case whose results made by hand cannot be used.
    """
    problems = []
    for case_id in read_summary(runs)["cases"]:
        folder = runs / CASES_FOLDER / case_id
        try:
            case = load_case(folder)
            left = [stage for stage, _ in unfinished(folder, case.kind)]
            there = [stage for stage in left if stage.deck and is_there(folder, stage)]
            rotated = any(is_recorded(folder, x) for x in STAGES[case.kind])
        except (CampaignError, RunFolderError, KeyError):
            # The report names this case.
            continue
        if there or (rotated and left):
            problem = _run_up_to(folder, 1, partial(_needs_engine, folder))
            problems += [problem] if problem else []
    return problems


def _needs_engine(folder: Path, stage: Stage) -> bool:
    return stage.name != "result" and not is_there(folder, stage)


def _run_up_to(folder: Path, ranks: int, stop: Callable[[Stage], bool]) -> str:
    """Run the stages that a case still needs, up to a stage; return why one failed, or nothing.

    Raises:
        KeyboardInterrupt: interrupted.
    """
    try:
        code = run_case(folder, ranks, stop)
    except (CampaignError, RunFolderError, OSError) as error:
        return f"{folder.name}: {error}"
    if code == INTERRUPTED:
        raise KeyboardInterrupt
    record = read_record(folder)
    if not code or not record:
        return ""
    cause = f"{record.stage} failed: {record.cause}"
    return f"{folder.name}: {cause}; see {folder / record.log}; to do: {record.advice}"


def _is_left(folder: Path) -> bool:
    """Return whether a stage before the engine has to run."""
    left = unfinished(folder, load_case(folder).kind)
    return bool(left) and not _is_later(left[0][0])


def _is_later(stage: Stage) -> bool:
    return bool(stage.deck) or stage.name == "result"


def _begin() -> None:
    end_with_parent()()


def _prepare(folder: Path, ranks: int) -> str:
    return _run_up_to(folder, ranks, _is_later)
