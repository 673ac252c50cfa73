"""A case as tables (CSV), with headings in words and a unit: series, shapes, contours, balls."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from millscale.analysis.case_rows import case_rows
from millscale.analysis.charge.energy_budget import read_ledger
from millscale.analysis.columns import heading_of
from millscale.analysis.finished import Charge, SingleBall
from millscale.analysis.finished_campaign import Campaign
from millscale.analysis.shapes.shape import Shape, physical_unit_length, shape_of
from millscale.analysis.shapes.snapshots import snapshots_of
from millscale.exports.columns import name_with_unit
from millscale.runs.dumps import dump_files, read_dump
from millscale.runs.layout import LEDGER_FILES
from millscale.runs.series import Series
from millscale.runs.writing import write_text

CASES, SERIES, LEDGER, SHAPES, CONTOURS = (
    "cases.csv",
    "series.csv",
    "energy-budget.csv",
    "shapes.csv",
    "contours.csv",
)
# Angles of a shape; those of toe and shoulder are from the vertical.
_OF_SHAPE = ("mill angle [rad]", "toe [deg]", "shoulder [deg]", "balls thrown at [deg]",
             "thrown balls land at [deg]", "solid fraction of the bed")  # fmt: skip
_OF_CONTOUR = ("mill angle [rad]", "line", "x / (R - a)", "z / (R - a)",
               "x in the physical mill [m]", "z in the physical mill [m]")  # fmt: skip


def write_cases(campaign: Campaign, to: Path) -> Path:
    """Write a row for each finished case into a folder; return the file."""
    rows = case_rows(campaign)
    headings = [heading_of(name) for name in rows[0]]
    _write(to / CASES, headings, [row.values() for row in rows])
    return to / CASES


def write_tables(case: SingleBall | Charge, to: Path, every: int) -> Path:
    """Write the tables of a case into a folder; return the first one.

    Args:
        every: of a charge with dumps, write every so many of them.

    Raises:
        RunFolderError: a damaged file.
    """
    _write_series(to / SERIES, case.series)
    if isinstance(case, Charge):
        if all((case.folder / name).exists() for name in LEDGER_FILES):
            _write_series(to / LEDGER, read_ledger(case.folder))
        if dump_files(case.folder):
            _write_dumps(case, to, every)
    return to / SERIES


def _write_series(path: Path, series: Series) -> None:
    _write(path, [heading_of(name) for name in series], zip(*series.values(), strict=True))


def _write_dumps(charge: Charge, to: Path, every: int) -> None:
    shapes, contours = [], []
    for number, snapshot in enumerate(snapshots_of(charge.folder)[::every]):
        dump = read_dump(snapshot.path)
        shape = shape_of(dump, snapshot, charge.case)
        shapes.append(_shape_row(shape))
        contours += _contour_rows(shape, charge)
        headings = [heading_of(name_with_unit(name)) for name in dump.columns]
        rows = zip(*dump.columns.values(), strict=True)
        _write(to / f"balls.{number:05d}.csv", headings, rows)
    _write(to / SHAPES, _OF_SHAPE, shapes)
    _write(to / CONTOURS, _OF_CONTOUR, contours)


def _shape_row(shape: Shape) -> list[float | None]:
    ends = (shape.ends.toe, shape.ends.shoulder) if shape.ends else (None, None)
    angles = (*ends, shape.throw_angle, shape.landing_angle)
    degrees = [None if angle is None else math.degrees(angle) for angle in angles]
    return [shape.mill_angle, *degrees, shape.contour.bulk_fraction]


def _contour_rows(shape: Shape, charge: Charge) -> list[list[float]]:
    unit = physical_unit_length(charge.case)
    return [
        [shape.mill_angle, number, *point, *(unit * point)]
        for number, line in enumerate(shape.contour.lines)
        for point in line
    ]


def _write(path: Path, headings: Sequence[str], rows: Iterable[Iterable[Any]]) -> None:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(headings)
    writer.writerows([_cell(value) for value in row] for row in rows)
    write_text(path, text.getvalue())


def _cell(value: Any) -> Any:
    """Return a value as it is written: nine digits, nothing for what is not known."""
    if isinstance(value, float | np.floating):
        return f"{value:.9g}" if np.isfinite(value) else ""
    return "" if value is None else value
