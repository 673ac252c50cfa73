"""`millscale bench`: wall time of a step, against stock LIGGGHTS and other engines."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from millscale.cli.options import CaseArgument, Json, console_of

bench = typer.Typer(invoke_without_command=True, rich_markup_mode="markdown")


@bench.callback()
def time_step_cost(
    context: typer.Context,
    scene: Annotated[
        str,
        typer.Option(
            metavar="NAME",
            help="s2.6: 13,370 balls, 1 rank; s1: the physical mill, 231,461 balls, 2 ranks; "
            "drum: a smooth drum, also in LAMMPS and Yade, which must be installed; "
            "mixture: a drum with balls of 1 : 10; "
            "wall: mesh against analytic wall, for one ball and for s2.6; "
            "size: 1,020 to 231,461 balls on 1 and 2 ranks, with a figure; "
            "slices: the means of a shorter piece of the mill; "
            "campaign: a step of a campaign over the bare step.",
        ),
    ] = "s2.6",
    quick: Annotated[
        bool, typer.Option("--quick", help="Shorter runs, of millscale and stock LIGGGHTS only.")
    ] = False,
    runs: Annotated[
        Path, typer.Option("--runs", metavar="DIR", help="Folder for the rotating mills.")
    ] = Path("runs/bench"),
    compare: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Earlier result (--json) of this scene on this kind of machine: adds whether a "
            "step is faster or slower than it, by the ratios to stock.",
        ),
    ] = None,
    as_json: Json = False,
) -> None:
    """Time a step of a rotating mill: millscale against tuned stock LIGGGHTS, in turns.

    The first call rotates the mill until the charge moves and keeps it in DIR: one or two minutes
    for s2.6, half an hour for s1. Run nothing else on the machine at the same time. The exit code
    does not depend on --compare.

    Examples: `millscale bench --scene s2.6 --quick --json > s2.6.json`,
    `millscale bench --scene s2.6 --quick --compare s2.6.json`
    """
    if context.invoked_subcommand:
        return
    from millscale.bench.command import bench as time_scene
    from millscale.bench.command import table, text

    console = Console(stderr=True) if as_json else console_of()
    result = time_scene(scene, quick, runs, console, compare)
    if as_json or "rows" not in result:
        typer.echo(text(result))
    else:
        console.print(table(result))
        if compare:
            console.print(result["compared"]["summary"], soft_wrap=True, highlight=False)


@bench.command("output-cost")
def output_cost(folder: CaseArgument) -> None:
    """Measure the cost of restart files and of rows of series.csv; prints JSON.

    CASE is a finished multi-ball case. Times are processor times [s], overheads fractions of the
    time of the steps.

    Example: `millscale bench output-cost runs/paper/cases/mb-cg-paper-S2.600-seed1`
    """
    from millscale.bench.output_cost import output_cost as measured

    typer.echo(json.dumps(measured(folder), indent=1))
