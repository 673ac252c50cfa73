"""`millscale calibrate`: the friction exponent of a mill, from two of its scaled mills."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from millscale.cli.options import (
    EXIT_FAILED,
    Campaign,
    IgnoreDisk,
    Jobs,
    Json,
    Oversubscribe,
    Ranks,
    RunsOption,
    console_of,
    resumable,
)
from millscale.engine.machine import CoreWish


def calibrate(
    file: Campaign,
    runs: RunsOption,
    far: Annotated[
        float | None,
        typer.Option("--S", metavar="FAR", help="Scaled mill to match; default: the largest S."),
    ] = None,
    near: Annotated[
        float | None,
        typer.Option(
            "--reference-S", metavar="NEAR", help="Mill to match it to; default: the smallest S."
        ),
    ] = None,
    ranks: Ranks = None,
    jobs: Jobs = None,
    oversubscribe: Oversubscribe = False,
    ignore_disk: IgnoreDisk = False,
    as_json: Json = False,
) -> None:
    """Find the friction exponent of policy friction-matched without the physical mill.

    Runs the scaled mill of S = NEAR with the friction of the campaign, and that of S = FAR with
    friction over (FAR / NEAR)^k at k = 0, 2 and the k that matches the centre of mass. Prints k
    for the campaign file and the differences that are left. Writes DIR/calibration.json. After
    Ctrl-C, repeat the command to resume. See docs/guide/calibrate.md.

    Example: `millscale calibrate campaigns/friction-matched.toml --runs runs/calibration`
    """
    from millscale.prediction.calibrate import calibrate as run_and_match
    from millscale.prediction.calibrate import mills_of
    from millscale.prediction.calibration_table import calibration_lines, calibration_table

    mills = mills_of(file, near, far)
    # With --json, standard output is for the result.
    progress = console_of(stderr=as_json)
    wish = CoreWish(ranks, jobs, oversubscribe)
    with resumable():
        found = run_and_match(mills, runs, wish, ignore_disk, progress)
    if found is None:
        raise typer.Exit(EXIT_FAILED)
    if as_json:
        typer.echo(json.dumps(found.document(), indent=1))
        return
    console = console_of()
    console.print(calibration_table(found))
    for line in calibration_lines(found):
        console.print(line, markup=False, highlight=False)
