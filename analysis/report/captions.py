"""Words for captions: which cases a figure shows."""

from __future__ import annotations

from collections.abc import Sequence

from millscale.analysis.finished import Charge, Finished

MOST_LISTED = 6


def words(scheme: str) -> str:
    """Return the name of a scheme for a caption."""
    return scheme.replace("-", " ")


def scales_of(cases: Sequence[Finished]) -> str:
    """Return the S of some cases: S = 1, 1.3, 2.6, or the ends of a long list."""
    known = sorted({case.S for case in cases})
    if len(known) > MOST_LISTED:
        return f"{len(known)} S from {known[0]:.4g} to {known[-1]:.4g}"
    return "S = " + ", ".join(f"{S:.4g}" for S in known)


def charges_of(charges: Sequence[Charge]) -> str:
    """Return S, numbers of balls and seeds of some charges."""
    balls = sorted({charge.balls for charge in charges})
    seeds = sorted({charge.seed for charge in charges})
    count = f"{balls[0]:,}" + (f" to {balls[-1]:,}" if len(balls) > 1 else "")
    of_seeds = f"seed{'s' * (len(seeds) > 1)} {', '.join(map(str, seeds))}"
    return f"{scales_of(charges)}; {count} balls; {of_seeds}"
