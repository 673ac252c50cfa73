"""Print the tables of the paper's mills in reproduction.md, from paper-multi-ball.json.

Run it as `python docs/results/paper_mills.py`.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from pathlib import Path
from statistics import mean, stdev
from typing import Any

FILE = Path(__file__).parent / "paper-multi-ball.json"
TABLE_10, EQUAL_FILLING = "paper-multi-ball", "multi-ball-equal-filling"

Row = dict[str, Any]
# Heading, number of a row, decimals.
Column = tuple[str, Callable[[Row], float | None], int]


def _over_angles(name: str, factor: float = 1.0) -> Callable[[Row], float | None]:
    def value(row: Row) -> float | None:
        means = row["mean_over_angles"]
        return None if means is None else factor * means[name]

    return value


def _of(name: str, factor: float = 1.0) -> Callable[[Row], float | None]:
    return lambda row: None if row.get(name) is None else factor * row[name]


ERRORS: list[Column] = [
    ("contour, mean", _over_angles("contour_error_mean", 100.0), 2),
    ("contour, largest", _over_angles("contour_error_max", 100.0), 1),
    ("upper ends", _over_angles("curtain_iou_upper"), 2),
    ("lower ends", _over_angles("curtain_iou_lower"), 2),
    ("flow, RMS", _of("massflow_rms", 100.0), 3),
    ("flow, correlation", _of("massflow_correlation"), 3),
    ("power / M g R omega", _of("power_dimensionless"), 4),
    ("power [%]", _of("power_error", 100.0), 2),
]


def mills(rows: Iterable[Row], campaign: str) -> list[list[Row]]:
    """Return the rows of a campaign by mill, the seeds of one together; S increases."""
    found: dict[tuple[str, float], list[Row]] = {}
    for row in rows:
        if row["campaign"] == campaign:
            found.setdefault((row["scheme"], row["S"]), []).append(row)
    return [found[key] for key in sorted(found)]


def short(value: float, digits: int) -> str:
    """Return a number with fixed decimals; one below 1 begins with its point, and 0 has no sign."""
    rounded = round(value, digits) + 0.0
    return f"{rounded:.{digits}f}".replace("0.", ".", 1 if abs(rounded) < 1.0 else 0)


def with_spread(values: Iterable[float | None], digits: int) -> str:
    """Return the mean of some numbers, with a standard deviation of several that is not 0."""
    known = [x for x in values if x is not None]
    if not known:
        return ""
    spread = round(stdev(known), digits) if len(known) > 1 else 0.0
    return short(mean(known), digits) + (f" ± {short(spread, digits)}" if spread else "")


def between_seeds(mill: list[Row], column: Column) -> str:
    """Return the error between two seeds of a mill in brackets; empty if none was compared."""
    _, value, digits = column
    found = mill[0].get("between_seeds")
    number = value(found) if found and not mill[0]["is_reference"] else None
    return "" if number is None else f" ({short(number, digits)})"


def ladder(document: Row, campaign: str) -> list[str]:
    """Return the errors of each scaled mill against the physical one, in Markdown."""
    whole = next(row["balls"] for row in document["rows"] if row["S"] == 1.0)
    names = ["scheme", "S", "balls", "of N / S^3", "processor time [s]", "speed-up"]
    names += [name for name, _, _ in ERRORS]
    lines = ["| " + " | ".join(names) + " |", "|---" * len(names) + "|"]
    for mill in mills(document["rows"], campaign):
        first = mill[0]
        cells = [
            first["scheme"].replace("-", " "),
            f"{first['S']:.4g}",
            f"{first['balls']:,}",
            f"{100.0 * (first['balls'] * first['S'] ** 3 / whole - 1.0):+.1f} %".replace(
                "-0.0", "+0.0"
            ),
            f"{mean(x['processor_time_s'] for x in mill):,.0f}",
            f"{mean(x['speed_up'] for x in mill):.3g}",
        ]
        cells += [
            with_spread((column[1](x) for x in mill), column[2]) + between_seeds(mill, column)
            for column in ERRORS
        ]
        lines.append("| " + " | ".join(cells) + " |")
    return lines


def beds(document: Row) -> list[str]:
    """Return the settled beds of the mills at constant gravity, in Markdown."""
    found = [x[0] for x in mills(document["rows"], TABLE_10) if x[0]["scheme"] != "constant-speed"]
    rows = {
        "S": [f"{x['S']:.4g}" for x in found],
        "mass [kg]": [f"{x['total_mass_kg']:,.0f}" for x in found],
        "bulk fraction of the settled bed": [
            f"{x['settled']['bulk_fraction']:.3f}".lstrip("0") for x in found
        ],
        "largest overlap of the settled bed / a": [
            f"{x['settled']['largest_overlap_over_radius']:.2f}".lstrip("0") for x in found
        ],
        "largest overlap in the turning mill / a": [
            f"{x['max_overlap']:.2f}".lstrip("0") for x in found
        ],
    }
    lines = ["| " + " | ".join([name, *cells]) + " |" for name, cells in rows.items()]
    return [lines[0], "|---" * (1 + len(found)) + "|", *lines[1:]]


def tables(document: Row) -> list[list[str]]:
    """Return all tables, lines of Markdown."""
    return [ladder(document, TABLE_10), ladder(document, EQUAL_FILLING), beds(document)]


if __name__ == "__main__":
    content = json.loads(FILE.read_text(encoding="utf-8"))
    print("\n\n".join("\n".join(table) for table in tables(content)))
