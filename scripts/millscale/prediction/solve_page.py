"""The answer of a solve: DIR/answer.json, DIR/report/index.html, a table for the terminal."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure
from rich.table import Table

from millscale.analysis.charge.physical_mill import PhysicalMill
from millscale.formats import NONE, counted, duration, hundredths, number
from millscale.prediction.contour import PredictedContour
from millscale.prediction.error_model import CONTOUR, label_of
from millscale.prediction.result import PredictedNumber, Prediction
from millscale.prediction.solve import MET, Ask, Look, Outcome, Round
from millscale.report.build import INDEX, REPORT, environment
from millscale.report.figures.style import STYLE
from millscale.report.images import Image, save_image
from millscale.runs.writing import write_json, write_text, writing_folder

SCHEMA = 1
ANSWER = "answer.json"
# Colour-blind safe (Okabe and Ito).
_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
_MARKS = "osD^vP"


@dataclass(frozen=True)
class Answer:
    """What a solve found, and how.

    Attributes:
        prediction: of the physical mill; None if the runs allow none, which `refused` explains.
        look: what the runs give.
        model_origin: of the errors that the first plan was made with.
    """

    ask: Ask
    outcome: Outcome
    rounds: tuple[Round, ...]
    look: Look
    prediction: Prediction | None
    refused: str
    model_origin: Mapping[str, Any]

    @property
    def is_met(self) -> bool:
        return self.outcome.kind == MET

    @property
    def runs(self) -> int:
        """Return the number of finished runs."""
        return sum(len(x.runs) for x in self.rounds if x.done)

    def document(self) -> dict[str, Any]:
        """Return it as JSON types."""
        return {
            "schema": SCHEMA,
            "is_met": self.is_met,
            "ended": asdict(self.outcome),
            "asked": asdict(self.ask),
            "half_widths": {name: track.half_width for name, track in self.look.tracks.items()},
            "spent_s": self.look.spent_s,
            "rounds": [asdict(x) for x in self.rounds],
            "prediction": self.prediction.document() if self.prediction else None,
            "refused": self.refused,
        }


@dataclass(frozen=True)
class AnswerRow:
    """An observable of the physical mill as text, and its relative half width.

    Attributes:
        is_wanted: whether it was asked for.
        is_met: whether its interval is narrow enough; None if it was not asked for.
    """

    label: str
    unit: str
    value: str
    interval: str
    half_width: str
    relative: float | None
    is_wanted: bool
    is_met: bool | None


def answer_rows(answer: Answer) -> list[AnswerRow]:
    """Return the observables that were asked for, then the others."""
    prediction = answer.prediction
    if prediction is None:
        return []
    rows = {x.observable.name: _row(answer, x) for x in prediction.numbers if x.found}
    if prediction.contour:
        rows[CONTOUR] = _contour_row(answer, prediction.contour, prediction.mill)
    return sorted(rows.values(), key=lambda row: not row.is_wanted)


def _row(answer: Answer, found: PredictedNumber) -> AnswerRow:
    judged = _judged(answer, found.observable.name)
    return AnswerRow(found.observable.label, *found.cells, *judged)


def _contour_row(answer: Answer, contour: PredictedContour, mill: PhysicalMill) -> AnswerRow:
    half = 1e3 * (mill.radius - mill.ball_radius) * float(contour.half_widths.mean())
    points = counted(len(contour.points), "point")
    return AnswerRow(
        label_of(CONTOUR), "mm", points, NONE, number(half, 1), *_judged(answer, CONTOUR)
    )


def _judged(answer: Answer, name: str) -> tuple[float | None, bool, bool | None]:
    width, wanted = answer.look.half_width(name), name in answer.ask.names
    known = width if math.isfinite(width) else None
    return known, wanted, width <= answer.ask.error if wanted else None


def answer_table(answer: Answer) -> Table:
    """Return the answer for a terminal."""
    title = answer.prediction.title if answer.prediction else "Physical mill"
    table = Table(title=title, title_justify="left")
    table.add_column("observable")
    headings = ("unit", "predicted", f"{100 * answer.ask.level:g} % interval", "half width", "%")
    for heading in headings:
        table.add_column(heading, justify="right")
    table.add_column(f"within {100 * answer.ask.error:g} %")
    verdicts = {True: "yes", False: "no", None: ""}
    for row in answer_rows(answer):
        relative = hundredths(row.relative)
        shown = row.label, row.unit, row.value, row.interval, row.half_width, relative
        table.add_row(*shown, verdicts[row.is_met], style="" if row.is_wanted else "dim")
    return table


def answer_lines(answer: Answer, folder: Path) -> Iterator[str]:
    """Yield what stands below the table: why it ended, the rounds, what may mislead."""
    yield f"{answer.outcome.kind}: {answer.outcome.text}"
    for x in answer.rounds:
        widths = ", ".join(
            f"{name} {hundredths(x.half_widths.get(name))} %" for name in answer.ask.names
        )
        spent = f"; {duration(x.spent_s)} so far" if x.spent_s is not None else ""
        yield f"  round {x.number}: {x.text}: {widths}{spent}"
    yield from (f"warning: {text}" for text in warnings_of(answer))
    yield f"page: {folder / REPORT / INDEX}"


def warnings_of(answer: Answer) -> Iterator[str]:
    """Yield what may mislead about an answer, and what is not predicted."""
    if answer.refused:
        yield answer.refused
    for (S, seed), why in answer.look.unsteady.items():
        if (S, seed) not in answer.look.used:
            yield f"not used: S = {S:g}, seed {seed}: {why}"
    if answer.prediction is None:
        return
    yield from answer.prediction.warnings
    for row in answer.prediction.numbers:
        if row.refused:
            yield f"not predicted: {row.observable.label}: {row.refused}"
    if answer.prediction.contour is None:
        yield f"not predicted: {label_of(CONTOUR)}: {answer.prediction.contour_refused}"


def write_answer(folder: Path, answer: Answer, provenance: dict[str, Any]) -> None:
    """Write answer.json and the page. An earlier page is replaced only when the new one is
    complete.

    Args:
        provenance: command, commit, machine and date.
    """
    write_json(folder / ANSWER, provenance | answer.document())
    with writing_folder(folder / REPORT) as part:
        write_text(part / INDEX, _page(answer, provenance, part))


def _page(answer: Answer, provenance: dict[str, Any], folder: Path) -> str:
    figures = [
        save_image(
            half_widths_figure(answer),
            folder / "half-widths.png",
            "Half width of each interval after each round. Dotted: wanted.",
        )
    ]
    if answer.prediction and answer.prediction.contour:
        figures.append(_contour_image(answer.prediction, answer.prediction.contour, folder))
    return (
        environment()
        .get_template("solve.html.j2")
        .render(
            answer=answer,
            mill=answer.prediction.mill if answer.prediction else None,
            rows=answer_rows(answer),
            labels={name: label_of(name) for name in answer.ask.names},
            warnings=list(warnings_of(answer)),
            figures=figures,
            provenance=provenance,
        )
    )


def half_widths_figure(answer: Answer) -> Figure:
    """Return the relative half width of each wanted observable against the time spent."""
    with rc_context(STYLE):
        figure = Figure(figsize=(5.4, 3.6), layout="constrained")
        axes = figure.add_subplot()
        known = [x for x in answer.rounds if x.spent_s is not None]
        for name, colour, mark in zip(answer.ask.names, _COLOURS * 9, _MARKS * 9, strict=False):
            points = [
                (x.spent_s / 60.0, 100.0 * width)
                for x in known
                if x.spent_s is not None and (width := x.half_widths.get(name)) is not None
            ]
            if points:
                axes.plot(*zip(*points, strict=True), marker=mark, color=colour, label=name)
        axes.axhline(100.0 * answer.ask.error, color="#444", ls=":", lw=1.0)
        if answer.ask.budget_s is not None:
            axes.axvline(answer.ask.budget_s / 60.0, color="#444", ls="--", lw=0.8)
        axes.set_xlim(left=0.0)
        axes.set_ylim(bottom=0.0)
        axes.set_xlabel("time on one core [min]")
        axes.set_ylabel("half width of the interval [%]")
        if axes.get_legend_handles_labels()[0]:
            axes.legend()
    return figure


def contour_figure(contour: PredictedContour, mill: PhysicalMill) -> Figure:
    """Return the predicted surface of the bed with its interval, inside the mill."""
    unit = mill.radius - mill.ball_radius
    points, normals = unit * contour.points, _normals(contour.points)
    reach = unit * contour.half_widths[:, None] * normals
    turn = np.linspace(0.0, 2.0 * np.pi, 361)
    with rc_context(STYLE):
        figure = Figure(figsize=(3.6, 3.6), layout="constrained")
        axes = figure.add_subplot()
        axes.plot(mill.radius * np.cos(turn), mill.radius * np.sin(turn), color="#888", lw=0.9)
        band = np.vstack([points + reach, (points - reach)[::-1]])
        axes.fill(*band.T, color=_COLOURS[0], alpha=0.3, lw=0.0)
        axes.plot(*points.T, color=_COLOURS[0], lw=1.1)
        axes.set_aspect("equal")
        axes.set_xlabel("x [m]")
        axes.set_ylabel("z [m]")
    return figure


def _contour_image(prediction: Prediction, contour: PredictedContour, folder: Path) -> Image:
    return save_image(
        contour_figure(contour, prediction.mill),
        folder / "contour.png",
        "Predicted surface of the bed. Shaded: its interval. The bottom of the mill moves to -x.",
    )


def _normals(points: np.ndarray) -> np.ndarray:
    tangents = np.gradient(points, axis=0)
    tangents /= np.linalg.norm(tangents, axis=1)[:, None]
    return np.column_stack([-tangents[:, 1], tangents[:, 0]])
