"""`millscale breakage`: breakage of an ore by the impacts of finished charges."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from millscale.cli.options import Json, RunsArgument, print_whole


def breakage(
    runs: RunsArgument,
    ore: Annotated[
        Path, typer.Option("--ore", metavar="FILE", help="Ore and what impacts do to it (TOML).")
    ],
    as_json: Json = False,
) -> None:
    """Compute specific energy, t10 and selection function of an ore from the impacts of a mill.

    This is post-processing by published models: balls without ore cannot verify it. The campaign
    of DIR needs `impacts = true` in [multi_ball]. Scaled mills give the impacts of the physical
    mill by the similarity law. Writes DIR/breakage; later reports of DIR have a section of it. See
    docs/guide/breakage.md.

    Example: `millscale breakage runs/sag --ore ore.toml`
    """
    from rich.table import Table

    from millscale.analysis.finished_campaign import load_campaign
    from millscale.analysis.ore.breakage import POST_PROCESSING
    from millscale.analysis.ore.file import load_ore
    from millscale.report.breakage_section import (
        FOLDER,
        breakage_tables,
        fit_line,
        write_breakage,
    )

    stated = load_ore(ore)
    found = write_breakage(runs, load_campaign(runs).charges, stated)
    if as_json:
        typer.echo(json.dumps(found.document(), indent=1))
        return
    typer.echo(POST_PROCESSING)
    typer.echo(stated.about)
    for content in breakage_tables(found):
        table = Table(title=content.title, title_justify="left")
        for number, head in enumerate(content.heads):
            table.add_column(head, justify="right" if number else "left")
        for row in content.rows:
            table.add_row(*row)
        print_whole(table)
    if line := fit_line(found):
        typer.echo(line)
    for warning in found.warnings:
        typer.echo(f"warning: {warning}", err=True)
    typer.echo(f"numbers and figure: {runs / FOLDER}; `millscale report {runs}` has a section")
