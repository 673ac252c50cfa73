"""The images of a report: drawn into its folder, with captions."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import TypeVar

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image as Picture

from millscale.analysis.finished import Charge, SingleBall
from millscale.analysis.finished_campaign import Campaign
from millscale.analysis.forked import forked
from millscale.analysis.single_ball import comparison
from millscale.report.captions import charges_of, scales_of, words
from millscale.report.charge_pictures import draw_pictures
from millscale.report.figures import charge as charge_figures
from millscale.report.figures import single_ball as figures
from millscale.report.figures.energy_budget import energy_budget_figure
from millscale.report.interactive import Chart, chart_of
from millscale.report.vectors import write_vectors
from millscale.runs.untrusted import RunFolderError

DPI = 110
QUALITY, WEBP_METHOD = 80, 2  # of the images in the page
PNG_LEVEL = 3
FINEST_PICTURES_RAD = 0.5
MOST_CURVES = 12  # of one kind in a figure
C = TypeVar("C")
MOST_PICTURES = 6


@dataclass(frozen=True)
class Image:
    """A drawn image of the report.

    Attributes:
        data: the file as a data URL of a smaller format, so that the page needs no other file.
        chart: of `interactive.chart_of`; None where the image alone is shown.
    """

    path: Path
    caption: str
    data: str
    chart: Chart | None = None


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
    groups = list(comparison.by_policy(campaign.single).items())
    drawn: dict[str, PolicyFigures] = {}
    for one in forked(lambda group: _of_policy(*group[0], group[1], to), groups):
        known = drawn.setdefault(one.policy, PolicyFigures(one.policy, [], []))
        known.trajectories.extend(one.trajectories)
        known.energies.extend(one.energies)
    return list(drawn.values())


def _of_policy(scheme: str, policy: str, every: Sequence[SingleBall], to: Path) -> PolicyFigures:
    """Draw Figs. 6 and 7 for one policy of a scheme."""
    balls = spread(every)
    name, of = f"{scheme}-{policy}", f"{words(scheme)}, policy {policy}, {scales_of(balls)}"
    if len(balls) < len(every):
        of += f" ({len(balls)} of {len(every)} cases)"
    trajectories = [
        save_image(
            figures.trajectories(balls, over_radius=over),
            to / f"fig6-{name}{'-over-R' if over else ''}.png",
            f"path of a single ball, {of}, {unit}",
        )
        for over, unit in ((False, "in metres"), (True, "over R: similar paths coincide"))
    ]
    over_prediction = "over the predicted ratio: similar curves coincide"
    energies = [
        save_image(
            figures.energy_curves(balls, over_prediction=over),
            to / f"fig7-{name}{'-over-prediction' if over else ''}.png",
            f"energies of a single ball, {of}, {unit}",
        )
        for over, unit in ((False, "in joules"), (True, over_prediction))
    ]
    return PolicyFigures(policy, trajectories, energies)


def spread(cases: Sequence[C]) -> list[C]:
    """Return MOST_CURVES of some cases, evenly from the first to the last: more curves in a figure
    are not told apart."""
    if len(cases) <= MOST_CURVES:
        return list(cases)
    return [cases[i] for i in np.linspace(0, len(cases) - 1, MOST_CURVES).round().astype(int)]


def ratio_figures(campaign: Campaign, to: Path) -> dict[str, Image]:
    """Draw Fig. 8 of each scheme with a case at S = 1."""
    grouped = {s: list(rows) for s, rows in groupby(campaign.rows, key=lambda row: row.scheme)}
    return {
        scheme: save_image(
            figures.energy_ratios(scheme, rows, campaign.of_paper),
            to / f"fig8-{scheme}.png",
            f"{words(scheme)}, {scales_of([row.ball for row in rows])}: energy ratio of a single "
            "ball against its prediction, and the deviation below; the law holds on the line",
        )
        for scheme, rows in grouped.items()
        if any(row.reference for row in rows)
    }


def charge_overview(campaign: Campaign, to: Path) -> Image | None:
    """Draw all multi-ball cases in one dimensionless figure."""
    if not campaign.charges:
        return None
    first = [mill.first for mill in campaign.comparison.charges.mills]
    drawn = campaign.charges if len(campaign.charges) <= MOST_CURVES else spread(first)
    figure = charge_figures.charge_series(drawn, dimensionless=True)
    caption = f"energies, torque, power and centre of mass, dimensionless: {charges_of(drawn)}; "
    return save_image(figure, to / "charges.png", caption + "similar mills coincide")


def all_charges(charges: Sequence[Charge], to: Path) -> list[ChargeFigures]:
    """Draw pictures and time series of every multi-ball case."""
    return forked(lambda charge: charge_images(charge, to), charges)


def charge_images(charge: Charge, to: Path) -> ChargeFigures:
    """Draw pictures (Figs. 9 and 10) and time series of one multi-ball case."""
    of = f"{charge.id}, {charge.balls:,} balls, seed {charge.seed}"
    series = [
        save_image(
            charge_figures.charge_series([charge], dimensionless=False),
            to / f"{charge.id}-series.png",
            f"{of}: energies, torque, power, centre of mass; a steady charge has constant means",
        ),
        save_image(
            charge_figures.charge_states(charge),
            to / f"{charge.id}-states.png",
            f"{of}: shares of the balls on the wall, in the bed and in flight",
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
    pictures = [_image_of(path, f"{of}, at {angle:.2f} rad") for path, angle in drawn]
    return ChargeFigures(charge.id, pictures, series, "")


def _image_of(path: Path, caption: str) -> Image:
    with Picture.open(path) as picture:
        return Image(path, caption, _data(picture))


def _picture_angles(charge: Charge) -> list[float]:
    """Return mill angles 0, 0.5, 1, ... rad, twice as far apart until there are not too many."""
    end = charge.result.rotation_angle_rad
    step = FINEST_PICTURES_RAD
    while end / step >= MOST_PICTURES:
        step *= 2.0
    return [step * i for i in range(MOST_PICTURES) if step * i <= end + 0.1 * step]


def save_image(figure: Figure, path: Path, caption: str) -> Image:
    """Draw a figure into a file of the report: the pixels of `savefig`, which draws it twice where
    axes have a layout."""
    figure.set_dpi(DPI)
    canvas = FigureCanvasAgg(figure)
    layout = figure.get_layout_engine()
    if layout is not None:
        layout.execute(figure)
        figure.set_layout_engine("none")
    canvas.draw()
    picture = Picture.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")
    picture.save(path, compress_level=PNG_LEVEL)
    image = Image(path, caption, _data(picture), chart_of(figure))
    write_vectors(figure, layout, path.stem, caption)
    return image


def _data(picture: Picture.Image) -> str:
    small = io.BytesIO()
    picture.save(small, "WEBP", quality=QUALITY, method=WEBP_METHOD)
    return "data:image/webp;base64," + base64.b64encode(small.getvalue()).decode()
