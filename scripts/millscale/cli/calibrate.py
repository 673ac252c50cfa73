"""`millscale calibrate`: contact parameters of a mill, from measurements or another scaled mill."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

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

if TYPE_CHECKING:
    from millscale.calibration.command import CalibrateCall

_COMMAND = "millscale calibrate"


def calibrate(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="Calibration file, or campaign file (TOML).")
    ],
    runs: Annotated[
        Path | None, typer.Option("--runs", metavar="DIR", help="Folder of the calibration.")
    ] = None,
    only_plan: Annotated[
        bool, typer.Option("--plan", help="Show samples and predicted time; write no file.")
    ] = False,
    taken_from: TakenFrom = None,
    no_run: Annotated[
        bool, typer.Option("--no-run", help="Use the finished samples; run none.")
    ] = False,
    far: Annotated[
        float | None,
        typer.Option(
            "--S", metavar="FAR", help="Of a campaign: mill to match; default: the largest S."
        ),
    ] = None,
    near: Annotated[
        float | None,
        typer.Option(
            "--reference-S",
            metavar="NEAR",
            help="Of a campaign: mill to match it to; default: the smallest S.",
        ),
    ] = None,
    ranks: Ranks = None,
    jobs: Jobs = None,
    oversubscribe: Oversubscribe = False,
    ignore_disk: IgnoreDisk = False,
    as_json: Json = False,
) -> None:
    """Find contact parameters with which a mill agrees with measurements, or another scaled mill.

    A calibration file states a campaign, parameters with ranges, and measured numbers with their
    uncertainty. Runs samples of the parameters, infers them with intervals, and runs more where
    they matter. Writes DIR/report/index.html, calibration.json and calibrated.toml.

    Of a campaign file: finds the friction exponent of policy friction-matched without the physical
    mill. Runs the scaled mill of S = NEAR with the friction of the campaign, and that of S = FAR
    with friction over (FAR / NEAR)^k at k = 0, 2 and the k that matches the centre of mass.

    After Ctrl-C, repeat the command to resume. See docs/guide/calibrate.md.

    Examples: `millscale calibrate campaigns/calibration/calibrate-friction.toml --plan`,
    `millscale calibrate campaigns/friction-matched.toml --runs runs/calibration`
    """
    from millscale.calibration.file import is_calibration

    wish = CoreWish(ranks, jobs, oversubscribe)
    if runs is None and not only_plan:
        raise CampaignError(_COMMAND, "--runs", "missing", "a folder, or --plan")
    if is_calibration(file):
        if far or near:
            accepted = "scaling.S in its [all]"
            raise CampaignError(_COMMAND, "--S", "with a calibration file", accepted)
        from millscale.calibration.command import CalibrateCall

        if only_plan or runs is None:
            _show_plan(file)
            return
        others = tuple(taken_from or ())
        _to_measurements(CalibrateCall(file, runs, others, wish, ignore_disk, no_run), as_json)
    elif only_plan or no_run or taken_from or runs is None:
        cause = f"with {file}, which has no [calibration]"
        raise CampaignError(_COMMAND, "--plan, --from, --no-run", cause, "a calibration file")
    else:
        _to_another_mill(file, runs, (near, far), wish, ignore_disk, as_json)


def _show_plan(file: Path) -> None:
    from millscale.calibration.command import plan_lines

    for line in plan_lines(file):
        typer.echo(line)


def _to_measurements(call: CalibrateCall, as_json: bool) -> None:
    """Infer parameters from measurements."""
    from millscale.calibration.command import calibrate as run_and_infer

    with resumable():
        # With --json, standard output is for the result.
        done, result = run_and_infer(call, console_of(stderr=as_json))
    if as_json:
        typer.echo(json.dumps(result.document(), indent=1))
    raise typer.Exit(0 if done else EXIT_FAILED)


def _to_another_mill(
    file: Path,
    runs: Path,
    mills: tuple[float | None, float | None],
    wish: CoreWish,
    ignore_disk: bool,
    as_json: bool,
) -> None:
    """Match the friction of a scaled mill to another."""
    from millscale.calibration.matched_mills import match_friction, mills_of
    from millscale.calibration.matched_mills_table import friction_lines, friction_table

    scene = mills_of(file, *mills)
    with resumable():
        found = match_friction(scene, runs, wish, ignore_disk, console_of(stderr=as_json))
    if found is None:
        raise typer.Exit(EXIT_FAILED)
    if as_json:
        typer.echo(json.dumps(found.document(), indent=1))
        return
    console = console_of()
    console.print(friction_table(found))
    for line in friction_lines(found):
        console.print(line, markup=False, highlight=False)
