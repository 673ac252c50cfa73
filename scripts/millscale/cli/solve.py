"""`millscale solve`: run scaled mills until the physical mill is known within an error."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from millscale.cli.advise import seconds_of, share_of
from millscale.cli.options import (
    EXIT_FAILED,
    Campaign,
    IgnoreDisk,
    Jobs,
    Json,
    Oversubscribe,
    Ranks,
    console_of,
    resumable,
)
from millscale.engine.machine import CoreWish


def solve(
    file: Campaign,
    error: Annotated[
        str, typer.Option(metavar="E", help="Half width of each interval wanted, such as 2%.")
    ],
    runs: Annotated[
        Path,
        typer.Option("--runs", metavar="DIR", help="Folder of the rounds; round N is DIR/round-N."),
    ],
    observable: Annotated[
        list[str] | None,
        typer.Option(metavar="NAMES", help="Such as power,contour,toe; repeatable."),
    ] = None,
    budget: Annotated[
        str | None,
        typer.Option(metavar="TIME", help="Most time of all runs on one core, such as 10min."),
    ] = None,
    ranks: Ranks = None,
    jobs: Jobs = None,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Show the plan, or the next round; write no file.")
    ] = False,
    oversubscribe: Oversubscribe = False,
    ignore_disk: IgnoreDisk = False,
    as_json: Json = False,
) -> None:
    """Run scaled mills until the physical mill is known within an error.

    Plans as `millscale advise`, runs, predicts as `millscale predict`, and adds the run that
    narrows the widest interval most per second. Ends when every interval is within the error, when
    the budget is spent, or when no run helps. Writes DIR/report/index.html and DIR/answer.json.
    After Ctrl-C, repeat the command to resume. See docs/guide/solve.md.

    Exit code 1 if the error was not reached or a run failed.

    Example: `millscale solve campaigns/slices.toml --error 3% --observable power --runs runs/power`
    """
    from millscale.prediction.solve_command import SolveCall
    from millscale.prediction.solve_command import dry_run as show_plan
    from millscale.prediction.solve_command import solve as solve_mill
    from millscale.prediction.solve_page import ANSWER

    call = SolveCall(
        file=file,
        folder=runs,
        error=share_of(error),
        observables=tuple(observable or ()),
        budget_s=seconds_of(budget) if budget else None,
        cores=CoreWish(ranks, jobs, oversubscribe),
        ignore_disk=ignore_disk,
    )
    if dry_run:
        show_plan(call, console_of())
        return
    with resumable():
        # With --json, standard output is for the answer.
        answer = solve_mill(call, console_of(stderr=as_json))
    if as_json:
        typer.echo((runs / ANSWER).read_text(encoding="utf-8").rstrip("\n"))
    raise typer.Exit(0 if answer.is_met else EXIT_FAILED)
