"""Figures of a study: every setting with its name, the front, what is within its spread."""

from dataclasses import replace

import pytest

from millscale.analysis.measures import STUDIED
from millscale.study import pareto
from millscale.study.figures import time_against_error
from synthetic_rows import error, row

ROWS = [
    row("truth", 99.0, None, is_reference=True),
    row("fast", 1.0, 0.08, 0.01),
    row("stock", 20.0, 0.08, 0.01, engine="stock"),
    row("lucky", 30.0, 0.0, 0.02),
    row("holed", 5.0, 0.01, errors={name: error(None) for name in STUDIED}),
]


def drawn():
    best = pareto.front(ROWS, "contour")
    rows = [replace(one, on_front_of=("contour",)) if one in best else one for one in ROWS]
    (axes,) = time_against_error(rows, "contour", "contour").axes
    return axes


def test_settings_with_the_error_are_named_and_those_on_the_front_are_bold():
    weights = {text.get_text(): text.get_fontweight() for text in drawn().texts}
    assert weights == {"fast": "bold", "stock": "normal", "lucky": "bold"}


def test_points_lie_at_the_error_or_at_the_spread_if_that_is_larger():
    marks = [line for line in drawn().lines if line.get_marker() in ("o", "s")]
    places = sorted((float(line.get_xdata()[0]), float(line.get_ydata()[0])) for line in marks)
    assert places == [(1.0, pytest.approx(8.0)), (20.0, pytest.approx(8.0)), (30.0, 2.0)]
    hollow = [line.get_xdata()[0] for line in marks if line.get_markerfacecolor() == "white"]
    assert hollow == [30.0]


def test_the_front_is_a_staircase_through_its_settings():
    (line,) = (line for line in drawn().lines if line.get_label() == "front")
    assert list(zip(*line.get_data(), strict=True))[:2] == [
        (1.0, pytest.approx(8.0)),
        (30.0, pytest.approx(2.0)),
    ]


def test_names_do_not_cover_each_other():
    rows = [row(f"setting-{i}", 1.0 + 1e-3 * i, 0.05) for i in range(8)]
    # Far away, so that the others are side by side.
    rows.append(row("far", 99.0, 0.05))
    figure = time_against_error(rows, "contour", "contour")
    figure.draw_without_rendering()
    boxes = [text.get_window_extent() for text in figure.axes[0].texts]
    covered = [(i, j) for i in range(9) for j in range(i) if boxes[i].overlaps(boxes[j])]
    assert len(boxes) == 9 and not covered


def test_a_figure_without_points_has_a_note():
    (axes,) = time_against_error(ROWS[:1], "contour", "contour").axes
    assert axes.texts[0].get_text() == "not measured"
