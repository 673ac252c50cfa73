"""Time against error: the front, the setting to take for a wanted error, ours against stock.

An error below its spread is not known to be smaller than the spread, so `resolved` counts it as
the spread: among settings that chance does not tell apart, time alone decides, and none is on the
front by luck.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from millscale.study.errors import ERRORS

Row = dict[str, Any]
WORST = "worst"
WANTED = (0.01, 0.03, 0.10)


def known_errors(rows: Sequence[Row]) -> list[str]:
    """Those of ERRORS that any row tells: a plain drum has no curtains."""
    return [e for e in ERRORS if any(row["errors"][e]["error"] is not None for row in rows)]


def worst_of(errors: Mapping[str, Row], known: Sequence[str]) -> Row | None:
    """The error whose `resolved` is largest, with its name as `of`; None if one is missing."""
    values = {name: resolved(errors[name]) for name in known}
    if not values or None in values.values():
        return None
    name = max(values, key=values.__getitem__)
    return {"of": name, **errors[name]}


def resolved(error: Row | None) -> float | None:
    """The error, or its spread if that is larger; None if the error is not known."""
    if error is None or error["error"] is None or not math.isfinite(error["error"]):
        return None
    return max(error["error"], error["spread"] or 0.0)


def bound(error: Row | None) -> float | None:
    """Error plus spread: what is claimed for a recommendation; None if the error is not known.
    Without a spread the error still holds all of chance, so it stands for both."""
    if resolved(error) is None:
        return None
    return error["error"] + (error["spread"] or 0.0)


def error_of(row: Row, name: str) -> Row | None:
    """An error of a row, or its worst."""
    return row[WORST] if name == WORST else row["errors"][name]


def front(rows: Sequence[Row], name: str) -> list[Row]:
    """The rows that no other beats in both time and resolved error, by time. Rows equal in both
    are on it together; references and rows that do not know the error are not."""
    points = [(row, row["time_s"], resolved(error_of(row, name))) for row in rows]
    points = [point for point in points if point[2] is not None and not point[0]["is_reference"]]
    best = [
        row
        for row, time, error in points
        if not any(t <= time and e <= error and (t, e) != (time, error) for _, t, e in points)
    ]
    return sorted(best, key=lambda row: row["time_s"])


def recommendations(rows: Sequence[Row], wanted: Sequence[float] = WANTED) -> list[Row]:
    """For each wanted error, of each kind and of all at once (`worst`): the cheapest setting whose
    error plus spread is no more; setting None if there is none, then with what comes nearest."""
    known = known_errors(rows)
    result = []
    for share in wanted:
        for name in (*known, WORST):
            bounds = [(row, _bound_in(row, name, known)) for row in rows]
            told = [(row, b) for row, b in bounds if b is not None and not row["is_reference"]]
            good = [row for row, b in told if b <= share]
            best = min(good, key=lambda row: row["time_s"], default=None)
            nearest = min(told, key=lambda point: point[1], default=None)
            result.append(
                {
                    "wanted": share,
                    "error": name,
                    "setting": best["label"] if best else None,
                    "time_s": best["time_s"] if best else None,
                    "bound": _bound_in(best, name, known) if best else None,
                    "nearest": None if best or not nearest else nearest[0]["label"],
                    "nearest_bound": None if best or not nearest else nearest[1],
                }
            )
    return result


def _bound_in(row: Row, name: str, known: Sequence[str]) -> float | None:
    """`bound` of an error; of the worst the largest of all that are known."""
    if name != WORST:
        return bound(error_of(row, name))
    bounds = [bound(row["errors"][kind]) for kind in known]
    return None if not bounds or None in bounds else max(bounds)


def time_to_solution(rows: Sequence[Row]) -> list[Row]:
    """For each default row and each error: the cheapest stock setting whose error is no larger than
    the resolved one of the default, and how many times longer it takes; for the worst no error may
    be larger. What chance may have added to a stock setting's error is not held against it.

    If no stock setting is as good, `stock` is None, and `at_least` the time of the best one, which
    is not good enough, over ours.
    """
    known = known_errors(rows)
    stock = [row for row in rows if row["engine"] == "stock" and not row["is_reference"]]
    stock = [row for row in stock if row[WORST] is not None]
    result = []
    for ours in (row for row in rows if row["is_default"] and row[WORST] is not None and stock):
        result += [_against_stock(ours, [name], name, stock) for name in known]
        result.append(_against_stock(ours, known, WORST, stock))
    return result


def _against_stock(ours: Row, kinds: Sequence[str], name: str, stock: Sequence[Row]) -> Row:
    """Ours against stock in some kinds of error, told under a name."""
    own = {kind: resolved(ours["errors"][kind]) for kind in kinds}

    def excess(row: Row) -> float:
        """Largest error over that of the default; what both have none of is equal."""
        errors = [(row["errors"][kind]["error"], own[kind]) for kind in kinds]
        return max(e / o if o > 0.0 else (math.inf if e > 0.0 else 1.0) for e, o in errors)

    good = [row for row in stock if excess(row) <= 1.0]
    best = min(good, key=lambda row: row["time_s"], default=None)
    nearest = min(stock, key=lambda row: (excess(row), row["time_s"]))
    return {
        "error": name,
        "default": ours["label"],
        "default_time_s": ours["time_s"],
        "default_error": max(own.values()),
        "stock": best["label"] if best else None,
        "stock_time_s": best["time_s"] if best else None,
        "stock_error": _largest(best, kinds) if best else None,
        "ratio": best["time_s"] / ours["time_s"] if best else None,
        "ratio_spread": _ratio_spread(best, ours) if best else None,
        "best_stock": nearest["label"],
        "best_stock_error": _largest(nearest, kinds),
        "at_least": None if best else nearest["time_s"] / ours["time_s"],
    }


def _largest(row: Row, kinds: Sequence[str]) -> float:
    return max(row["errors"][kind]["error"] for kind in kinds)


def _ratio_spread(one: Row, other: Row) -> float | None:
    """Standard deviation of a ratio of times, from those over the seeds."""
    if one["time_spread_s"] is None or other["time_spread_s"] is None:
        return None
    relative = math.hypot(*(row["time_spread_s"] / row["time_s"] for row in (one, other)))
    return one["time_s"] / other["time_s"] * relative
