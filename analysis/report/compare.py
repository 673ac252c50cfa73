"""The page of several runs folders: FOLDER/index.html (self-contained), comparison.json, images."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from markupsafe import Markup

from millscale.analysis import measures
from millscale.analysis.charge.speed_error import SHOWN
from millscale.engine.record import provenance
from millscale.report.build import PAGE, environment
from millscale.report.figures import side_by_side as figures
from millscale.report.images import Image, save_image
from millscale.report.interactive import Chart, packed, plotting_script
from millscale.report.likeness import differing_parts, questions
from millscale.report.overview import LEVEL, QUANTITIES
from millscale.report.side_by_side import (
    BallGroup,
    Change,
    Group,
    SideBySide,
    SideRow,
    side_by_side,
)
from millscale.runs.untrusted import RunFolderError, understood
from millscale.runs.writing import write_json, write_text, writing_folder

INDEX, RESULTS = "index.html", "comparison.json"
SCHEMA = 1
# Images are drawn of so many groups; tables hold all.
MOST_DRAWN = 6


@dataclass(frozen=True)
class GroupImages:
    """A group of like mills and its images."""

    group: Group
    answers: Image | None
    contours: list[Image]
    series: list[Image]


@dataclass(frozen=True)
class BallImages:
    """A group of like single balls and its image."""

    group: BallGroup
    trajectory: Image | None


def write_comparison(found: SideBySide, to: Path) -> Path:
    """Write a comparison into a folder and return its page.

    Raises:
        RunFolderError: the folder is there, and is no comparison.
    """
    to = Path(to)
    check_replaceable(to)
    to.parent.mkdir(parents=True, exist_ok=True)
    with writing_folder(to) as part:
        write_json(part / RESULTS, document(found))
        write_text(part / INDEX, _page(found, part))
    return to / INDEX


def compare_runs(runs: Sequence[Path], to: Path) -> Path:
    """Compare runs folders, write the page and return it.

    Raises:
        RunFolderError: fewer than two folders, one without finished case, or a damaged file.
    """
    check_replaceable(Path(to))
    with understood(Path(runs[0]), "find the file with: millscale verify DIR"):
        return write_comparison(side_by_side([Path(x) for x in runs]), to)


def check_replaceable(to: Path) -> None:
    """Refuse a folder that is there and holds no comparison: it is not replaced."""
    if (to.exists() or to.is_symlink()) and not (to / RESULTS).is_file():
        raise RunFolderError(
            to, "is there, and is no earlier comparison", "name a new folder: --to"
        )


def document(found: SideBySide) -> dict[str, Any]:
    """Return the content of comparison.json; keys: docs/reference/files.md."""
    return {
        "schema": SCHEMA,
        **provenance(),
        "runs": [{"name": side.name, "folder": str(side.runs)} for side in found.sides],
        "differing": [
            {"about": row.fact.about, "fact": row.fact.label, "unit": row.fact.unit}
            | {"values": list(row.values)}
            for row in found.differing
        ],
        "campaign_keys": [{"key": row.key, "values": list(row.values)} for row in found.keys],
        "questions": [
            {"question": x.question, "state": x.state, "found": x.found, "remedy": x.remedy}
            for x in questions(found)
        ],
        "multi_ball": [_row(group, row) for group in found.groups for row in group.rows],
        "single_ball": [
            {"group": group.kind.text, "runs": side.name, **row.document()}
            for group in found.balls
            for side, row in zip(group.sides, group.rows, strict=True)
        ],
    }


def _row(group: Group, row: SideRow) -> dict[str, Any]:
    return {
        "group": group.title,
        "runs": row.side.name,
        "ids": [charge.id for charge in row.charges],
        "physical_mill": {
            quantity.heading: {
                "value": estimate.value,
                "half_width": estimate.half_width,
                "difference": change.value if change else None,
                "difference_half_width": change.half_width if change else None,
            }
            for quantity, estimate, change in zip(
                QUANTITIES, row.row.estimates, row.changes, strict=True
            )
        },
        "dimensionless": row.numbers,
        "errors": None if row.errors is None else row.errors.document(),
        "between_seeds": None if row.between_seeds is None else row.between_seeds.document(),
    }


def _page(found: SideBySide, folder: Path) -> str:
    colours = figures.colours_of(found.sides)
    charts: list[Chart] = []

    def chart_number(image: Image) -> int:
        assert image.chart is not None
        charts.append(image.chart)
        return len(charts) - 1

    return (
        environment()
        .get_template("compare.html.j2")
        .render(
            plotly=plotting_script(),
            script=Markup((PAGE / "report.js").read_text(encoding="utf-8")),
            chart_number=chart_number,
            interactive_content=lambda: packed({"charts": charts, "views": {}}),
            found=found,
            colours=colours,
            parts=differing_parts(found),
            questions=questions(found),
            groups=[
                _images(found, group, colours, folder, number < MOST_DRAWN)
                for number, group in enumerate(found.groups)
            ],
            balls=[
                _ball_images(group, colours, folder, number < MOST_DRAWN)
                for number, group in enumerate(found.balls)
            ],
            quantities=QUANTITIES,
            shown=[i for i, quantity in enumerate(QUANTITIES) if quantity.on_first_screen],
            measures=measures,
            numbers=[x for x in measures.NUMBERS if _is_known(found, x.name)],
            errors=[x for x in SHOWN if _has_error(found, x.name)],
            change_text=change_text,
            level=LEVEL,
            provenance=provenance(),
        )
    )


def change_text(change: Change | None, digits: int) -> str:
    """Return a difference as it is shown: with its interval and its share."""
    if change is None:
        return ""
    interval = "" if change.half_width is None else f" ± {change.half_width:.{digits}f}"
    share = "" if change.share is None else f" ({100.0 * change.share:+.1f} %)"
    return f"{change.value:+.{digits}f}{interval}{share}"


def _is_known(found: SideBySide, name: str) -> bool:
    return any(row.numbers.get(name) is not None for group in found.groups for row in group.rows)


def _has_error(found: SideBySide, name: str) -> bool:
    return any(
        row.errors is not None and row.errors.steady(name) is not None
        for group in found.groups
        for row in group.rows
    )


def _images(
    found: SideBySide, group: Group, colours: dict[str, str], to: Path, drawn: bool
) -> GroupImages:
    if not drawn:
        return GroupImages(group, None, [], [])
    name, title = group.file_name, group.title
    image = save_image(
        figures.answers(found, group, colours),
        to / f"answers-{name}.png",
        f"{title}: power and shape of the physical mill, {100.0 * LEVEL:g} % intervals",
    )
    different_size = len({row.row.physical.radius for row in group.rows}) > 1
    contours = []
    for physical in (False, True) if different_size else (False,):
        figure = figures.contours(group, found.measured, colours, physical)
        if figure is not None:
            unit = "metres of the physical mill" if physical else "over R - a"
            path = to / f"contours-{name}{'-physical' if physical else ''}.png"
            contours.append(save_image(figure, path, f"{title}: surface and liner, {unit}"))
    series = [
        save_image(
            figures.series(group, colours, physical),
            to / f"series-{name}{'-physical' if physical else ''}.png",
            f"{title}: {'of the whole physical mill' if physical else 'dimensionless'}",
        )
        for physical in (True, False)
    ]
    return GroupImages(group, image, contours, series)


def _ball_images(group: BallGroup, colours: dict[str, str], to: Path, drawn: bool) -> BallImages:
    if not drawn:
        return BallImages(group, None)
    figure = figures.trajectories(group, colours)
    path = to / f"path-{group.kind.file_name}.png"
    caption = f"{group.kind.text}: path of the centre over R, first cycle"
    return BallImages(group, save_image(figure, path, caption))
