"""Makes case folders complete: mesh, charge and decks, up to where the engine begins."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from itertools import takewhile
from multiprocessing import get_context
from pathlib import Path

from mill_campaign.case_check import read_case
from mill_campaign.errors import CampaignError
from mill_campaign.job import INTERRUPTED, load
from mill_campaign.machine import available_cores
from mill_campaign.parent_death import end_with_parent
from mill_campaign.stage_record import read_record
from mill_campaign.stages import run_stage
from mill_runs.current import unfinished
from mill_runs.layout import CASE_FILE


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
    waiting = [folder for folder in ranks if _left(folder)]
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


def _left(folder: Path) -> list[str]:
    """Names of the stages to run before the engine."""
    left = unfinished(folder, read_case(folder / CASE_FILE)["kind"])
    return [stage.name for stage, _ in takewhile(lambda x: not x[0].deck, left)]


def _begin() -> None:
    end_with_parent()()


def _prepare(folder: Path, ranks: int) -> str:
    """Run the stages of a case before the engine; returns why one failed, empty if none did."""
    for name in _left(folder):
        try:
            code = run_stage(folder, name, ranks)
        except CampaignError as error:
            return f"error: {error}"
        if code == INTERRUPTED:
            raise KeyboardInterrupt
        record = read_record(folder)
        if code and record:
            log = folder / record.log
            return (
                f"{folder.name}: {name} failed: {record.cause}; see {log}; to do: {record.advice}"
            )
    return ""
