"""Running a campaign from Python, with a progress bar in notebooks."""

from __future__ import annotations

import os
import shlex
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from os import PathLike
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import Progress

from millscale.api.planning import DICTIONARY, CampaignSource
from millscale.api.runs_folder import Folder, RunsFolder
from millscale.campaign.build import campaign_of
from millscale.campaign.writer import toml_text
from millscale.cases.generate import CAMPAIGN_COPY
from millscale.engine.environment import COMMAND_VARIABLE
from millscale.engine.machine import Allocation, CoreWish
from millscale.errors import EngineError
from millscale.runs.case_file import Case
from millscale.workflow.display import Paced, Statuses, Watch, problems
from millscale.workflow.run_command import check_free_disk, request, run_campaign
from millscale.workflow.run_progress import Bar, RunProgress
from millscale.workflow.snakemake_run import WORKFLOW_LOG
from millscale.workflow.status import campaign_status

# Keys of a liner that name a file.
DRAWINGS = ("profile", "stl")
_WIDTH = 140
_PLAIN: Any = {"force_jupyter": False, "force_terminal": False}
_REFRESH_S = 1.0


def run(
    campaign: CampaignSource,
    runs: Folder,
    *,
    ranks: int | None = None,
    jobs: int | None = None,
    only: str | Sequence[str] = (),
    start_over: bool = False,
    ignore_disk: bool = False,
    quiet: bool = False,
) -> RunsFolder:
    """Run every case of a campaign whose results are missing, on this machine, and open the folder.

    After an interruption the same call resumes. A notebook shows a progress bar.

    Args:
        campaign: a campaign file, or its content as a dictionary of sections.
        runs: the runs folder, such as "runs/mine".
        ranks: MPI ranks of a multi-ball case; None: those of the campaign.
        jobs: cases that run at a time; None: those of the campaign.
        only: ids of the cases to run; `*` stands for any text. Empty: all.
        start_over: begin interrupted stages again.
        ignore_disk: run although the disk may be too small.
        quiet: show no progress.

    Raises:
        CampaignError: the campaign or an option is not accepted; nothing was run.
        EngineError: a case failed; the others are finished.
    """
    runs = Path(runs)
    patterns = [only] if isinstance(only, str) else list(only)
    with _campaign_file(campaign) as file:
        asked = request(file, runs, patterns, CoreWish(ranks, jobs), start_over=start_over)
        if not ignore_disk:
            check_free_disk(asked)
        is_copy = isinstance(campaign, Mapping)
        line = ["run", str(runs / CAMPAIGN_COPY if is_copy else file), "--runs", str(runs)]
        with _recorded(shlex.join(["millscale", *line])), _output(quiet) as console:
            show = {"show": in_notebook} if is_notebook() and not quiet else {}
            done = run_campaign(asked, console, **show)
    if not done:
        found = problems(runs, campaign_status(runs))
        raise EngineError("; ".join(found) or f"not all cases were run: see {runs / WORKFLOW_LOG}")
    return RunsFolder(runs)


def is_notebook() -> bool:
    """Return whether the code runs in the kernel of a notebook."""
    module = sys.modules.get("IPython")
    shell = module.get_ipython() if module else None
    return getattr(shell, "kernel", None) is not None


@contextmanager
def in_notebook(
    console: Console, runs: Path, cases: Sequence[Case], allocation: Allocation
) -> Iterator[Watch]:
    """Yield a function that shows the progress of the cases in a notebook; call it often."""
    from IPython.display import display

    statuses, progress = Statuses(runs, cases), RunProgress(cases, allocation)
    bar = Bar(progress)

    def now() -> Progress:
        progress.update(statuses())
        return bar.update()

    shown = display(now(), display_id=True)
    yield Paced(_REFRESH_S, lambda: shown.update(now()))
    shown.update(now())


@contextmanager
def _campaign_file(campaign: CampaignSource) -> Iterator[Path]:
    """Yield the campaign file; that of a dictionary is removed at the end, and the runs folder has
    a copy of it."""
    if not isinstance(campaign, Mapping):
        yield Path(campaign)
        return
    name = campaign_of(DICTIONARY, campaign).name
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"{name}.toml"
        file.write_text(toml_text(_with_whole_paths(campaign)), encoding="utf-8")
        yield file


def _with_whole_paths(content: Any) -> Any:
    """Return the content of a campaign whose drawings are found from any folder."""
    if isinstance(content, Mapping):
        return {
            key: str(Path(value).absolute())
            if key in DRAWINGS and isinstance(value, str | PathLike)
            else _with_whole_paths(value)
            for key, value in content.items()
        }
    return [_with_whole_paths(x) for x in content] if isinstance(content, list) else content


@contextmanager
def _output(quiet: bool) -> Iterator[Console]:
    if not quiet:
        # The output of a kernel states that it is a terminal.
        plain = is_notebook() or not sys.stdout.isatty()
        yield Console(width=_WIDTH, **_PLAIN) if plain else Console()
        return
    with Path(os.devnull).open("w", encoding="utf-8") as nowhere:
        yield Console(file=nowhere, width=_WIDTH, **_PLAIN)


@contextmanager
def _recorded(command: str) -> Iterator[None]:
    """Let provenance.json record an equal command line."""
    before = os.environ.get(COMMAND_VARIABLE)
    os.environ[COMMAND_VARIABLE] = before or command
    try:
        yield
    finally:
        if before is None:
            del os.environ[COMMAND_VARIABLE]
