"""The report of a campaign: report/index.html (self-contained), results.json and the images."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Sequence
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from millscale.analysis import measures
from millscale.analysis.charge.pair_errors import OF_DUMPS
from millscale.analysis.charge.speed_error import SHOWN, mill_rows
from millscale.analysis.finished_campaign import Campaign, load_campaign
from millscale.analysis.paper import numbers as paper
from millscale.analysis.single_ball.windows import common_windows
from millscale.formats import clock, duration, hundredths, number
from millscale.report import images, tables
from millscale.report import overview as first_screen
from millscale.report.ball_classes import class_lines
from millscale.report.breakage_section import breakage_section
from millscale.report.captions import words
from millscale.report.comparison_images import comparison_images
from millscale.report.impacts_section import impacts_section
from millscale.report.interactive import Chart, packed, plotting_script, views_of
from millscale.report.liner_section import liner_section
from millscale.report.mill_drawing import MillDrawing, mill_drawing
from millscale.runs.case_folder import verify_line
from millscale.runs.untrusted import RunFolderError, understood
from millscale.runs.writing import write_json, write_text, writing_folder

PAGE = Path(__file__).parent / "page"
MOST_OPEN = 24  # rows of a table that is not folded
REPORT, INDEX, RESULTS = "report", "index.html", "results.json"


Predict = Callable[[Campaign], Sequence[first_screen.Predicted]]


def build_report(runs: Path, predict: Predict | None = None) -> Path:
    """Write the report of a runs folder from its finished cases; returns its index.html.

    Cases that are not finished are named in it. An earlier report is replaced only when the new
    one is complete.

    Args:
        predict: returns numbers of the physical mill that are extrapolated from the campaign.

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
            write_text(part / INDEX, _page(campaign, part, predict))
    return folder / INDEX


def _page(campaign: Campaign, folder: Path, predict: Predict | None) -> str:
    comparison, shown = campaign.comparison, _shown(campaign)
    screen = first_screen.overview(campaign, predict(campaign) if predict else ())
    quantities = first_screen.QUANTITIES
    speeds = mill_rows(comparison.rows)
    charts: list[Chart] = []
    views = views_of(campaign.charges)

    def chart_number(image: images.Image) -> int:
        assert image.chart is not None
        charts.append(image.chart)
        return len(charts) - 1

    return (
        environment()
        .get_template("report.html.j2")
        .render(
            plotly=plotting_script(),
            script=Markup((PAGE / "report.js").read_text(encoding="utf-8")),
            views=views,
            chart_number=chart_number,
            interactive_content=lambda: packed({"charts": charts, "views": views}),
            campaign=campaign,
            overview=screen,
            drawing=_drawing(campaign, screen),
            quantities=quantities,
            shown_quantities=[
                i
                for i in range(len(quantities))
                if any(row.estimates[i].value is not None for row in screen.rows)
            ],
            level=first_screen.LEVEL,
            most_open=MOST_OPEN,
            hardware=tables.hardware(campaign),
            mills=tables.mill_lines(campaign),
            angles=tables.angle_tables(campaign),
            energies=tables.energy_tables(campaign),
            windows=common_windows(campaign.single),
            words=words,
            policies=images.policy_figures(campaign, folder),
            ratios=images.ratio_figures(campaign, folder),
            charge_overview=images.charge_overview(campaign, folder),
            charges=images.all_charges(campaign.charges, folder),
            shapes=comparison_images(comparison, folder),
            liner=liner_section(campaign.charges, folder),
            impacts=impacts_section(campaign.charges, folder),
            breakage=breakage_section(campaign.runs, campaign.charges, folder),
            speeds=speeds,
            has_speed_up=any(mill.speed_up and not mill.is_reference for mill in speeds),
            statements=tables.statements(campaign),
            of_paper=campaign.of_paper,
            paper=paper,
            measures=measures,
            # Columns that hold a number: of a campaign of one S every error is a dash.
            errors=[x for x in SHOWN if any(m.errors[x.name].mean is not None for m in speeds)],
            errors_of_schemes=[
                x
                for x in SHOWN
                if any(row.errors.steady(x.name) is not None for row in comparison.schemes)
            ],
            errors_of_dumps=[
                x
                for x in SHOWN
                if x.name in OF_DUMPS
                and any(row.errors.values[x.name] is not None for row in comparison.rows)
            ],
            classes={charge.id: class_lines(charge) for charge in campaign.charges},
            means=[x for x in shown if x.of_result],
            bed=[x for x in shown if not x.of_result],
        )
    )


def _drawing(campaign: Campaign, screen: first_screen.Overview) -> MillDrawing:
    if not screen.rows:
        return mill_drawing(campaign.cases[0].case)
    mill = first_screen.nearest(screen.rows).mill
    return mill_drawing(mill.first.case, campaign.comparison, mill)


def _shown(campaign: Campaign) -> list[measures.Quantity]:
    """Return the numbers of the tables; those of end walls only if a charge has them."""
    known = {
        name for row in campaign.comparison.rows for name, x in row.numbers.items() if x is not None
    }
    of_some = {"ends_power_share"}
    return [
        x for x in measures.NUMBERS if x.in_tables and (x.name in known or x.name not in of_some)
    ]


def environment() -> Environment:
    """Return the templates of pages, with the formats of numbers as filters."""
    made = Environment(
        loader=FileSystemLoader(PAGE), autoescape=True, undefined=StrictUndefined, trim_blocks=True
    )
    made.filters |= {
        "number": number,
        "clock": clock,
        "full_columns": tables.full_columns,
        "duration": duration,
        "hundredths": hundredths,
    }
    return made
