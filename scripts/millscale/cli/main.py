"""The command line `millscale`."""

from __future__ import annotations

import json
import os
import shlex
import sys
from contextlib import suppress
from dataclasses import asdict
from typing import Annotated

import typer

from millscale import __version__
from millscale.cli.advise import advise
from millscale.cli.analyse import analyse
from millscale.cli.bench import bench
from millscale.cli.breakage import breakage
from millscale.cli.calibrate import calibrate
from millscale.cli.compare import compare
from millscale.cli.export import export
from millscale.cli.new import new
from millscale.cli.open_report import open_report
from millscale.cli.options import (
    EXIT_FAILED,
    EXIT_WRONG_INPUT,
    Campaign,
    DryRun,
    IgnoreDisk,
    Jobs,
    Json,
    Nodes,
    Only,
    Oversubscribe,
    Profile,
    Ranks,
    RunsArgument,
    RunsOption,
    Slurm,
    StartOver,
    TargetName,
    TimeLimit,
    check_seconds,
    console_of,
    print_whole,
    resumable,
)
from millscale.cli.predict import predict
from millscale.cli.report import report
from millscale.cli.solve import solve
from millscale.cli.study import study
from millscale.cli.validate import validate
from millscale.cli.wear import wear
from millscale.engine.environment import TIME_LIMIT_VARIABLE
from millscale.engine.machine import CoreWish
from millscale.errors import CampaignError, EngineError, PredictionError
from millscale.formats import counted
from millscale.runs.layout import CASES_FOLDER
from millscale.runs.untrusted import RunFolderError
from millscale.terminal import escape_unencodable
from millscale.workflow.failures import SILENCE

app = typer.Typer(
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
    context_settings={"help_option_names": ["-h", "--help"]},
    help="""
Scaled models of ball mills that are too large for DEM, and the error of each model.

A campaign file (TOML) defines a physical mill, scale ratios S and similarity schemes. Each
combination is a case with its own folder. Units are SI unless a name states another.

* `millscale new my-mill.toml` asks for a mill and writes a campaign file of it
* `millscale plan campaigns/quick.toml` shows the cases and their cost
* `millscale run campaigns/quick.toml --runs runs/quick` simulates the cases that are missing
* `millscale report runs/quick` writes report/index.html, `millscale open` shows it
* `millscale compare runs/new runs/worn` compares runs folders in one report
* `millscale export runs/quick --paraview` writes files for ParaView, OVITO or tables
* `millscale study campaigns/study-S2.6.toml --plan` shows the cost of a parameter study
* `millscale predict runs/slices` predicts the physical mill from its scaled mills
* `millscale solve campaigns/slices.toml --error 2% --runs runs/solve` plans, runs and predicts

Exit codes: 0 done; 1 a case failed, or `verify` found a difference; 2 wrong input or a full disk;
130 interrupted. Repeat an interrupted command to resume. `millscale status` shows why a case
failed.
""",
)


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"millscale {__version__}")
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool,
        typer.Option(
            "--version", is_eager=True, callback=_print_version, help="Print the version and exit."
        ),
    ] = False,
) -> None:
    pass


app.command()(new)


@app.command()
def plan(
    file: Campaign,
    as_json: Json = False,
    details: Annotated[
        bool,
        typer.Option(
            "--details", help="Add every derived number, and what is modelled and left out."
        ),
    ] = False,
    ranks: Ranks = None,
    jobs: Jobs = None,
) -> None:
    """Show the mill of a campaign, its cases, their time and memory, and what is unusual.

    With --ranks and --jobs it shows what `millscale run` would do with them. Writes no file.
    Example: `millscale plan campaigns/paper-single-ball.toml --details`
    """
    from millscale.campaign.build import load_campaign
    from millscale.workflow.plan import plan_rows
    from millscale.workflow.plan_display import render_plan

    campaign = load_campaign(file)
    rows = plan_rows(campaign, CoreWish(ranks, jobs))
    if as_json:
        # One line for each case: indentation is slow, and there may be ten thousand cases.
        typer.echo("[\n" + ",\n".join(map(json.dumps, rows)) + "\n]")
    else:
        print_whole(render_plan(campaign, rows, details, jobs))


@app.command()
def schema() -> None:
    """Print the JSON schema of campaign files, with which editors complete and check them.

    Writes no file. Example: `millscale schema > campaign.schema.json`; the first line
    `#:schema campaign.schema.json` of a campaign file names it.
    """
    from millscale.campaign.schema import schema_text

    typer.echo(schema_text(), nl=False)


@app.command()
def generate(file: Campaign, runs: RunsOption) -> None:
    """Write a complete folder for each case, without running the engine.

    A folder holds case.json, mesh, charge, decks and mpirun.sh. `sh mpirun.sh` in the folder
    simulates the case without Python; `millscale run`, `status` and `report` use its results.
    Files that would not change stay as they are.

    Example: `millscale generate campaigns/quick.toml --runs runs/quick`
    """
    from millscale.cases.generate import generate as write_cases
    from millscale.runs.lock import hold
    from millscale.workflow.display import counting
    from millscale.workflow.run_command import request
    from millscale.workflow.without_engine import prepare

    # No engine runs here: attempts may have more ranks than this machine has cores.
    asked = request(file, runs, [], CoreWish(oversubscribe=True))
    with (
        resumable("interrupted: finished folders are kept; repeat the command"),
        hold(runs),
        counting(console_of(stderr=True), "folders") as count,
    ):
        cases = write_cases(file, runs)
        folders = {runs / CASES_FOLDER / x.id: asked.allocation.ranks[x.id] for x in cases}
        made, failed = prepare(folders, count)
    for line in failed:
        typer.echo(line, err=True)
    if failed:
        raise typer.Exit(EXIT_FAILED)
    kept = len(cases) - made
    typer.echo(f"{runs}: {counted(len(cases), 'case')}: {made} written, {kept} unchanged")
    first = shlex.quote(str(next(iter(folders))))
    command = shlex.join(["millscale", "run", str(file), "--runs", str(runs)])
    typer.echo(f"next: {command}, or for each case:")
    typer.echo(f"  (cd {first} && sh mpirun.sh)")


@app.command()
def run(
    file: Campaign,
    runs: RunsOption,
    ranks: Ranks = None,
    jobs: Jobs = None,
    only: Only = None,
    dry_run: DryRun = False,
    oversubscribe: Oversubscribe = False,
    time_limit: TimeLimit = None,
    ignore_disk: IgnoreDisk = False,
    start_over: StartOver = False,
    target: TargetName = "local",
    slurm: Slurm = False,
    nodes: Nodes = None,
    profile: Profile = None,
) -> None:
    """Run every case: mesh, deck, settling, rotation, analysis.

    Only stages run whose products are missing or were made from other inputs. After Ctrl-C, repeat
    the command to resume, on the same number of ranks. A case that fails does not stop the others.

    The engine is `liggghts_mill` beside this Python, on the PATH or in build/; the environment
    variable MILLSCALE_ENGINE names another.

    Examples: `millscale run campaigns/quick.toml --runs runs/quick`,
    `millscale run campaigns/paper-multi-ball.toml --runs runs/mb --only 'mb-*-S2.600-*'`
    """
    with resumable():
        from millscale.workflow.run_command import (
            check_free_disk,
            dry_run_campaign,
            request,
            run_campaign,
        )
        from millscale.workflow.targets import target_named

        if time_limit is not None:
            check_seconds("run", "--time-limit", time_limit)
            os.environ[TIME_LIMIT_VARIABLE] = repr(time_limit)
        place = target_named("slurm" if slurm else target, profile)
        cores = CoreWish(ranks, jobs, oversubscribe, nodes)
        asked = request(file, runs, only or [], cores, place, start_over)
        if dry_run:
            typer.echo(dry_run_campaign(asked))
            return
        if not ignore_disk:
            check_free_disk(asked)
        raise typer.Exit(0 if run_campaign(asked, console_of()) else EXIT_FAILED)


@app.command()
def status(
    runs: RunsArgument,
    as_json: Json = False,
    watch: Annotated[
        bool, typer.Option("--watch", help="Repeat until no case runs; Ctrl-C ends it.")
    ] = False,
    every: Annotated[float, typer.Option(metavar="S", help="Interval of --watch [s].")] = 2.0,
    silence: Annotated[
        float,
        typer.Option(
            "--silence",
            metavar="S",
            help="An engine that writes nothing for this time [s] makes no progress.",
        ),
    ] = SILENCE,
) -> None:
    """Show stage, progress, rate, time left and last problem of every case.

    Reads files only: call it from any terminal, during a run or after it. With --json and --watch
    each state is one line.

    Example: `millscale status runs/quick --watch`
    """
    from millscale.workflow.display import show, watch_status

    check_seconds("status", "--every", every)
    check_seconds("status", "--silence", silence)
    if not watch:
        show(runs, silence, as_json, console_of())
        return
    with suppress(KeyboardInterrupt):
        watch_status(runs, silence, as_json, every, console_of())


@app.command()
def verify(runs: RunsArgument, as_json: Json = False) -> None:
    """Compare every file of a runs folder with its recorded digest, its campaign and this version.

    Exit code 1 if anything differs. Example: `millscale verify runs/quick`
    """
    from millscale.workflow.verify import verify as verify_folder

    found = verify_folder(runs)
    if as_json:
        typer.echo(json.dumps(asdict(found), indent=1))
    else:
        for difference in found.differences:
            typer.echo(str(difference))
        if found.note:
            typer.echo(found.note)
        typer.echo(
            f"{counted(found.cases, 'case')}, {counted(found.files, 'file')} checked: "
            f"{counted(len(found.differences), 'difference')}"
        )
    if found.differences:
        raise typer.Exit(EXIT_FAILED)


app.command()(report)
app.command("open")(open_report)
app.command()(compare)
app.command()(export)
app.command()(study)
app.command()(advise)
app.command()(predict)
app.command()(solve)
app.command()(calibrate)
app.command()(wear)
app.command()(breakage)
app.add_typer(bench, name="bench")
app.add_typer(analyse, name="analyse")
app.add_typer(validate, name="validate")


def main() -> None:
    """Run the command line; a mistake that the user can correct is one line, exit code 2."""
    escape_unencodable()
    try:
        app(prog_name="millscale")
    except (CampaignError, PredictionError, RunFolderError, OSError) as error:
        for line in str(error).splitlines():
            print(f"error: {line}", file=sys.stderr)
        sys.exit(EXIT_WRONG_INPUT)
    except EngineError as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(EXIT_FAILED)
