"""`millscale report`: the page of a campaign, also as PDF and as figures for papers."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path
from typing import Annotated

import typer

from millscale.cli.options import Json, RunsArgument
from millscale.errors import CampaignError


def report(
    runs: RunsArgument,
    as_json: Json = False,
    pdf: Annotated[
        bool, typer.Option("--pdf", help="Also print the page to report.pdf; needs Chromium.")
    ] = False,
    figures: Annotated[
        Path | None,
        typer.Option("--figures", metavar="FOLDER", help="Also write all figures as SVG and PDF."),
    ] = None,
    width: Annotated[
        float | None,
        typer.Option(metavar="MM", help="Width of these figures [mm]. Default: 190, two columns."),
    ] = None,
) -> None:
    """Compare the finished cases: write DIR/report/index.html and results.json.

    The page needs no other file. Cases that were run by hand are analysed first. Figures of
    --figures have text as text and TrueType fonts; an earlier folder of figures is replaced.

    Examples: `millscale report runs/quick --json`, `millscale report runs/quick --pdf`,
    `millscale report runs/quick --figures figures --width 90`
    """
    from millscale.prediction.of_report import predicted_numbers
    from millscale.report.build import build_report
    from millscale.workflow.without_engine import finish

    if figures:
        from millscale.report.vectors import NARROWEST_MM, WIDEST_MM, WIDTH_MM, figures_written

        width = WIDTH_MM if width is None else width
        if not NARROWEST_MM <= width <= WIDEST_MM:
            accepted = f"{NARROWEST_MM:g} to {WIDEST_MM:g} mm"
            raise CampaignError("millscale report", "--width", f"got {width:g}", accepted)
    for line in finish(runs):
        typer.echo(line, err=True)
    with figures_written(figures, width) if figures and width else nullcontext():
        build_report(runs, predicted_numbers)
    folder = runs / "report"
    written = [f"report: {folder / 'index.html'}"]
    if pdf:
        from millscale.report.printed import PDF, print_page

        written.append(f"print: {print_page(folder / 'index.html', folder / PDF)}")
    if figures:
        written.append(f"figures: {figures}")
    if as_json:
        typer.echo((folder / "results.json").read_text(encoding="utf-8").rstrip("\n"))
    else:
        typer.echo("\n".join(written))
