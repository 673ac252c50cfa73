"""Arguments, options, exit codes and the console that several commands use."""

from __future__ import annotations

import os
import shlex
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console, RenderableType

from millscale.engine.ending_signals import INTERRUPTED
from millscale.engine.environment import COMMAND_VARIABLE
from millscale.errors import CampaignError
from millscale.workflow.targets import TARGETS

EXIT_FAILED = 1
EXIT_WRONG_INPUT = 2
_WIDTH = 140
_WIDEST = 100_000

Campaign = Annotated[
    Path, typer.Argument(metavar="FILE", help="Campaign file, such as campaigns/quick.toml.")
]
RunsArgument = Annotated[
    Path, typer.Argument(metavar="DIR", help="Runs folder, as given to `millscale run --runs`.")
]
RunsOption = Annotated[
    Path,
    typer.Option("--runs", metavar="DIR", help="Runs folder; a case is in DIR/cases/ID."),
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
        help="MPI ranks of a multi-ball case; a single ball has one. Default: the campaign's.",
    ),
]
Jobs = Annotated[
    int | None, typer.Option(metavar="M", help="Cases that run at a time. Default: the campaign's.")
]
Nodes = Annotated[
    int | None,
    typer.Option(
        metavar="N",
        help="Nodes of a batch system for a multi-ball case. Default: as few as its ranks need.",
    ),
]
Only = Annotated[
    list[str] | None,
    typer.Option(metavar="ID", help="Run only this case; repeatable; `*` stands for any text."),
]
DryRun = Annotated[
    bool, typer.Option("--dry-run", help="Show stages and mpirun commands; write no file.")
]
Oversubscribe = Annotated[
    bool, typer.Option("--oversubscribe", help="Allow ranks x jobs to exceed the cores.")
]
IgnoreDisk = Annotated[
    bool, typer.Option("--ignore-disk", help="Run although the disk may be too small.")
]
TakenFrom = Annotated[
    list[Path] | None,
    typer.Option(
        "--from",
        metavar="DIR",
        help="Runs folder whose finished cases are reused if they are the same; repeatable.",
    ),
]
TimeLimit = Annotated[
    float | None,
    typer.Option(metavar="S", help="Wall time [s] after which a stage fails."),
]
StartOver = Annotated[
    bool,
    typer.Option(
        "--start-over", help="Restart interrupted stages from their begin, on any number of ranks."
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
Json = Annotated[bool, typer.Option("--json", help="Print only JSON, in SI units.")]


# Times of options [s]; timers of the system end after some centuries.
SHORTEST_S, LONGEST_S = 0.1, 1e9


def check_seconds(command: str, option: str, seconds: float) -> None:
    """Refuse a wall time that is too short, too long or not a number.

    Raises:
        CampaignError: states what is accepted.
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


@contextmanager
def resumable(
    message: str = "interrupted: finished stages are kept; repeat the command to resume",
) -> Iterator[None]:
    """Record this command for provenance.json; after Ctrl-C print a message and exit with 130.

    Raises:
        typer.Exit: interrupted.
    """
    # A command that calls `millscale` keeps its own line in the record.
    os.environ.setdefault(COMMAND_VARIABLE, shlex.join(["millscale", *sys.argv[1:]]))
    try:
        yield
    except KeyboardInterrupt:
        typer.echo(message, err=True)
        raise typer.Exit(INTERRUPTED) from None


def print_whole(shown: RenderableType) -> None:
    """Print on standard output; in a pipe or a file no table is cut and no line wrapped."""
    console = console_of()
    if not console.is_terminal:
        # Wider than any table: the console then measures what it needs.
        console.width = _WIDEST
        console.width = console.measure(shown).maximum
    console.print(shown)


def console_of(stderr: bool = False) -> Console:
    """Return the console of an output; tables in a pipe or a file have a fixed width."""
    shown = sys.stderr if stderr else sys.stdout
    return Console(stderr=stderr) if shown.isatty() else Console(stderr=stderr, width=_WIDTH)
