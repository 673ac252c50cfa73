"""`millscale export`: finished cases for ParaView, OVITO and spreadsheets."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from millscale.cli.options import RunsArgument, check_at_least
from millscale.errors import CampaignError


def export(
    runs: RunsArgument,
    paraview: Annotated[
        bool, typer.Option("--paraview", help="A state with balls and turning liner, charge.pvsm.")
    ] = False,
    csv: Annotated[
        bool, typer.Option("--csv", help="Tables with units: cases, series, shapes, balls.")
    ] = False,
    ovito: Annotated[
        bool, typer.Option("--ovito", help="Extended XYZ with radii, and the liner as STL.")
    ] = False,
    to: Annotated[
        Path | None,
        typer.Option(metavar="FOLDER", help="Folder to write. Default: DIR/export/FORMAT."),
    ] = None,
    only: Annotated[
        list[str] | None,
        typer.Option(metavar="ID", help="Only this case; repeatable; `*` stands for any text."),
    ] = None,
    every: Annotated[int, typer.Option(metavar="N", help="Write every Nth dump.")] = 1,
    replace: Annotated[bool, typer.Option("--replace", help="Replace an earlier export.")] = False,
) -> None:
    """Write finished cases for ParaView, OVITO or a spreadsheet.

    Open charge.pvsm with ParaView, charge.xyz with OVITO. A folder that is there is kept, unless
    it is an export and --replace is given. docs/guide/export.md describes the files.

    Examples: `millscale export runs/quick --paraview`,
    `millscale export runs/quick --csv --to tables`,
    `millscale export runs/quick --ovito --only 'mb-cg-*' --every 2`
    """
    from millscale.exports.command import FORMATS
    from millscale.exports.command import export as write

    asked = dict(zip(FORMATS, (paraview, csv, ovito), strict=True))
    kinds = [kind for kind, wanted in asked.items() if wanted]
    accepted = ", ".join(f"--{kind}" for kind in FORMATS)
    if not kinds:
        raise CampaignError("millscale export", "", "no format given", accepted)
    if to and len(kinds) > 1:
        raise CampaignError("millscale export", "--to", "got several formats for it", "one format")
    check_at_least("export", "--every", every, 1)
    for kind in kinds:
        written = write(runs, kind, to, only or (), every, replace)
        for name, why in written.left_out.items():
            typer.echo(f"{name}: left out: {why}", err=True)
        for path in written.files:
            typer.echo(path)
