"""The command line `millscale`."""

from __future__ import annotations

import json
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from mill_campaign.errors import CampaignError
from mill_campaign.machine import CoreWish

EXIT_FAILED = 1
EXIT_WRONG_INPUT = 2
EXIT_INTERRUPTED = 130
_WIDTH = 140

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
    context_settings={"help_option_names": ["-h", "--help"]},
    help="""
Ball mills scaled by similarity: from a campaign file to simulated mills and their comparison.

A campaign (TOML) names a physical mill, the scale ratios S and the schemes; each combination is a
case with a folder of its own. Lengths in m, times in s, angles in rad unless a name says otherwise.

* `millscale plan campaigns/quick.toml` shows what would be simulated, and its cost
* `millscale run campaigns/quick.toml --runs runs/quick` simulates what is missing
* `millscale report runs/quick` writes report/index.html

Exit codes: 0 done; 1 a case failed; 2 wrong input; 130 interrupted, the same command goes on.
""",
)

Campaign = Annotated[
    Path, typer.Argument(metavar="FILE", help="Campaign file, such as campaigns/quick.toml.")
]
RunsArgument = Annotated[
    Path, typer.Argument(metavar="DIR", help="Runs folder, as given to `millscale run --runs`.")
]
RunsOption = Annotated[
    Path,
    typer.Option(
        "--runs", metavar="DIR", help="Folder of the runs; each case works in DIR/cases/ID."
    ),
]
Ranks = Annotated[
    int | None,
    typer.Option(
        metavar="N",
        help="MPI ranks of a multi-ball case; single balls take one. Default: the campaign's.",
    ),
]
Jobs = Annotated[
    int | None, typer.Option(metavar="M", help="Cases at a time. Default: the campaign's.")
]
Only = Annotated[
    list[str] | None,
    typer.Option(metavar="ID", help="Only this case; repeatable; `*` stands for any text."),
]
DryRun = Annotated[
    bool, typer.Option("--dry-run", help="Show the stages and the mpirun lines; write nothing.")
]
Oversubscribe = Annotated[
    bool, typer.Option("--oversubscribe", help="Allow more ranks x jobs than there are cores.")
]
Slurm = Annotated[
    bool, typer.Option("--slurm", help="Run the cases as jobs of Slurm; see docs/slurm.md.")
]
Profile = Annotated[
    Path | None,
    typer.Option(
        metavar="DIR", help="With --slurm: folder with config.yaml of the site, as profiles/slurm."
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print JSON, in SI units, and nothing else.")]


@app.command()
def plan(file: Campaign, as_json: Json = False) -> None:
    """Show the cases of a campaign: every derived number, the time step's limits, the cost.

    Writes nothing. Example: `millscale plan campaigns/paper-single-ball.toml --json`
    """
    from mill_campaign.config_build import load_campaign
    from mill_campaign.plan import plan_rows, render_plan

    rows = plan_rows(load_campaign(file))
    if as_json:
        # A line for each case: json indents slowly, and there may be ten thousand.
        typer.echo("[\n" + ",\n".join(map(json.dumps, rows)) + "\n]")
    else:
        _console().print(render_plan(rows))


@app.command()
def generate(file: Campaign, runs: RunsOption) -> None:
    """Write DIR/campaign.json and a case.json per case, and run nothing.

    A case.json that would not change is left alone. Example: `millscale generate
    campaigns/quick.toml --runs runs/quick`
    """
    from mill_campaign.folder_lock import hold
    from mill_campaign.generate import generate as write_cases
    from mill_campaign.run_command import request

    request(file, runs, [], CoreWish())
    with hold(runs):
        cases = write_cases(file, runs)
    typer.echo(f"{runs}: {len(cases)} cases; next: millscale run {file} --runs {runs}")


@app.command()
def run(
    file: Campaign,
    runs: RunsOption,
    ranks: Ranks = None,
    jobs: Jobs = None,
    only: Only = None,
    dry_run: DryRun = False,
    oversubscribe: Oversubscribe = False,
    slurm: Slurm = False,
    profile: Profile = None,
) -> None:
    """Bring every case to its result: mesh, deck, settling, rotation, analysis.

    Runs only what is missing or older than its inputs; a changed campaign reruns the cases it
    changes. Ctrl-C ends the engines; the same command then goes on with the stages not yet done.
    A case that fails does not stop the others.

    Engine: `liggghts_mill` beside this Python, on the PATH or in build/; MILLSCALE_ENGINE names
    another.

    Examples: `millscale run campaigns/quick.toml --runs runs/quick`,
    `millscale run campaigns/paper-multi-ball.toml --runs runs/mb --only 'mb-*-S2.600-*'`
    """
    from mill_campaign.run_command import Cluster, dry_run_campaign, request, run_campaign

    if profile and not slurm:
        raise CampaignError("millscale run", "--profile", "without --slurm", "both, or neither")
    cluster = Cluster(profile) if slurm else None
    asked = request(file, runs, only or [], CoreWish(ranks, jobs, oversubscribe), cluster)
    if dry_run:
        typer.echo(dry_run_campaign(asked))
        return
    try:
        raise typer.Exit(0 if run_campaign(asked, _console()) else EXIT_FAILED)
    except KeyboardInterrupt:
        typer.echo(
            "interrupted: finished stages are kept, the same command goes on from there", err=True
        )
        raise typer.Exit(EXIT_INTERRUPTED) from None


@app.command()
def status(runs: RunsArgument, as_json: Json = False) -> None:
    """Show the stage of every case, how far it is, and the last problem.

    Example: `millscale status runs/quick`
    """
    from mill_campaign.display import status_table
    from mill_campaign.prediction import error_line
    from mill_campaign.run_command import problems
    from mill_campaign.status import campaign_status

    statuses = campaign_status(runs)
    if as_json:
        typer.echo(json.dumps([asdict(x) for x in statuses], indent=1))
        return
    _console().print(status_table(statuses))
    for line in [*problems(runs, statuses), error_line(runs)]:
        if line:
            typer.echo(line)


@app.command()
def report(runs: RunsArgument, as_json: Json = False) -> None:
    """Compare the finished cases: DIR/report/index.html, a page of its own, and results.json.

    Example: `millscale report runs/quick --json`
    """
    from mill_analysis import RunFolderError, build_report

    try:
        build_report(runs)
    except RunFolderError as error:
        typer.echo(f"error: {error}", err=True)
        raise typer.Exit(EXIT_WRONG_INPUT) from None
    folder = runs / "report"
    if as_json:
        typer.echo((folder / "results.json").read_text().rstrip("\n"))
    else:
        typer.echo(f"report: {folder / 'index.html'}")


@app.command()
def bench(
    scene: Annotated[
        str,
        typer.Option(
            help="s2.6: 13,370 balls, 1 rank; s1: the physical mill, 231,461 balls, 2 ranks; "
            "wall: mesh against analytic wall, for one ball and for s2.6; "
            "slices: what a shorter piece of the mill changes."
        ),
    ] = "s2.6",
    quick: Annotated[
        bool, typer.Option("--quick", help="Shorter runs; ours and tuned stock LIGGGHTS alone.")
    ] = False,
    runs: Annotated[
        Path, typer.Option("--runs", metavar="DIR", help="Where the mills in motion are kept.")
    ] = Path("runs/bench"),
    as_json: Json = False,
) -> None:
    """Time a step of the turning mill: ours against tuned stock LIGGGHTS, in turns.

    The first call brings the mill into motion and keeps it in DIR: a minute or two for s2.6, half
    an hour for s1. Nothing else should run meanwhile.

    Example: `millscale bench --scene s2.6 --quick --json`
    """
    from mill_bench.command import bench as time_scene
    from mill_bench.command import table, text

    console = Console(stderr=True) if as_json else _console()
    result = time_scene(scene, quick, runs, console)
    if as_json or "rows" not in result:
        typer.echo(text(result))
    else:
        console.print(table(result))


def _console() -> Console:
    """Tables of a pipe or a file are not cut to the width of a terminal that is not there."""
    return Console() if sys.stdout.isatty() else Console(width=_WIDTH)


def main() -> None:
    """Entry point; what the user can mend ends in one line and exit code 2."""
    try:
        app()
    except (CampaignError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(EXIT_WRONG_INPUT)


if __name__ == "__main__":
    main()
