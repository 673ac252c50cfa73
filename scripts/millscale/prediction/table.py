"""A prediction, and an advice, as a table and lines for the terminal."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from rich.table import Table

from millscale.formats import NONE, duration, number
from millscale.prediction.advise import Advice
from millscale.prediction.noise import PITCHES
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


def prediction_lines(prediction: Prediction) -> Iterator[str]:
    """Yield what stands below the table: refusals, runs, warnings."""
    for row in prediction.numbers:
        if row.refused:
            yield f"not predicted: {row.observable.label}: {row.refused}"
    if prediction.contour is None:
        yield f"not predicted: surface contour: {prediction.contour_refused}"
    else:
        contour = prediction.contour
        yield (
            f"surface contour: {len(contour.points)} points, half width of the interval "
            f"{100.0 * contour.half_widths.mean():.2f} % of R - a in the mean"
        )
        if contour.check and contour.nearest:
            ours, theirs = (100.0 * pair[0] for pair in (contour.check, contour.nearest))
            yield (
                f"  distance from the contour of S = 1, left out: {ours:.2f} % of R - a; that of "
                f"the smallest scaled S: {theirs:.2f} %"
            )
    yield from _mass_flow_lines(prediction)
    yield from _field_lines(prediction)
    if not prediction.spectra:
        yield f"not predicted: impacts: {prediction.spectra_refused}"
    by_ratio: dict[str, int] = {}
    for charge in prediction.runs:
        by_ratio[f"{charge.S:.4g}"] = by_ratio.get(f"{charge.S:.4g}", 0) + 1
    used = ", ".join(f"S = {S}: {count}" for S, count in by_ratio.items())
    yield f"runs by {prediction.scheme}, {prediction.policy}: {used}; all steady"
    if any(row.noise_from == PITCHES for row in prediction.numbers):
        yield "noise from the scatter of lifter pitches: too few seeds to measure it"
    for name, why in prediction.excluded.items():
        yield f"not used: {name}: {why}"
    for warning in prediction.warnings:
        yield f"warning: {warning}"


def _mass_flow_lines(prediction: Prediction) -> Iterator[str]:
    curve = prediction.mass_flow
    if curve is None:
        yield f"not predicted: mass in the monitoring box: {prediction.mass_flow_refused}"
        return
    mass, mean = prediction.mill.mass, float(curve.values.mean())
    yield (
        f"mass in the monitoring box over a lifter pitch: {len(curve.values)} phases, "
        f"{mass * curve.values.min():.4g} to {mass * curve.values.max():.4g} kg, half width of the "
        f"interval {100.0 * curve.half_widths.mean() / mean:.1f} % of its mean"
    )
    if curve.check and curve.nearest and curve.inside is not None:
        yield (
            f"  RMS difference from S = 1, left out: {100.0 * curve.check:.1f} % of "
            f"its mean, {100.0 * curve.inside:.0f} % of the phases inside; that of the "
            f"smallest scaled S: {100.0 * curve.nearest:.1f} %"
        )


def _field_lines(prediction: Prediction) -> Iterator[str]:
    field = prediction.field
    if field is None:
        yield f"not predicted: map of the solid fraction: {prediction.field_refused}"
        return
    yield "map of the solid fraction, without an interval: --field FILE writes it"
    if field.check is not None and field.nearest is not None:
        yield (
            f"  balls that S = 1, left out, has elsewhere: {100.0 * field.check:.1f} %; than the "
            f"smallest scaled S: {100.0 * field.nearest:.1f} %"
        )


def advice_table(advice: Advice) -> Table:
    """Return a row for the chosen design, then one for the best of each kind."""
    names = list(advice.chosen.half_widths)
    table = Table(title=f"Runs for an error of {100.0 * advice.error:g} %", title_justify="left")
    for heading in ("", "runs", "time on one core", *names):
        table.add_column(heading, justify="left" if heading in ("", "runs") else "right")
    for kind, design in [("chosen", advice.chosen), *((x.name, x) for x in advice.cheapest)]:
        widths = [f"{100.0 * design.half_widths[name]:.2f} %" for name in names]
        table.add_row(kind, design.runs, duration(design.cost_s), *widths)
    return table


def advice_lines(advice: Advice, file: Path | None) -> Iterator[str]:
    """Yield what stands below the table: whether the error is reached, where it comes from."""
    if not advice.met:
        reached = f"{100.0 * advice.chosen.worst:.2g} %"
        within = f" in {duration(advice.budget_s)}" if advice.budget_s else ""
        able = [design for design in advice.cheapest if design.worst <= advice.error]
        cheapest = min(able, key=lambda design: design.cost_s, default=None)
        needs = (
            f"it takes {duration(cheapest.cost_s)}: {cheapest.runs}"
            if cheapest
            else "no design that was looked at reaches it"
        )
        yield f"not reached{within}: the chosen runs give {reached}; {needs}"
    yield "columns: expected half width of the 95 % interval; of one scaled mill its error as well"
    origin = advice.origin
    learnt = ", ".join(str(origin[key]) for key in ("command", "date") if key in origin)
    yield f"errors learnt from: {learnt}"
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
