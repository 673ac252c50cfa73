"""`millscale study`: time against error over the settings of a campaign."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from millscale.cli.options import (
    EXIT_FAILED,
    IgnoreDisk,
    Jobs,
    Json,
    Oversubscribe,
    Ranks,
    TakenFrom,
    console_of,
    resumable,
)
from millscale.engine.machine import CoreWish
from millscale.errors import CampaignError


def study(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="Study file, such as campaigns/study-S2.6.toml.")
    ],
    runs: Annotated[
        Path | None,
        typer.Option(
            "--runs", metavar="DIR", help="Runs folder; a setting is in DIR/settings/NAME."
        ),
    ] = None,
    only_plan: Annotated[
        bool, typer.Option("--plan", help="Show settings and predicted time; write no file.")
    ] = False,
    taken_from: TakenFrom = None,
    only: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME", help="Run only this setting; repeatable; `*` stands for any text."
        ),
    ] = None,
    no_run: Annotated[
        bool, typer.Option("--no-run", help="Compare finished cases; run none.")
    ] = False,
    ranks: Ranks = None,
    jobs: Jobs = None,
    oversubscribe: Oversubscribe = False,
    ignore_disk: IgnoreDisk = False,
    to: Annotated[
        Path | None,
        typer.Option(
            metavar="JSON", help="Also add the results to this file, which may hold other studies."
        ),
    ] = None,
    as_json: Json = False,
) -> None:
    """Run a parameter study and compare each setting with the reference: time against error.

    A setting changes keys of a campaign: step, wall, contacts, S, ... The page shows the Pareto
    front and the fastest setting within 1, 3 and 10 % of error. Writes DIR/report/index.html and
    speed-against-error.json. After Ctrl-C, repeat the command to resume. See docs/guide/study.md.

    Examples: `millscale study campaigns/study-S2.6.toml --plan`,
    `millscale study campaigns/study-ladder.toml --runs runs/ladder --from runs/paper-multi-ball`
    """
    from millscale.study.command import (
        NO_FOLDER,
        StudyCall,
        plan,
        plan_text,
        render,
        results_text,
        run_and_compare,
    )

    if runs is None and not only_plan:
        raise CampaignError("millscale study", "--runs", "missing", "a folder, or --plan")
    if only_plan and (no_run or to):
        raise CampaignError("millscale study", "--plan", "with --no-run or --to", "one of them")
    wish = CoreWish(ranks, jobs, oversubscribe)
    others, names = tuple(taken_from or ()), tuple(only or ())
    call = StudyCall(file, runs or NO_FOLDER, others, names, wish, ignore_disk, no_run, to)
    if only_plan:
        rows = plan(call)
        typer.echo(plan_text(rows)) if as_json else console_of().print(render(rows))
        return
    with resumable():
        # With --json, standard output is for the results.
        done, _ = run_and_compare(call, console_of(stderr=as_json))
    if as_json:
        typer.echo(results_text(call))
    raise typer.Exit(0 if done else EXIT_FAILED)
