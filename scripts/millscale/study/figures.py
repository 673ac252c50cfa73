"""Time against error of a parameter study: the settings, their names, the front."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.ticker import LogLocator, NullFormatter

from millscale.report.figures.style import STYLE
from millscale.study import pareto
from millscale.study.errors import StudyError
from millscale.study.pareto import SettingRow

# Colour-blind safe (Okabe and Ito).
LOOKS = {
    "millscale": {"marker": "o", "color": "#0072b2"},
    "stock": {"marker": "s", "color": "#d55e00"},
}
FRONT_COLOUR = "#009e73"
# An error below is drawn here: a logarithm has no 0 [%].
LEAST_SHOWN = 0.01
# Of a name, of a letter and of a mark, so that they do not cover each other [points].
LINE_PT, LETTER_PT, MARK_PT = 8.0, 4.0, 4.0


def time_against_error(rows: Sequence[SettingRow], name: str, title: str) -> Figure:
    """Return an error against time, both logarithmic. Hollow: within the spread, and drawn at it;
    bars: error plus and minus spread; dotted: wanted errors.

    Args:
        rows: of `results.study_results`.
        name: of an error, or `pareto.WORST`.
    """
    known = [row for row in rows if row.resolved(name) is not None]
    with rc_context(STYLE):
        figure = Figure(figsize=(7.4, 5.2), layout="constrained")
        axes = figure.add_subplot()
        axes.set(xscale="log", yscale="log", ylabel=f"{title} [%]")
        axes.set_xlabel(f"{_time_is(rows)} of a run [s]")
        if not known:
            axes.text(0.5, 0.5, "not measured", transform=axes.transAxes, ha="center")
            return figure
        for row in known:
            _point(axes, row, row.error(name))
        _front(axes, pareto.front(rows, name), name)
        for share in pareto.WANTED:
            axes.axhline(100.0 * share, ls=":", lw=0.9, color="#666", zorder=0)
        axes.margins(x=0.18)
        heights = [_shown(row, name) for row in known]
        axes.set_ylim(0.4 * min(heights), 3.0 * max(heights))
        axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axes.yaxis.set_major_formatter("{x:g}")
        axes.yaxis.set_minor_formatter(NullFormatter())
        lines = dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
        figure.legend(lines.values(), lines.keys(), loc="outside upper center", ncols=3)
        _names(axes, known, name)
    return figure


def _time_is(rows: Sequence[SettingRow]) -> str:
    return f"{rows[0].time_is} time" if rows else "time"


def _shown(row: SettingRow, name: str) -> float:
    """Return the height of a point [%]."""
    return max(LEAST_SHOWN, 100.0 * row.resolved(name))


def _point(axes: Axes, row: SettingRow, error: StudyError) -> None:
    height = max(LEAST_SHOWN, 100.0 * error.resolved)
    ends = [100.0 * (error.error + sign * (error.spread or 0.0)) for sign in (-1, 1)]
    ends = [max(LEAST_SHOWN, ends[0]), max(height, ends[1])]
    hollow = bool(error.within_spread)
    look = LOOKS[row.engine]
    axes.plot([row.time_s] * 2, ends, lw=0.8, color=look["color"], alpha=0.5)
    words = "contacts or wall of millscale" if row.engine == "millscale" else "stock"
    axes.plot(
        row.time_s, height, ls="none", ms=6.5, mfc="white" if hollow else look["color"],
        label=words + (", within its spread" if hollow else ""), **look,
    )  # fmt: skip


def _front(axes: Axes, best: Sequence[SettingRow], name: str) -> None:
    """Draw the front as a staircase: it keeps the error of a setting up to the next better one."""
    if best:
        points = [(row.time_s, _shown(row, name)) for row in best]
        points.append((axes.get_xlim()[1], points[-1][1]))
        axes.step(
            *zip(*points, strict=True), where="post", color=FRONT_COLOUR, lw=1.4, label="front",
            zorder=1,
        )  # fmt: skip


def _names(axes: Axes, rows: Sequence[SettingRow], name: str) -> None:
    """Write names beside the points; a name that would cover another name or a mark is moved up."""
    axes.figure.draw_without_rendering()
    per_point = axes.figure.dpi / 72.0
    places = {
        row.label: axes.transData.transform((row.time_s, _shown(row, name))) / per_point
        for row in rows
    }
    # Boxes: left, right, middle height, half height.
    taken = [(x - MARK_PT, x + MARK_PT, y, MARK_PT) for x, y in places.values()]
    for row in sorted(rows, key=lambda row: _shown(row, name)):
        x, y = places[row.label]
        left, right = x + 6.0, x + 6.0 + LETTER_PT * len(row.label)
        up = 0.0
        while any(
            left < end and right > start and abs(y + up - middle) < 0.5 * LINE_PT + half
            for start, end, middle, half in taken
        ):
            up += 1.0
        taken.append((left, right, y + up, 0.5 * LINE_PT))
        best = name in row.on_front_of
        axes.annotate(
            row.label, (row.time_s, _shown(row, name)), xytext=(6, up - 2.5),
            textcoords="offset points", fontsize=7.0, fontweight="bold" if best else "normal",
            color="#111" if best or row.is_default else "#555",
            path_effects=[withStroke(linewidth=2.0, foreground="white")],
        )  # fmt: skip
