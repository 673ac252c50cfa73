"""Mixing in scaled mills: `millscale validate mixing`.

A row is one multi-ball case with one size of sample cells. Rows that differ only in their seed give
a mean. Lines through the rows of one scheme and policy give the change of the index with S.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import colormaps, rc_context
from matplotlib.figure import Figure

from millscale.analysis.finished import Charge
from millscale.analysis.finished_campaign import load_campaign
from millscale.analysis.means import deviation, mean_known
from millscale.analysis.shapes.mixing import mixing
from millscale.engine.record import provenance
from millscale.formats import number
from millscale.report.figures.style import STYLE
from millscale.runs.untrusted import RunFolderError
from millscale.runs.writing import write_json

Row = dict[str, Any]
COMMAND = "millscale validate mixing DIR... --to JSON"
# Of the sample cells, over R - a.
SIDES = (0.025, 0.05, 0.1, 0.2)
# Revolutions over which the index is averaged: it also changes with the circulation of the bed. A
# rotation of 12 rad has 1.909.
SPANS = {
    f"{begin:g} to {end:g}": (begin, end) for begin, end in ((0, 1), (0.9, 1.9), (3, 4), (5, 6))
}
SHOWN_SPAN = "0.9 to 1.9"
LEVELS = {"1 - 1/e": 1.0 - math.exp(-1.0), "0.9": 0.9}
MILL = ("campaign", "scheme", "policy", "stiffness", "S")
SERIES = MILL[:-1]


def rows_of(charges: Iterable[Charge]) -> Iterator[Row]:
    """Yield a row for each charge and side of the cells."""
    for charge in charges:
        for found in mixing(charge.folder, charge.case, SIDES):
            yield {
                **{key: getattr(charge, key) for key in (*MILL, "seed", "balls")},
                "side": found.side,
                "balls_per_cell": found.balls_per_cell,
                "means": {name: found.mean(*span) for name, span in SPANS.items()},
                "revolutions_to": {name: found.time_to(x) for name, x in LEVELS.items()},
                "revolutions": [round(x, 4) for x in found.revolutions.tolist()],
                "index": [round(x, 5) for x in found.index.tolist()],
            }


def of_seeds(rows: Sequence[Row]) -> list[Row]:
    """Return mean and standard deviation (n - 1) over the seeds of each mill and side."""
    return [
        {
            **dict(zip((*MILL, "side"), mill, strict=True)),
            "seeds": len(seeds),
            "balls_per_cell": mean_known(row["balls_per_cell"] for row in seeds),
            **{
                name: {
                    key: _mean_and_deviation([row[name][key] for row in seeds])
                    for key in seeds[0][name]
                }
                for name in ("means", "revolutions_to")
            },
        }
        for mill, seeds in _grouped(rows, (*MILL, "side"))
    ]


def _grouped(rows: Sequence[Row], keys: Sequence[str]) -> Iterator[tuple[tuple, list[Row]]]:
    def key(row: Row) -> tuple:
        return tuple(row[name] for name in keys)

    for name, group in groupby(sorted(rows, key=key), key=key):
        yield name, list(group)


def _mean_and_deviation(values: Sequence[float | None]) -> Row:
    """Return mean and deviation of values; None if one is unknown."""
    known = [value for value in values if value is not None]
    if len(known) < len(values):
        return {"mean": None, "deviation": None}
    return {"mean": mean_known(known), "deviation": deviation(known)}


@dataclass(frozen=True)
class Line:
    """Least-squares line of an index against S, through single runs.

    Attributes:
        at_1, at_1_error: the index at S = 1 and its standard error.
        slope, slope_error: change with S and its standard error.
    """

    at_1: float
    at_1_error: float
    slope: float
    slope_error: float


def line_in_S(S: np.ndarray, index: np.ndarray) -> Line | None:
    """Return the line through (n,) indices against S; None for fewer than 3 runs or one S.

    Standard errors take the scatter about the line as that of the runs.
    """
    n = len(S)
    if n < 3 or np.ptp(S) == 0.0:
        return None
    away, back = S - S.mean(), 1.0 - S.mean()
    spread = float(away @ away)
    slope = float(away @ index) / spread
    left = index - index.mean() - slope * away
    scatter = math.sqrt(float(left @ left) / (n - 2))
    return Line(
        at_1=float(index.mean()) + slope * back,
        at_1_error=scatter * math.sqrt(1.0 / n + back * back / spread),
        slope=slope,
        slope_error=scatter / math.sqrt(spread),
    )


def lines_of(rows: Sequence[Row]) -> list[Row]:
    """Return the line through the scaled mills of each scheme, policy, stiffness, side and span of
    revolutions, over all campaigns, beside the mean of the physical mill."""
    found = []
    for span in SPANS:
        known = [row for row in rows if row["means"].get(span) is not None]
        physical = [row for row in known if row["S"] == 1.0]
        scaled = [row for row in known if row["S"] != 1.0]
        for (*mill, side), runs in _grouped(scaled, ("scheme", "policy", "stiffness", "side")):
            S = np.array([row["S"] for row in runs])
            line = line_in_S(S, np.array([row["means"][span] for row in runs]))
            if line is None:
                continue
            same = [row["means"][span] for row in physical if row["side"] == side]
            found.append(
                {
                    **dict(zip(("scheme", "policy", "stiffness"), mill, strict=True)),
                    **{"side": side, "span": span, "S": sorted(set(S.tolist()))},
                    **{"runs": len(runs), **vars(line), "physical": mean_known(same)},
                }
            )
    return found


def tables(document: Row) -> str:
    """Return the mills and the lines as Markdown tables."""
    lines = [
        "| campaign | scheme | policy | E | S | seeds | side | balls per cell "
        f"| {' | '.join(f'M, {span}' for span in SPANS)} | revolutions to 1 - 1/e |",
        "|---" * (8 + len(SPANS) + 1) + "|",
    ]
    lines += [
        f"| {row['campaign']} | {row['scheme']} | {row['policy']} | {row['stiffness']} "
        f"| {row['S']:g} | {row['seeds']} | {row['side']:g} | {row['balls_per_cell']:.0f} "
        + "".join(f"| {_text(row['means'][span])} " for span in SPANS)
        + f"| {_text(row['revolutions_to']['1 - 1/e'], 2)} |"
        for row in document["mills"]
    ]
    lines += [
        "",
        "| scheme | policy | E | side | revolutions | S | runs | slope in S "
        "| M at S = 1 by the line "
        "| of S = 1 |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    lines += [
        f"| {row['scheme']} | {row['policy']} | {row['stiffness']} | {row['side']:g} "
        f"| {row['span']} | {', '.join(f'{S:g}' for S in row['S'])} | {row['runs']} "
        f"| {row['slope']:+.4f} ± {row['slope_error']:.4f} "
        f"| {row['at_1']:.3f} ± {row['at_1_error']:.3f} | {number(row['physical'])} |"
        for row in document["lines"]
    ]
    return "\n".join(lines)


def _text(of_mill: Row, digits: int = 3) -> str:
    mean, scatter = of_mill["mean"], of_mill["deviation"]
    shown = number(mean, digits)
    return shown if scatter is None else f"{shown} ± {number(scatter, digits)}"


def draw(document: Row, file: Path) -> Figure:
    """Draw the index against revolutions, and against S at the revolutions that most runs have.

    Args:
        file: picture to write.
    """
    ratios = sorted({row["S"] for row in document["rows"]})
    colour = dict(
        zip(ratios, colormaps["viridis"](np.linspace(0.0, 0.85, len(ratios))), strict=True)
    )
    with rc_context(STYLE):
        figure = Figure(figsize=(9.5, 4.2), layout="constrained")
        left, right = figure.subplots(1, 2)
        for (S, *_), group in _grouped(document["rows"], ("S", *SERIES, "side")):
            if group[0]["side"] not in (0.05, 0.2):
                continue
            style = "-" if group[0]["side"] == 0.05 else "--"
            at = group[0]["revolutions"]
            mean = np.mean([np.interp(at, row["revolutions"], row["index"]) for row in group], 0)
            left.plot(at, mean, style, color=colour[S], linewidth=1.0)
        for S in ratios:
            left.plot([], [], color=colour[S], label=f"S = {S:g}")
        left.plot([], [], "--", color="#555", label="cells of 0.2, else 0.05")
        left.axhline(LEVELS["1 - 1/e"], color="#999", linewidth=0.8)
        left.set(xlabel="revolutions of the mill", ylabel="mixing index", ylim=(0.0, 1.0))
        left.legend()
        markers = "osD^vP*X"
        series = [name for name, _ in _grouped(document["mills"], SERIES)]
        for (*name, side), group in _grouped(document["mills"], (*SERIES, "side")):
            known = [row for row in group if row["means"][SHOWN_SPAN]["mean"] is not None]
            right.errorbar(
                [row["S"] for row in known],
                [row["means"][SHOWN_SPAN]["mean"] for row in known],
                [row["means"][SHOWN_SPAN]["deviation"] or 0.0 for row in known],
                fmt=markers[series.index(tuple(name)) % len(markers)],
                color=colormaps["plasma"](SIDES.index(side) / len(SIDES)),
                markersize=4,
                capsize=2,
            )
        for side in SIDES:
            right.plot([], [], color=colormaps["plasma"](SIDES.index(side) / len(SIDES)),
                       label=f"cells of {side:g} (R - a)")  # fmt: skip
        for i, (campaign, scheme, policy, stiffness) in enumerate(series):
            label = ", ".join((campaign, scheme, policy, f"E {stiffness}"))
            right.plot([], [], markers[i % len(markers)], color="#555", markersize=4, label=label)
        right.set(xlabel="S", ylabel=f"mixing index, {SHOWN_SPAN} revolutions", ylim=(0.0, None))
        figure.legend(*right.get_legend_handles_labels(), loc="outside lower center", ncols=2)
        figure.savefig(file, dpi=150)
    return figure


def write_mixing(runs: Sequence[Path], file: Path) -> str:
    """Write mixing.json and a figure beside it; return its tables.

    Args:
        runs: runs folders of finished campaigns.

    Raises:
        RunFolderError: a folder holds no finished multi-ball case or another physical mill, or
            dumps are missing.
    """
    charges: list[Charge] = []
    for folder in runs:
        found = load_campaign(folder).charges
        if not found:
            raise RunFolderError(folder, "no finished multi-ball case", "run its campaign first")
        charges += found
    for charge in charges:
        if charge.case.physical != charges[0].case.physical:
            cause = f"its physical mill is not that of {charges[0].folder}"
            raise RunFolderError(charge.folder, cause, "give campaigns of one physical mill")
    rows = list(rows_of(charges))
    record = provenance() | {"command": COMMAND}
    document = {"schema": 1, **record, "mills": of_seeds(rows), "lines": lines_of(rows)}
    document["rows"] = rows
    file.parent.mkdir(parents=True, exist_ok=True)
    write_json(file, document)
    draw(document, file.with_suffix(".png"))
    return tables(document)
