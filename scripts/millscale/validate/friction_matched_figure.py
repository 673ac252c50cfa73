"""Errors of both policies by observable, a panel for each S."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import median
from typing import Any

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from millscale.report.figures.style import STYLE

# Colour-blind safe (Okabe and Ito); the mark differs as well.
LOOKS: dict[str, dict[str, Any]] = {
    "paper": {"marker": "o", "color": "#0072b2"},
    "matched": {"marker": "s", "color": "#d55e00"},
}
NAMES = {"paper": "paper", "matched": "friction-matched"}
CHANCE = "#999"


def draw_errors(content: Mapping[str, Any], file: Path) -> Figure:
    """Draw the size of each error by both policies; of several mills each faint, their median full.

    Grey bars reach to the chance of an error, in the median over mills.

    Args:
        content: of `friction_matched.compare_policies`.
    """
    rows = [x for x in content["rows"] if len(x["ratios"]) == 1 and x["paper"] and x["matched"]]
    panels = sorted({(x["scheme"], x["ratios"][0]) for x in rows})
    names = list(dict.fromkeys((x["observable"], f"{x['label']} [{x['unit']}]") for x in rows))
    with rc_context(STYLE):
        figure = Figure(figsize=(2.4 + 1.9 * len(panels), 1.2 + 0.32 * len(names)),
                        layout="constrained")  # fmt: skip
        every = figure.subplots(1, len(panels), squeeze=False, sharex=True, sharey=True)[0]
        several_schemes = len({scheme for scheme, _ in panels}) > 1
        for axes, (scheme, S) in zip(every, panels, strict=True):
            some = [x for x in rows if (x["scheme"], x["ratios"][0]) == (scheme, S)]
            _panel(axes, some, [name for name, _ in names])
            title = f"S = {S:.4g}"
            axes.set_title(f"{title}\n{scheme}" if several_schemes else title, fontsize=9.5)
            axes.set_xlabel("error")
        sizes = [abs(x[key]["value"]) for x in rows for key in LOOKS]
        # The panels share their axes; none of the points is outside.
        every[0].set_xlim(0.05, 1.5 * max(sizes, default=1.0))
        every[0].set_yticks(range(len(names)), [label for _, label in names])
        every[0].invert_yaxis()
        handles, labels = every[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=3)
        figure.savefig(file, dpi=150)
    return figure


def _panel(axes: Axes, rows: Sequence[Mapping[str, Any]], names: Sequence[str]) -> None:
    for place, name in enumerate(names):
        found = [row for row in rows if row["observable"] == name]
        if not found:
            continue
        sizes = {key: [abs(row[key]["value"]) for row in found] for key in LOOKS}
        middle = {key: median(values) for key, values in sizes.items()}
        chances = [row["matched"]["chance"] for row in found if row["matched"]["chance"]]
        if chances:
            axes.barh(place, median(chances), height=0.5, color=CHANCE, alpha=0.3, lw=0,
                      label=None if place else "chance (one standard error)")  # fmt: skip
        axes.plot([middle[key] for key in LOOKS], [place] * 2, color="#777", lw=1.0, zorder=2)
        for key, look in LOOKS.items():
            if len(found) > 1:
                axes.plot(sizes[key], [place] * len(found), ls="none", ms=3.5, alpha=0.35, **look)
            axes.plot(middle[key], place, ls="none", ms=6.5, zorder=3,
                      label=None if place else NAMES[key], **look)  # fmt: skip
    axes.set_xscale("log")
    axes.xaxis.set_major_locator(LogLocator(numticks=6))
    axes.xaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.grid(axis="y", visible=False)
