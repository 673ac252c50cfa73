"""What the commands of `millscale` share: arguments and options, exit codes, the console."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from millscale.errors import CampaignError
from millscale.workflow.targets import TARGETS

EXIT_FAILED = 1
EXIT_WRONG_INPUT = 2
_WIDTH = 140

Campaign = Annotated[
    Path, typer.Argument(metavar="FILE", help="Campaign file, such as campaigns/quick.toml.")
]
RunsArgument = Annotated[
    Path, typer.Argument(metavar="DIR", help="Runs folder, as given to `millscale run --runs`.")
]
RunsOption = Annotated[
    Path,
    typer.Option(
        "--runs", metavar="DIR", help="Folder of the runs; each case works in DIR/cases/ID."
    ),
]
RunsArguments = Annotated[
    list[Path], typer.Argument(metavar="DIR...", help="Runs folders of finished campaigns.")
]
CaseArgument = Annotated[
    Path, typer.Argument(metavar="CASE", help="Case folder, such as runs/quick/cases/ID.")
]
CasesArgument = Annotated[
    list[Path], typer.Argument(metavar="CASE...", help="Folders of finished multi-ball cases.")
]
Ranks = Annotated[
    int | None,
    typer.Option(
        metavar="N",
        help="MPI ranks of a multi-ball case; single balls take one. Default: the campaign's.",
    ),
]
Jobs = Annotated[
    int | None, typer.Option(metavar="M", help="Cases at a time. Default: the campaign's.")
]
Only = Annotated[
    list[str] | None,
    typer.Option(metavar="ID", help="Only this case; repeatable; `*` stands for any text."),
]
DryRun = Annotated[
    bool, typer.Option("--dry-run", help="Show the stages and the mpirun lines; write nothing.")
]
Oversubscribe = Annotated[
    bool, typer.Option("--oversubscribe", help="Allow more ranks x jobs than there are cores.")
]
IgnoreDisk = Annotated[
    bool, typer.Option("--ignore-disk", help="Run even if the disk seems too small.")
]
TimeLimit = Annotated[
    float | None,
    typer.Option(
        metavar="S", help="Longest wall time of a stage [s]; it then ends and has failed."
    ),
]
StartOver = Annotated[
    bool,
    typer.Option(
        "--start-over", help="Begin stages that ended early anew, on any number of ranks."
    ),
]
_PLACES = ", ".join(f"{name} ({target.about})" for name, target in TARGETS.items())
TargetName = Annotated[
    str, typer.Option("--target", metavar="NAME", help=f"Where the cases run: {_PLACES}.")
]
Slurm = Annotated[
    bool, typer.Option("--slurm", help="Short for --target slurm; see docs/guide/slurm.md.")
]
Profile = Annotated[
    Path | None,
    typer.Option(
        metavar="DIR", help="Folder with config.yaml of a cluster, such as profiles/slurm."
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print JSON, in SI units, and nothing else.")]


# Times of options [s]; the system's timers count no more than some centuries.
SHORTEST_S, LONGEST_S = 0.1, 1e9


def check_seconds(command: str, option: str, seconds: float) -> None:
    """Refuse a wall time that is none.

    Raises:
        CampaignError: says what is accepted.
    """
    if not SHORTEST_S <= seconds <= LONGEST_S:
        accepted = f"{SHORTEST_S:g} to {LONGEST_S:g} s"
        raise CampaignError(f"millscale {command}", option, f"got {seconds:g}", accepted)


def check_at_least(command: str, option: str, value: int, least: int) -> None:
    """Refuse a number that is too small.

    Raises:
        CampaignError: states what is accepted.
    """
    if value < least:
        raise CampaignError(f"millscale {command}", option, f"got {value}", f">= {least}")


def console_of(stderr: bool = False) -> Console:
    """Tables of a pipe or a file are not cut to the width of a terminal that is not there."""
    shown = sys.stderr if stderr else sys.stdout
    return Console(stderr=stderr) if shown.isatty() else Console(stderr=stderr, width=_WIDTH)
