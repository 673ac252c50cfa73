"""A prediction as a table and lines for the terminal."""

from __future__ import annotations

from collections.abc import Iterator

from rich.table import Table

from millscale.formats import NONE, number
from millscale.prediction.predict import PredictedNumber, Prediction


def prediction_table(prediction: Prediction) -> Table:
    """Return a row for each observable of the physical mill, in its unit."""
    mill = prediction.mill
    checked = any(row.check is not None for row in prediction.numbers)
    table = Table(
        title=f"Physical mill: radius {mill.radius:g} m, length {mill.length:g} m, "
        f"{mill.balls:,.0f} balls, {1e-3 * mill.mass:.3g} t",
        title_justify="left",
    )
    level = next((x.found.level for x in prediction.numbers if x.found), 0.95)
    table.add_column("observable")
    for heading in ("unit", "predicted", f"{100 * level:g} % interval", "half width"):
        table.add_column(heading, justify="right")
    ratios = sorted({value.S for row in prediction.numbers for value in row.measured})
    for S in ratios:
        table.add_column(f"S = {S:.4g}", justify="right")
    if checked:
        table.add_column("S = 1, left out", justify="right")
        table.add_column("inside")
    for row in prediction.numbers:
        table.add_row(*_cells(row, ratios, checked))
    return table


def prediction_lines(prediction: Prediction) -> Iterator[str]:
    """Yield what stands below the table: refusals, runs, warnings."""
    for row in prediction.numbers:
        if row.refused:
            yield f"not predicted: {row.observable.label}: {row.refused}"
    weights = next((row.found.weights for row in prediction.numbers if row.found), None)
    by_ratio: dict[str, int] = {}
    for charge in prediction.runs:
        by_ratio[f"{charge.S:.4g}"] = by_ratio.get(f"{charge.S:.4g}", 0) + 1
    used = ", ".join(f"S = {S}: {count}" for S, count in by_ratio.items())
    shown = f"; weights {', '.join(f'{w:+.2f}' for w in weights)}" if weights else ""
    yield f"runs by {prediction.scheme}, {prediction.policy}: {used}{shown}"
    if any(row.noise_from == "lifter pitches" for row in prediction.numbers):
        yield "noise from the scatter of lifter pitches: too few seeds to measure it"
    for name, why in prediction.excluded.items():
        yield f"not used: {name}: {why}"
    for warning in prediction.warnings:
        yield f"warning: {warning}"


def _cells(row: PredictedNumber, ratios: list[float], checked: bool) -> list[str]:
    digits = row.observable.digits
    measured = {value.S: number(value.mean, digits) for value in row.measured}
    cells = [row.observable.label, row.observable.unit]
    if row.interval is None or row.value is None:
        cells += [NONE] * 3
    else:
        lower, upper = row.interval
        cells += [number(row.value, digits), f"{number(lower, digits)} to {number(upper, digits)}"]
        cells.append(number(0.5 * (upper - lower), digits))
    cells += [measured.get(S, NONE) for S in ratios]
    if checked:
        inside = {True: "yes", False: "no", None: NONE}[row.is_inside]
        cells += [number(row.check, digits), inside]
    return cells
