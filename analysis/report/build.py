"""The report of a campaign: report/index.html (self-contained), results.json and the images."""

from __future__ import annotations

import shlex
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from millscale.analysis import measures
from millscale.analysis.charge.pair_errors import OF_DUMPS
from millscale.analysis.charge.speed_error import SHOWN, mill_rows
from millscale.analysis.finished_campaign import Campaign, load_campaign
from millscale.analysis.paper import numbers as paper
from millscale.analysis.single_ball.windows import common_windows
from millscale.formats import duration, hundredths, number, percent
from millscale.report import images, tables
from millscale.report.comparison_images import comparison_images
from millscale.runs.case_folder import verify_line
from millscale.runs.untrusted import RunFolderError, understood
from millscale.runs.writing import write_json, write_text, writing_folder

PAGE = Path(__file__).parent / "page"
REPORT, INDEX, RESULTS = "report", "index.html", "results.json"


def build_report(runs: Path) -> Path:
    """Write the report of a runs folder from its finished cases; returns its index.html.

    Cases that are not finished are named in it. An earlier report is replaced only when the new
    one is complete.

    Raises:
        RunFolderError: the folder holds no campaign, or no case is finished.
    """
    campaign = load_campaign(Path(runs))
    if not campaign.single and not campaign.charges:
        raise RunFolderError(
            Path(runs),
            f"none of its {len(campaign.missing)} cases is finished",
            f"run them with: millscale run FILE --runs {shlex.quote(str(runs))}",
        )
    folder = campaign.runs / REPORT
    with writing_folder(folder) as part:
        write_json(part / RESULTS, campaign.results())
        with understood(campaign.runs, f"find the file with: {verify_line(campaign.runs)}"):
            write_text(part / INDEX, _page(campaign, part))
    return folder / INDEX


def _page(campaign: Campaign, folder: Path) -> str:
    comparison = campaign.comparison
    return (
        environment()
        .get_template("report.html.j2")
        .render(
            campaign=campaign,
            hardware=tables.hardware(campaign),
            mills=tables.mill_lines(campaign),
            angles=tables.angle_tables(campaign),
            energies=tables.energy_tables(campaign),
            windows=common_windows(campaign.single),
            words=images.words,
            policies=images.policy_figures(campaign, folder),
            ratios=images.ratio_figures(campaign, folder),
            charge_overview=images.charge_overview(campaign, folder),
            charges=[images.charge_images(charge, folder) for charge in campaign.charges],
            shapes=comparison_images(comparison, folder),
            speeds=mill_rows(comparison.rows),
            statements=tables.statements(campaign),
            of_paper=campaign.of_paper,
            paper=paper,
            measures=measures,
            errors=SHOWN,
            of_dumps=OF_DUMPS,
            means=[x for x in measures.NUMBERS if x.in_tables and x.of_result],
            bed=[x for x in measures.NUMBERS if x.in_tables and not x.of_result],
        )
    )


def environment() -> Environment:
    """Return the templates of pages, with the formats of numbers as filters."""
    made = Environment(
        loader=FileSystemLoader(PAGE), autoescape=True, undefined=StrictUndefined, trim_blocks=True
    )
    made.filters |= {
        "number": number,
        "percent": percent,
        "duration": duration,
        "hundredths": hundredths,
    }
    return made
