"""A calibration as tables and lines for the terminal."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from rich.markup import escape
from rich.table import Table

from millscale.calibration.result import RESULT, Result, TargetRow
from millscale.formats import NONE, number
from millscale.report.build import INDEX, REPORT


def campaign_name(experiment: str) -> str:
    """Return the name of the calibrated campaign of an experiment."""
    return f"calibrated-{experiment}.toml" if experiment else "calibrated.toml"


def parameter_table(result: Result) -> Table:
    """Return the parameters with their intervals, and what each target contributes."""
    found = result.inference
    table = Table(
        title=f"Parameters, {100.0 * found.level:g} % intervals; widths in % of the range",
        title_justify="left",
    )
    table.add_column("parameter")
    for name in ("value", "from", "to", "width"):
        table.add_column(name, justify="right")
    for target in result.calibration.targets:
        table.add_column(escape(f"{target.name}: alone / without"), justify="right")
    for j, one in enumerate(found.found):
        shares = [
            f"{100.0 * part.alone[j]:.0f} / {100.0 * part.without[j]:.0f}"
            for part in result.contributions.values()
        ]
        ends = (f"{one.best:.4g}", f"{one.lower:.4g}", f"{one.upper:.4g}")
        table.add_row(escape(one.name), *ends, f"{100.0 * one.width:.0f}", *shares)
    return table


def target_table(result: Result) -> Table:
    """Return the targets beside the run with the best values."""
    table = Table(title="Targets at the best values", title_justify="left")
    table.add_column("target")
    for name in ("measured", "uncertainty", "simulated", "difference / uncertainty", "surrogate"):
        table.add_column(name, justify="right")
    for row in result.rows():
        table.add_row(*map(escape, target_cells(row)))
    return table


def target_cells(row: TargetRow) -> tuple[str, ...]:
    """Return a target as text: name, measured, uncertainty, simulated, differences of the run and
    of the surrogate over the uncertainty."""
    target = row.target
    profile = target.abscissa is not None
    unit = f" {target.unit}" if target.unit else ""
    measured = f"{len(target.measured)} points" if profile else target.text(target.measured[0])
    sign = "" if profile else "+"
    return (
        target.name,
        measured if profile else measured + unit,
        target.text(target.uncertainty) + unit,
        NONE if row.simulated is None else target.text(row.simulated) + unit,
        NONE if row.run is None else f"{row.run:{sign}.2f}",
        f"{row.inferred:{sign}.2f} +- {row.surrogate:.2f}",
    )


def lines(result: Result, runs: Path) -> Iterator[str]:
    """Yield what stands below the tables."""
    found = result.inference
    for i, one in enumerate(found.parameters):
        for j in range(i):
            r = number(float(found.correlation[i, j]), 2)
            yield f"correlation of {found.parameters[j].name} and {one.name}: {r}"
    used = f"{found.runs} of {len(result.samples)} samples, {len(result.history)} rounds"
    yield f"{'converged' if result.is_converged else 'not converged'}: {used}"
    yield from (f"warning: {text}" for text in result.warnings())
    files = ", ".join(str(runs / campaign_name(name)) for name in result.campaigns)
    yield f"campaign: {files}; numbers: {runs / RESULT}"
    yield f"page: {runs / REPORT / INDEX}"
