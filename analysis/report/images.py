"""The images of a report: drawn into its folder, with captions."""

from __future__ import annotations

import base64
import io
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image as Picture

from millscale.analysis.finished import Charge
from millscale.analysis.finished_campaign import Campaign
from millscale.analysis.single_ball import comparison
from millscale.report.figures import charge as charge_figures
from millscale.report.figures import single_ball as figures
from millscale.report.figures.energy_budget import energy_budget_figure
from millscale.report.interactive import Chart, chart_of
from millscale.report.picture_process import draw_pictures
from millscale.runs.untrusted import RunFolderError

DPI = 140
QUALITY = 80  # of the images in the page
FINEST_PICTURES_RAD = 0.5
MOST_PICTURES = 6


@dataclass(frozen=True)
class Image:
    """A drawn image of the report.

    Attributes:
        chart: of `interactive.chart_of`; None where the image alone is shown.
    """

    path: Path
    caption: str
    chart: Chart | None = None

    @property
    def data(self) -> str:
        """Return the file as a data URL of a smaller format, so that the page needs no other
        file."""
        small = io.BytesIO()
        with Picture.open(self.path) as picture:
            picture.save(small, "WEBP", quality=QUALITY, method=4)
        return "data:image/webp;base64," + base64.b64encode(small.getvalue()).decode()


@dataclass(frozen=True)
class PolicyFigures:
    """Figs. 6 and 7 of one policy."""

    policy: str
    trajectories: list[Image]
    energies: list[Image]


@dataclass(frozen=True)
class ChargeFigures:
    """Figures of one multi-ball case; `problem`: why there are no pictures."""

    id: str
    pictures: list[Image]
    series: list[Image]
    problem: str


def policy_figures(campaign: Campaign, to: Path) -> list[PolicyFigures]:
    """Draw Figs. 6 and 7 for each policy, all schemes."""
    drawn: dict[str, PolicyFigures] = {}
    for (scheme, policy), balls in comparison.by_policy(campaign.single).items():
        entry = drawn.setdefault(policy, PolicyFigures(policy, [], []))
        name = f"{scheme}-{policy}"
        for over, unit in ((False, "in metres"), (True, "over the mill radius R")):
            entry.trajectories.append(
                save_image(
                    figures.trajectories(balls, over_radius=over),
                    to / f"fig6-{name}{'-over-R' if over else ''}.png",
                    f"{words(scheme)}, {unit}",
                )
            )
        for over, unit in ((False, "[J]"), (True, "over the predicted ratio")):
            entry.energies.append(
                save_image(
                    figures.energy_curves(balls, over_prediction=over),
                    to / f"fig7-{name}{'-over-prediction' if over else ''}.png",
                    f"{words(scheme)}, {unit}",
                )
            )
    return list(drawn.values())


def ratio_figures(campaign: Campaign, to: Path) -> dict[str, Image]:
    """Draw Fig. 8 of each scheme."""
    return {
        scheme: save_image(
            figures.energy_ratios(scheme, list(rows), campaign.of_paper),
            to / f"fig8-{scheme}.png",
            f"{words(scheme)}: energy ratio against its prediction",
        )
        for scheme, rows in groupby(campaign.rows, key=lambda row: row.scheme)
    }


def charge_overview(campaign: Campaign, to: Path) -> Image | None:
    """Draw all multi-ball cases in one dimensionless figure."""
    if not campaign.charges:
        return None
    figure = charge_figures.charge_series(campaign.charges, dimensionless=True)
    return save_image(figure, to / "charges.png", "all cases, dimensionless")


def charge_images(charge: Charge, to: Path) -> ChargeFigures:
    """Draw pictures (Figs. 9 and 10) and time series of one multi-ball case."""
    of = f"{charge.id}, {charge.balls:,} balls, seed {charge.seed}"
    series = [
        save_image(
            charge_figures.charge_series([charge], dimensionless=False),
            to / f"{charge.id}-series.png",
            f"{of}: energies, torque, power, centre of mass",
        ),
        save_image(
            charge_figures.charge_states(charge),
            to / f"{charge.id}-states.png",
            f"{of}: balls on the wall, in the bed and in flight",
        ),
    ]
    if charge.result.ledger is not None:
        series.append(
            save_image(
                energy_budget_figure(charge.result.ledger),
                to / f"{charge.id}-ledger.png",
                f"{of}: dissipation by cause, and the impacts of a revolution by energy",
            )
        )
    try:
        drawn = draw_pictures(charge.folder, _picture_angles(charge), to)
    except RunFolderError as error:
        return ChargeFigures(charge.id, [], series, str(error))
    pictures = [Image(path, f"{angle:.2f} rad") for path, angle in drawn]
    return ChargeFigures(charge.id, pictures, series, "")


def words(scheme: str) -> str:
    """Return the name of a scheme for a caption."""
    return scheme.replace("-", " ")


def _picture_angles(charge: Charge) -> list[float]:
    """Return mill angles 0, 0.5, 1, ... rad, twice as far apart until there are not too many."""
    end = charge.result.rotation_angle_rad
    step = FINEST_PICTURES_RAD
    while end / step >= MOST_PICTURES:
        step *= 2.0
    return [step * i for i in range(MOST_PICTURES) if step * i <= end + 0.1 * step]


def save_image(figure: Figure, path: Path, caption: str) -> Image:
    """Draw a figure into a file of the report: the bytes of `savefig`, which draws it twice where
    axes have a layout."""
    figure.set_dpi(DPI)
    canvas = FigureCanvasAgg(figure)
    layout = figure.get_layout_engine()
    if layout is not None:
        layout.execute(figure)
        figure.set_layout_engine("none")
    with path.open("wb") as file:
        canvas.print_png(file)
    return Image(path, caption, chart_of(figure))
