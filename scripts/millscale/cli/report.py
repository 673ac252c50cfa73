"""`millscale report`: the page of a campaign, also as PDF and as figures for papers."""

from __future__ import annotations

from typing import Annotated

import typer

from millscale.cli.options import Json, RunsArgument


def report(
    runs: RunsArgument,
    as_json: Json = False,
    pdf: Annotated[
        bool, typer.Option("--pdf", help="Also print the page to report.pdf; needs Chromium.")
    ] = False,
) -> None:
    """Compare the finished cases: write DIR/report/index.html and results.json.

    The page needs no other file. Cases that were run by hand are analysed first.

    Examples: `millscale report runs/quick --json`, `millscale report runs/quick --pdf`
    """
    from millscale.prediction.of_report import predicted_numbers
    from millscale.report.build import build_report
    from millscale.workflow.without_engine import finish

    for line in finish(runs):
        typer.echo(line, err=True)
    page = build_report(runs, predicted_numbers)
    folder = runs / "report"
    if pdf:
        from millscale.report.printed import PDF, print_page

        printed = print_page(page, folder / PDF)
    if as_json:
        typer.echo((folder / "results.json").read_text(encoding="utf-8").rstrip("\n"))
        return
    typer.echo(f"report: {folder / 'index.html'}")
    if pdf:
        typer.echo(f"print: {printed}")
