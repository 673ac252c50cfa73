"""`millscale analyse`: results of finished cases and of several campaigns."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from millscale.cli.options import CaseArgument, RunsArguments
from millscale.errors import CampaignError

analyse = typer.Typer(
    no_args_is_help=True,
    rich_markup_mode="markdown",
    help="""
Analyse finished cases, and compare two or more of them.

CASE is a case folder, DIR/cases/ID of a runs folder DIR.
""",
)


@analyse.command()
def case(folder: CaseArgument) -> None:
    """Analyse one case again and write CASE/result.json.

    Reads case.json and series.csv. `millscale run` does this after each rotation.

    Example: `millscale analyse case runs/quick/cases/sb-cg-paper-S2.600`
    """
    from millscale.analysis.case import write_result

    written = write_result(folder)
    if problem := json.loads(written.read_text(encoding="utf-8"))["problem"]:
        typer.echo(f"{folder}: {problem}", err=True)
    typer.echo(written)


@analyse.command()
def pair(
    first: CaseArgument,
    second: Annotated[Path, typer.Argument(metavar="REFERENCE", help="Case to compare with.")],
) -> None:
    """Compare two multi-ball cases, such as one case on 1 and on 2 ranks.

    Prints the errors of CASE against REFERENCE as JSON: contour, curtain, mass flow, power.

    Example: `millscale analyse pair runs/two-ranks/cases/ID runs/one-rank/cases/ID`
    """
    from millscale.analysis.charge.pair import compare_two, load_charge

    typer.echo(json.dumps(compare_two(load_charge(first), load_charge(second)), indent=1))


@analyse.command()
def groups(
    first: Annotated[
        str,
        typer.Argument(metavar="CASES", help="Folders of a group: a path with `*`, in quotes."),
    ],
    second: Annotated[str, typer.Argument(metavar="OTHERS", help="Folders of the other group.")],
    to: Annotated[
        Path | None, typer.Option(metavar="JSON", help="Also write the comparison to this file.")
    ] = None,
) -> None:
    """Compare two groups of multi-ball cases that differ in one setting, each with several seeds.

    The groups agree in a quantity if the difference between them is no larger than that between the
    seeds of one group. Prints a Markdown table.

    Example: `millscale analyse groups 'runs/a/cases/mb-*-seed?' 'runs/b/cases/mb-*-seed?'`
    """
    from millscale.analysis.charge.groups import compare_groups, markdown
    from millscale.analysis.charge.pair import load_charge
    from millscale.runs.writing import write_json

    compared = compare_groups(
        *([load_charge(x) for x in _matching(pattern)] for pattern in (first, second))
    )
    if to:
        write_json(to, compared.document())
    typer.echo(markdown(compared))


def _matching(pattern: str) -> list[Path]:
    """Return the folders that a path with `*`, `?` or `[...]` matches, in order."""
    path = Path(pattern)
    root = Path(path.anchor)
    found = sorted(root.glob(str(path.relative_to(root))))
    if not found:
        raise CampaignError("millscale analyse groups", "", f"no folder {pattern}", "case folders")
    return found


@analyse.command()
def campaigns(
    runs: RunsArguments,
    to: Annotated[Path, typer.Option(metavar="JSON", help="File for the results.")],
    machine: Annotated[
        str, typer.Option(metavar="TEXT", help="Note on the machine, such as its load.")
    ] = "",
    commit: Annotated[
        str, typer.Option(metavar="HASH", help="Commit of the code; default: of this code.")
    ] = "",
) -> None:
    """Compare every multi-ball case of some campaigns with the physical mill; write one JSON file.

    Prints error and processor time of each scaled mill as a Markdown table.

    Example: `millscale analyse campaigns runs/paper-multi-ball --to paper-multi-ball.json`
    """
    from millscale.analysis.charge.speed_error import markdown, mill_rows
    from millscale.analysis.several_campaigns import compare_campaigns, origin
    from millscale.runs.writing import write_json

    comparison, content = compare_campaigns(runs)
    write_json(to, origin(runs, machine, commit) | content)
    typer.echo(markdown(mill_rows(comparison.rows)))


@analyse.command()
def variants(
    runs: RunsArguments,
    ratio: Annotated[float, typer.Option("--S", metavar="S", help="Scale ratio.")] = 1.0,
    policy: Annotated[str, typer.Option(metavar="NAME", help="Policy of the cases.")] = "paper",
) -> None:
    """Show one single ball of several campaigns side by side, such as other start phases.

    Prints a Markdown table: angles [deg] and energy changes [J].

    Example: `millscale analyse variants runs/trapezoid runs/parallel --S 2.6`
    """
    from millscale.analysis.variants import markdown, variant_rows

    typer.echo(markdown(variant_rows(runs, ratio, policy)))


@analyse.command()
def pictures(
    folder: CaseArgument,
    to: Annotated[Path, typer.Option(metavar="DIR", help="Folder for the PNG files.")],
    angle: Annotated[
        list[float], typer.Option(metavar="RAD", help="Mill angle [rad]; repeatable.")
    ],
) -> None:
    """Draw a multi-ball case at the dumps nearest to some mill angles, as CASE-MRAD.png.

    Balls that started on the rising side are red, the others blue.

    Example: `millscale analyse pictures runs/quick/cases/mb-cg-paper-S2.600 --angle 1.5 --to .`
    """
    from millscale.report.charge_pictures import draw_pictures

    to.mkdir(parents=True, exist_ok=True)
    for path, mill_angle in draw_pictures(folder, angle, to):
        typer.echo(f"{path}: {mill_angle:.3f} rad")
