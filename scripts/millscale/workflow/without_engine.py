"""Runs the stages of cases that need no engine: those before it, and those after a run by hand."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
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
from millscale.workflow.run_job import bring, load
from millscale.workflow.stage_record import read_record


def prepare(ranks: Mapping[Path, int], made: Callable[[int, int], None]) -> tuple[int, list[str]]:
    """Run the stages before the engine of several cases, as many at a time as there are cores.

    Args:
        ranks: MPI ranks to write into mpirun.sh, by case folder.
        made: called with the number of folders made and in all, at the begin and after each.

    Returns:
        How many folders had something to make, and a line for each that could not be made.

    Raises:
        CampaignError: a process was killed.
        KeyboardInterrupt: interrupted; what is made stays.
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
            cause = "a process that made its folders was killed"
            raise CampaignError("millscale generate", "", cause, "the same command again") from None
        except BaseException:
            executor.shutdown(wait=True, cancel_futures=True)
            raise
    return len(waiting), failed


def finish(runs: Path) -> list[str]:
    """Take over what was run by hand in the cases of a runs folder, and analyse it.

    Returns:
        A line for each case in which something that was run by hand cannot be used.
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
            # The report says so itself.
            continue
        if there or (rotated and left):
            problem = _brought(folder, 1, lambda stage, folder=folder: _needs_engine(folder, stage))
            problems += [problem] if problem else []
    return problems


def _needs_engine(folder: Path, stage: Stage) -> bool:
    return stage.name != "result" and not is_there(folder, stage)


def _brought(folder: Path, ranks: int, stop: Callable[[Stage], bool]) -> str:
    """Run the stages that a case still needs, up to one; returns why one failed, or nothing.

    Raises:
        KeyboardInterrupt: interrupted.
    """
    try:
        code = bring(folder, ranks, stop)
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
    """Whether a stage before the engine is to be run."""
    left = unfinished(folder, load_case(folder).kind)
    return bool(left) and not _is_later(left[0][0])


def _is_later(stage: Stage) -> bool:
    return bool(stage.deck) or stage.name == "result"


def _begin() -> None:
    end_with_parent()()


def _prepare(folder: Path, ranks: int) -> str:
    return _brought(folder, ranks, _is_later)
