"""How much the errors of a charge owe to chance: its seeds against each other."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from millscale.analysis.charge.errors import (
    FLOW_ERRORS,
    PARTS,
    SHAPE_ERRORS,
    deviation,
    mean_known,
)
from millscale.analysis.charge.scaled_mills import Charge, pairs, seeds_of

Row = dict[str, Any]
ERRORS = (*SHAPE_ERRORS, *FLOW_ERRORS, "power_error")


def with_seed_spread(rows: list[Row], charges: Sequence[Charge], errors: dict) -> None:
    """Add to each row, in place:

    seeds: how many its model has;
    seed_spread: standard deviation (n - 1) over the seeds of each error against the reference;
    between_seeds: the same errors between two seeds, as the mean over the pairs. An error no
        larger than this may be chance. A scaled mill with one seed takes the value of the mill
        nearest in S of the same campaign that has several; `between_seeds_of` names it.

    Args:
        errors: by the keys of two charges.
    """
    row_of = {(row["campaign"], row["id"]): row for row in rows}
    for charge in charges:
        row, seeds = row_of[charge.key], seeds_of(charge, charges)
        row["seeds"] = len(seeds)
        own = [row_of[seed.key] for seed in seeds]
        spread = {name: deviation([r[name] for r in own]) for name in ERRORS}
        spread["power_W"] = deviation([r["power_W"] for r in own])
        row["seed_spread"] = spread if len(seeds) > 1 else None
        lender = _with_seeds(charge, charges)
        row["between_seeds_of"] = lender.id if lender else None
        row["between_seeds"] = between_seeds(seeds_of(lender, charges), errors) if lender else None


def between_seeds(seeds: Sequence[Charge], errors: dict) -> Row:
    """Errors of the seeds of a model against each other, mean over the pairs."""
    found = [errors[a.key, b.key] for a, b in pairs(seeds)]
    mean = {name: mean_known(e[name] for e in found) for name in ERRORS}
    mean["power_error"] = mean_known(
        abs(e["power_error"]) for e in found if e["power_error"] is not None
    )
    steady = [e["mean_over_angles"] for e in found]
    mean["mean_over_angles"] = {n: mean_known(e[n] for e in steady) for n in SHAPE_ERRORS}
    numbers = sorted({n for e in found for n in e["curtain_iou"] or {}}, key=int)
    mean["curtain_iou"] = {
        n: {p: mean_known((e["curtain_iou"] or {}).get(n, {}).get(p) for e in found) for p in PARTS}
        for n in numbers
    } or None
    return mean


def _with_seeds(charge: Charge, charges: Sequence[Charge]) -> Charge | None:
    """A charge of the model whose seeds tell the spread of another."""
    several = [
        other
        for other in charges
        if other.campaign == charge.campaign and len(seeds_of(other, charges)) > 1
    ]

    def distance(other: Charge) -> tuple:
        return (
            other.model != charge.model,
            abs(other.S - charge.S),
            other.model[1:4] != charge.model[1:4],
        )

    return min(several, key=distance, default=None)
