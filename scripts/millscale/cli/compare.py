"""`millscale compare`: several runs folders in one report."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from millscale.cli.options import Json, RunsArguments

_DEFAULT = Path("comparison")


def compare(
    runs: RunsArguments,
    to: Annotated[
        Path, typer.Option(metavar="FOLDER", help="Folder to write; an earlier one is replaced.")
    ] = _DEFAULT,
    as_json: Json = False,
) -> None:
    """Compare two or more runs folders: new against worn liner, several speeds, two settings.

    Writes FOLDER/index.html and comparison.json. The page states what differs and whether like is
    compared with like. Power, toe, shoulder, contours and series are laid over each other, for
    scaled mills of the same S, scheme and policy. The first runs folder is the reference.

    Examples: `millscale compare runs/new runs/worn`,
    `millscale compare runs/70 runs/75 runs/80 --to speeds`
    """
    from millscale.report.compare import RESULTS, compare_runs

    page = compare_runs(runs, to)
    if as_json:
        typer.echo((to / RESULTS).read_text(encoding="utf-8").rstrip("\n"))
    else:
        typer.echo(f"comparison: {page}")
