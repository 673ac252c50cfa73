"""The friction exponent of a mill as a table and lines for the terminal."""

from __future__ import annotations

import math
from collections.abc import Iterator

from rich.table import Table

from millscale.analysis.measures import NUMBERS, Quantity
from millscale.calibration.matched_mills import MatchedFriction
from millscale.campaign.keys import FRICTION_MATCHED
from millscale.formats import NONE, number, percent

_QUANTITIES = {quantity.name: quantity for quantity in NUMBERS}


def friction_table(found: MatchedFriction) -> Table:
    """Return the reference's values and by k the differences of the other mill from them."""
    table = Table(
        title=f"S = {found.far:g} at friction exponents k, differences from S = {found.near:g}",
        title_justify="left",
    )
    table.add_column("observable")
    table.add_column(f"S = {found.near:g}", justify="right")
    exponents = list(found.match.differences)
    for k in exponents:
        table.add_column(f"k = {k:g}", justify="right")
    table.add_column("by chance", justify="right")
    table.add_column("k of its own", justify="right")
    for row in found.observables:
        quantity = _QUANTITIES[row.name]
        shown = [_difference(quantity, row.tried[k], row.reference) for k in exponents]
        chance = NONE
        if row.reference is not None and row.chance is not None:
            above = row.reference + math.copysign(row.chance, row.reference)
            chance = _difference(quantity, above, row.reference)
        own = number(row.exponent, 2)
        table.add_row(quantity.heading, quantity.text(row.reference), *shown, chance, own)
    distances = [f"{100.0 * found.contours[k]:.2f}" for k in exponents if k in found.contours]
    if distances:
        table.add_row("contour, mean distance [% of R - a]", "0", *distances, NONE, NONE)
    return table


def friction_lines(found: MatchedFriction) -> Iterator[str]:
    """Yield what stands below the table: the exponent, its check, the lines of a campaign file."""
    matched, confirmed = found.match, found.confirmed_at
    yield (
        f"k = {matched.exponent:.2f} +- {matched.half_width:.2f} "
        f"(95 %, noise from {found.noise_from})"
    )
    if abs(matched.exponent - 1.0) <= matched.half_width:
        yield "the default, k = 1, is within the interval"
    yield (
        f"confirmed by the run of k = {confirmed:g}: -x_c / R differs by "
        f"{matched.differences[confirmed]:+.2g}, by chance {matched.largest_chance:.2g}"
    )
    for name, why in found.excluded.items():
        yield f"not used: {name}: {why}"
    for name in found.worse_at(confirmed):
        yield f"warning: farther from the reference than without matching: {_label(name)}"
    yield "in the campaign file:"
    yield "[scaling]"
    yield f'policies = ["{FRICTION_MATCHED}"]'
    yield f"friction_exponent = {found.exponent:g}"


def _label(name: str) -> str:
    return _QUANTITIES[name].label


def _difference(quantity: Quantity, value: float | None, reference: float | None) -> str:
    """Return a difference as it is shown: of angles in degrees, else relative."""
    if value is None or reference is None:
        return NONE
    if quantity.unit == "deg":
        return f"{quantity.text(value - reference, signed=True)} deg"
    return percent(value / reference - 1.0)
