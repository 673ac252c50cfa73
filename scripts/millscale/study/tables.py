"""What a study found, for a terminal."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from rich.markup import escape
from rich.table import Table

from millscale.formats import duration
from millscale.study import pareto

Row = dict[str, Any]


def tables(results: Row) -> Iterator[Table | str]:
    """Settings by time, what to take for a wanted error, ours against stock."""
    known = pareto.known_errors(results["rows"])
    yield _settings(results["rows"], known)
    yield _recommended(results["recommendations"], known)
    yield from (escape(_against_stock(row)) for row in results["time_to_solution"])
    for name, why in results["missing"].items():
        yield escape(f"not in it: {name}: {why}")


def _settings(rows: list[Row], known: list[str]) -> Table:
    table = _table("Errors in %, ± what chance does to the means; ~: within that; *: on the front")
    table.add_column("setting", no_wrap=True)
    for name in ("seeds", f"{rows[0]['time_is']} time", *known, "largest"):
        table.add_column(name.replace("_", " "), justify="right")
    for row in sorted(rows, key=lambda row: row["time_s"]):
        role = " (reference)" * row["is_reference"] + " (default)" * row["is_default"]
        errors = [
            _error(pareto.error_of(row, name), name in row["on_front_of"])
            for name in (*known, pareto.WORST)
        ]
        label = escape(row["label"] + role)
        table.add_row(label, str(row["seeds"]), duration(row["time_s"]), *errors)
    return table


def _error(error: Row | None, on_front: bool) -> str:
    if error is None or error["error"] is None:
        return "–"
    text = f"{'~' * bool(error['within_spread'])}{100.0 * error['error']:.2f}"
    if error["spread"] is not None:
        text += f" ± {100.0 * error['spread']:.2f}"
    return text + "*" * on_front


def _recommended(recommended: list[Row], known: list[str]) -> Table:
    table = _table("The cheapest setting whose error plus spread is no more than wanted")
    table.add_column("error", no_wrap=True)
    for share in pareto.WANTED:
        table.add_column(f"{share:.0%}")
    for name in (*known, pareto.WORST):
        cells = [_choice(row) for row in recommended if row["error"] == name]
        table.add_row("all" if name == pareto.WORST else name.replace("_", " "), *cells)
    return table


def _choice(row: Row) -> str:
    if row["setting"]:
        return escape(f"{row['setting']}, {duration(row['time_s'])}")
    if not row["nearest"]:
        return "none"
    return escape(f"none; nearest {row['nearest']}: {100.0 * row['nearest_bound']:.2f} %")


def _against_stock(row: Row) -> str:
    what = "all errors" if row["error"] == pareto.WORST else row["error"].replace("_", " ")
    if row["ratio"] is None:
        return (
            f"{what}: no stock setting is as good as {row['default']}; the best, "
            f"{row['best_stock']}, takes {row['at_least']:.1f} times as long"
        )
    spread = f" ± {row['ratio_spread']:.1f}" if row["ratio_spread"] is not None else ""
    return (
        f"{what}: stock as good as {row['default']} is {row['stock']}, "
        f"{row['ratio']:.1f}{spread} times as long"
    )


def _table(title: str) -> Table:
    return Table(title=title, title_justify="left", box=None, pad_edge=False)
