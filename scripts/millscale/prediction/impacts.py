"""Impact spectra of the physical mill, from charges with an energy budget.

Energies of impacts are over m (omega R)^2, m the mass of a ball, which similar mills share. Impacts
are counted by decade of this energy, per ball and revolution. The logarithm of each count is
extrapolated, so that it stays positive. Derived here.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from millscale.analysis.charge.impacts import HIGHEST, LOWEST, energy_unit, rebinned
from millscale.analysis.finished import Charge
from millscale.analysis.result_file import PAIRINGS
from millscale.prediction.extrapolation import (
    ExtrapolationError,
    Group,
    Noise,
    by_ratio,
    extrapolate,
    pooled_noise,
)
from millscale.prediction.kinds import Kind

# Fewer impacts in a run are too few for a count.
FEWEST_IMPACTS = 10.0
NO_BUDGET = "fewer than two values of S have an energy budget: ledger = true in [multi_ball]"


@dataclass(frozen=True)
class Decade:
    """Impacts of one decade of energy.

    Attributes:
        low_J, high_J: in the physical mill [J].
        rate, lower, upper: impacts per second in the whole physical mill, and the interval.
        measured: the same from the scaled mills, by S.
        check: of a physical mill that was left out; None if none was, or it had none.
    """

    low_J: float
    high_J: float
    rate: float
    lower: float
    upper: float
    measured: Mapping[float, float]
    check: float | None = None

    @property
    def is_inside(self) -> bool | None:
        """Return whether the interval holds the mill that was left out."""
        return None if self.check is None else self.lower <= self.check <= self.upper


@dataclass(frozen=True)
class PredictedSpectrum:
    """Impacts of one pairing, ball_ball or ball_wall, by decade of energy."""

    pairing: str
    decades: tuple[Decade, ...]

    def document(self) -> dict[str, Any]:
        """Return it as JSON types."""
        rows = [asdict(x) | {"is_inside": x.is_inside} for x in self.decades]
        for row in rows:
            row["measured"] = {f"{S:.6g}": rate for S, rate in row["measured"].items()}
        return {"pairing": self.pairing, "decades": rows}


@dataclass(frozen=True)
class Scales:
    """Scales of the physical mill's spectrum.

    Attributes:
        energy: m (omega R)^2 [J].
        rate: N omega / 2 pi [1/s].
    """

    energy: float
    rate: float


def predict_spectra(
    charges: Sequence[Charge],
    left_out: Sequence[Charge],
    level: float,
    scales: Scales,
) -> tuple[PredictedSpectrum, ...]:
    """Extrapolate the impacts of each pairing and decade to S = 1.

    Args:
        charges: of two or more values of S.
        left_out: charges of S = 1 to compare with.

    Raises:
        ExtrapolationError: no energy budget at two values of S, or no count that is large enough.
    """
    kept = [charge for charge in charges if charge.result.ledger is not None]
    if len(by_ratio((charge.S, charge) for charge in kept)) < 2:
        raise ExtrapolationError(NO_BUDGET)
    found = []
    for pairing in PAIRINGS:
        counts = {charge: counts_by_decade(charge, pairing) for charge in kept}
        truth = [
            counts_by_decade(charge, pairing)
            for charge in left_out
            if charge.result.ledger is not None
        ]
        decades = []
        for i in range(HIGHEST - LOWEST):
            at_decade = {charge: float(count[i]) for charge, count in counts.items()}
            if any(x * charge.balls < FEWEST_IMPACTS for charge, x in at_decade.items()):
                continue
            decade = _decade(i, at_decade, level, scales)
            known = [float(count[i]) for count in truth if count[i] > 0.0]
            if known:
                decade = replace(decade, check=scales.rate * math.fsum(known) / len(known))
            decades.append(decade)
        if decades:
            found.append(PredictedSpectrum(pairing, tuple(decades)))
    if not found:
        raise ExtrapolationError(f"fewer than {FEWEST_IMPACTS:g} impacts in each decade of energy")
    return tuple(found)


def counts_by_decade(charge: Charge, pairing: str) -> np.ndarray:
    """Return the impacts per ball and revolution in each decade, (`HIGHEST` - `LOWEST`,) float."""
    ledger = charge.result.ledger
    assert ledger is not None
    spectrum, unit = ledger.impacts[pairing], energy_unit(charge.case)
    edges = spectrum.energy_low_J, spectrum.energy_high_J
    return rebinned(*edges, spectrum.impacts, unit) / charge.balls


def _decade(i: int, counts: Mapping[Charge, float], level: float, scales: Scales) -> Decade:
    """Return the decade of counts per ball and revolution, all above 0."""
    groups = [
        Group(S, tuple(map(math.log, values)))
        for S, values in by_ratio((charge.S, count) for charge, count in counts.items())
    ]
    seeds = pooled_noise(groups)
    # Independent impacts scatter at least as Poisson's.
    fewest = min(count * charge.balls for charge, count in counts.items())
    noise = Noise(max(seeds.deviation, 1.0 / math.sqrt(fewest)), seeds.freedom)
    found = extrapolate(groups, noise, level, Kind.UNKNOWN.prior)
    rate, lower, upper = (
        scales.rate * math.exp(x) for x in (found.value, found.lower, found.upper)
    )
    low, high = (scales.energy * 10.0 ** (LOWEST + i + end) for end in (0, 1))
    measured = {group.S: scales.rate * math.exp(group.mean) for group in groups}
    return Decade(low, high, rate, lower, upper, measured)
