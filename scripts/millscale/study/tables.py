"""Results of a parameter study as tables for a terminal."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rich.markup import escape
from rich.table import Table

from millscale.formats import NONE, duration, hundredths
from millscale.study import pareto
from millscale.study.errors import StudyError
from millscale.study.pareto import AgainstStock, Recommendation, SettingRow
from millscale.study.results import StudyResults


def tables(results: StudyResults) -> Iterator[Table | str]:
    """Yield settings by time, the setting for each wanted error, default against stock."""
    known = pareto.known_errors(results.rows)
    yield _settings(results.rows, known)
    yield _recommended(results.recommendations, known)
    yield from (escape(_against_stock(row)) for row in results.time_to_solution)
    for name, why in results.missing.items():
        yield escape(f"missing: {name}: {why}")


def _settings(rows: Sequence[SettingRow], known: Sequence[str]) -> Table:
    table = _table("Errors in %, ± what chance does to the means; ~: within that; *: on the front")
    table.add_column("setting", no_wrap=True)
    for name in ("seeds", f"{rows[0].time_is} time", *known, "largest"):
        table.add_column(name.replace("_", " "), justify="right")
    for row in sorted(rows, key=lambda row: row.time_s):
        errors = [_error(row.error(x), x in row.on_front_of) for x in (*known, pareto.WORST)]
        table.add_row(escape(row.label + row.role), str(row.seeds), duration(row.time_s), *errors)
    return table


def _error(error: StudyError | None, on_front: bool) -> str:
    if error is None or error.error is None:
        return NONE
    text = f"{'~' * bool(error.within_spread)}{hundredths(error.error)}"
    if error.spread is not None:
        text += f" ± {hundredths(error.spread)}"
    return text + "*" * on_front


def _recommended(recommended: Sequence[Recommendation], known: Sequence[str]) -> Table:
    table = _table("The cheapest setting whose error plus spread is no more than wanted")
    table.add_column("error", no_wrap=True)
    for share in pareto.WANTED:
        table.add_column(f"{share:.0%}")
    for name in (*known, pareto.WORST):
        cells = [_choice(x) for x in recommended if x.error == name]
        table.add_row("all" if name == pareto.WORST else name.replace("_", " "), *cells)
    return table


def _choice(found: Recommendation) -> str:
    if found.setting:
        return escape(f"{found.setting}, {duration(found.time_s)}")
    if not found.nearest:
        return "none"
    return escape(f"none; nearest {found.nearest}: {hundredths(found.nearest_bound)} %")


def _against_stock(row: AgainstStock) -> str:
    what = "all errors" if row.error == pareto.WORST else row.error.replace("_", " ")
    if row.ratio is None:
        return (
            f"{what}: no stock setting is as good as {row.default}; the best, "
            f"{row.best_stock}, takes {row.at_least:.1f} times as long"
        )
    spread = f" ± {row.ratio_spread:.1f}" if row.ratio_spread is not None else ""
    return (
        f"{what}: stock as good as {row.default} is {row.stock}, "
        f"{row.ratio:.1f}{spread} times as long"
    )


def _table(title: str) -> Table:
    return Table(title=title, title_justify="left", box=None, pad_edge=False)
