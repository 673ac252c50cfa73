"""A prediction, and an advice, as a table and lines for the terminal."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from rich.table import Table

from millscale.formats import NONE, number
from millscale.prediction.advise import Advice
from millscale.prediction.result import PredictedNumber, Prediction

YES_NO = {True: "yes", False: "no", None: NONE}


def prediction_table(prediction: Prediction) -> Table:
    """Return a row for each observable of the physical mill, in its unit."""
    checked = any(row.check is not None for row in prediction.numbers)
    table = Table(title=prediction.title, title_justify="left")
    table.add_column("observable")
    for heading in ("unit", "predicted", f"{100 * prediction.level:g} % interval", "half width"):
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


def checks_table(prediction: Prediction) -> Table:
    """Return what each interval rests on: noise, exponent, residuals, order in S."""
    checked = any(row.check is not None for row in prediction.numbers)
    table = Table(title="Checks", title_justify="left")
    for heading in ("observable", "noise of a run", "from"):
        table.add_column(heading)
    for heading in ("weights", "p before", "p after", *(("p of S = 1",) if checked else ())):
        table.add_column(heading, justify="right")
    table.add_column("residuals")
    table.add_column("order in S")
    for row in prediction.numbers:
        if row.found is None or row.noise is None or row.observable.restates:
            continue
        found, prior = row.found, row.observable.kind.prior
        probability = found.residual_probability
        table.add_row(
            row.observable.label,
            f"{row.scale * row.noise.deviation:.2g} {row.observable.unit}",
            row.noise_from,
            ", ".join(f"{weight:+.2f}" for weight in found.weights),
            f"{prior.lower:g} to {prior.upper:g}",
            f"{found.exponent:.2f} +- {found.exponent_deviation:.2f}",
            *((number(row.exact_exponent, 2),) if checked else ()),
            "none left" if probability is None else f"probability {probability:.2g}",
            "not monotonic" if row.reverses else "monotonic",
        )
    return table


def impact_tables(prediction: Prediction) -> Iterator[Table]:
    """Yield a table for each pairing: impacts per second in the whole mill by decade of energy."""
    for spectrum in prediction.spectra:
        ratios = sorted({S for decade in spectrum.decades for S in decade.measured})
        checked = any(decade.check is not None for decade in spectrum.decades)
        title = f"Impacts per second, {spectrum.pairing.replace('_', '-')}"
        table = Table(title=title, title_justify="left")
        headings = ["energy [J]", "predicted", f"{100 * prediction.level:g} % interval"]
        headings += [f"S = {S:.4g}" for S in ratios]
        headings += ["S = 1, left out", "inside"] if checked else []
        for heading in headings:
            table.add_column(heading, justify="right")
        for x in spectrum.decades:
            cells = [f"{x.low_J:.2g} to {x.high_J:.2g}", f"{x.rate:.3g}"]
            cells += [f"{x.lower:.3g} to {x.upper:.3g}"]
            cells += [f"{x.measured[S]:.3g}" for S in ratios]
            if checked:
                cells += [NONE if x.check is None else f"{x.check:.3g}", YES_NO[x.is_inside]]
            table.add_row(*cells)
        yield table


def advice_table(advice: Advice) -> Table:
    """Return a row for the chosen design, then one for the best of each kind."""
    table = Table(title=advice.title, title_justify="left")
    for i, heading in enumerate(advice.headings):
        left = i < 2
        table.add_column(heading, justify="left" if left else "right", no_wrap=left)
    for row in advice.rows():
        table.add_row(*row)
    return table


def advice_lines(advice: Advice, file: Path | None) -> Iterator[str]:
    """Yield what stands below the table, and the campaign file of the plan."""
    yield from advice.notes()
    if file:
        yield f"campaign: {file}; next: millscale run {file} --runs runs/{file.stem}"


def _cells(row: PredictedNumber, ratios: list[float], checked: bool) -> list[str]:
    digits = row.digits
    measured = {value.S: number(value.mean, digits) for value in row.measured}
    cells = [row.observable.label, *row.cells]
    cells += [measured.get(S, NONE) for S in ratios]
    if checked:
        cells += [number(row.check, digits), YES_NO[row.is_inside]]
    return cells
