"""Impacts of a charge: impact_spectra.csv, and the spectra of charges by decade of energy.

Energies are over m (omega R)^2, m the mean mass of a ball, which similar mills share. Contacts are
counted per ball and revolution. Derived here.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from millscale.analysis.finished import Charge
from millscale.analysis.result_file import (
    PAIRINGS,
    ContactClass,
    EnergyBins,
    ImpactsResult,
    PairingImpacts,
)
from millscale.runs.case_file import Case
from millscale.runs.untrusted import MOST_SERIES, RunFolderError, read_text

SPECTRA = "impact_spectra.csv"
NAMES = dict(zip(PAIRINGS, ("ball on ball", "ball on liner"), strict=True))
# Decades of the energy over m (omega R)^2.
LOWEST, HIGHEST = -12, 2
# Contacts of a decade that are too few to compare.
FEWEST = 100.0
# Relative difference that two decades may have, and how many deviations of their counts besides.
ALIKE, DEVIATIONS = 0.1, 2.0
_REMEDY = "run the case again: millscale run FILE --runs DIR --only ID"
COLUMNS = (
    *("mill_angle_from_rad", "mill_angle_to_rad", "duration_s", "pairing", "type_1", "type_2"),
    *("quantity", "energy_low_J", "energy_high_J", "contacts", "energy_J"),
)
_Row = dict[str, str]


def energy_unit(case: Case) -> float:
    """Return m (omega R)^2 of a case [J]."""
    return float(case.ball.mass_kg * (case.mill.omega_rad_s * case.mill.radius_m) ** 2)


def read_impacts(folder: Path, case: Case) -> ImpactsResult:
    """Return the impacts of a case folder.

    Raises:
        RunFolderError: impact_spectra.csv is missing, cut short or not understood.
    """
    path = folder / SPECTRA
    lines = read_text(path, MOST_SERIES, _REMEDY).splitlines()
    if not lines or tuple(lines[0].split(",")) != COLUMNS:
        raise RunFolderError(path, f"columns must be {', '.join(COLUMNS)}", _REMEDY)
    rows = list(csv.DictReader(lines))
    try:
        return _result(rows, energy_unit(case))
    except (KeyError, TypeError, ValueError, IndexError) as error:
        raise RunFolderError(path, f"a row is not whole: {error}", _REMEDY) from None


def _result(rows: list[_Row], unit: float) -> ImpactsResult:
    first, last, duration = (float(rows[0][name]) for name in COLUMNS[:3])
    if not (duration > 0.0 and last > first):
        raise ValueError("the mill does not turn")
    pairings = {pairing: _pairing(rows, pairing, duration) for pairing in PAIRINGS}
    classes = sorted(
        {
            (row["pairing"], int(row["type_1"]), int(row["type_2"]))
            for row in rows
            if row["quantity"] in ("dissipated", "available")
        }
    )
    return ImpactsResult(
        from_rad=first,
        to_rad=last,
        duration_s=duration,
        energy_unit_J=unit,
        **pairings,
        classes=tuple(_class(rows, *one, duration) for one in classes),
    )


def _pairing(rows: list[_Row], pairing: str, duration: float) -> PairingImpacts:
    def total(quantity: str, column: str = "energy_J") -> float:
        return math.fsum(
            float(row[column])
            for row in rows
            if row["pairing"] == pairing and row["quantity"] == quantity
        )

    ended = total("dissipated")
    lasting = total("open_at_end") - total("open_at_begin")
    found = total("all_contacts")
    return PairingImpacts(
        contacts_per_s=total("dissipated", "contacts") / duration,
        available_W=total("available") / duration,
        ended_W=ended / duration,
        lasting_W=lasting / duration,
        dissipated_W=found / duration,
        sum_error=abs(ended + lasting - found) / abs(found) if found else 0.0,
    )


def _class(
    rows: list[_Row], pairing: str, first: int, second: int, duration: float
) -> ContactClass:
    of = [
        row
        for row in rows
        if (row["pairing"], int(row["type_1"]), int(row["type_2"])) == (pairing, first, second)
    ]

    def bins(quantity: str) -> EnergyBins:
        kept = [row for row in of if row["quantity"] == quantity]
        values = np.array([[float(row[name]) for name in COLUMNS[-4:]] for row in kept])
        values = values.reshape(len(kept), 4)
        if not np.isfinite(values).all():
            raise ValueError("a number is not finite")
        values[:, 2:] /= duration
        return EnergyBins(*(tuple(column) for column in values.T.tolist()))

    return ContactClass(
        pairing=pairing,
        ball_class=first,
        other_class=second or None,
        dissipated=bins("dissipated"),
        available=bins("available"),
    )


def rebinned(
    low_J: Sequence[float] | np.ndarray,
    high_J: Sequence[float] | np.ndarray,
    values: Sequence[float] | np.ndarray,
    unit: float,
    decades: tuple[int, int] = (LOWEST, HIGHEST),
) -> np.ndarray:
    """Return values of bins in decades of the energy over a unit, (decades,) float. A bin that an
    edge of a decade cuts is divided evenly over the logarithm.

    Args:
        unit: [J].
        decades: powers of ten at the begin of the first and the end of the last.
    """
    low, high = (np.log10(np.array(x) / unit) for x in (low_J, high_J))
    begins = np.arange(*decades)[:, None]
    common = np.minimum(high, begins + 1.0) - np.maximum(low, begins)
    return np.maximum(common, 0.0) / (high - low) @ np.array(values)


def bodies_per_ball(pairing: str, S: float) -> float:
    """Return what each ball of a mill can strike, over that at S = 1: balls are not scaled, so a
    mill that is filled alike has S times as much liner for each ball."""
    return S if pairing == "ball_wall" else 1.0


def summed_bins(
    result: ImpactsResult, pairing: str | None, quantity: str = "dissipated", S: float = 1.0
) -> EnergyBins:
    """Return the bins of a pairing, or of all for None, summed over the classes of balls.

    Args:
        S: of the mill, to divide contacts by `bodies_per_ball`.
    """
    rows: dict[tuple[float, float], np.ndarray] = {}
    for one in result.classes:
        if pairing is not None and one.pairing != pairing:
            continue
        bins: EnergyBins = getattr(one, quantity)
        factor = 1.0 / bodies_per_ball(one.pairing, S)
        for low, high, *values in bins.rows():
            rows[low, high] = rows.get((low, high), np.zeros(2)) + factor * np.array(values)
    kept = sorted(rows)
    return EnergyBins(
        tuple(low for low, _ in kept),
        tuple(high for _, high in kept),
        tuple(float(rows[edges][0]) for edges in kept),
        tuple(float(rows[edges][1]) for edges in kept),
    )


@dataclass(frozen=True)
class Decade:
    """Contacts of one decade of energy, in a scaled mill and in the reference.

    Attributes:
        low: lower edge, energy over m (omega R)^2.
        ratio: energy per ball and revolution over that of the reference, both over
            m (omega R)^2, on the liner per area of it; None with too few contacts.
        tolerance: of the ratio's difference from 1.
        share: of this decade in the reference's energy.
    """

    low: float
    ratio: float | None
    tolerance: float
    share: float

    @property
    def is_alike(self) -> bool:
        """Return whether the scaled mill has this part of the spectrum."""
        return self.ratio is not None and abs(self.ratio - 1.0) <= self.tolerance


@dataclass(frozen=True)
class Collapse:
    """A spectrum of a scaled mill beside that of the reference, by decade of energy.

    Attributes:
        S, reference_S: of the scaled mill and of the reference.
        alike_share: of the reference's energy in decades that are alike.
    """

    id: str
    S: float
    reference_S: float
    pairing: str
    decades: tuple[Decade, ...]

    @property
    def alike_share(self) -> float:
        return math.fsum(x.share for x in self.decades if x.is_alike)


def collapses(charges: Sequence[Charge], quantity: str = "dissipated") -> tuple[Collapse, ...]:
    """Return the spectra of charges beside those of the mill of the smallest S, for each scheme and
    variant. Runs of one S that differ in the packing are the reference together.

    Args:
        quantity: dissipated or available.
    """
    kept = [charge for charge in charges if charge.result.impacts is not None]
    found = []
    for group in sorted({(charge.scheme, charge.variant) for charge in kept}):
        of = [charge for charge in kept if (charge.scheme, charge.variant) == group]
        smallest = min(charge.S for charge in of)
        reference = [charge for charge in of if smallest == charge.S]
        for charge in sorted(of, key=lambda x: (x.S, x.id)):
            if smallest == charge.S:
                continue
            found += [_collapse(charge, reference, pairing, quantity) for pairing in PAIRINGS]
    return tuple(found)


def _collapse(charge: Charge, reference: Sequence[Charge], pairing: str, quantity: str) -> Collapse:
    energy, contacts = by_decade(charge, pairing, quantity)
    pairs = [by_decade(one, pairing, quantity) for one in reference]
    expected = np.mean([x[0] for x in pairs], axis=0)
    energy = energy / bodies_per_ball(pairing, charge.S)
    expected = expected / bodies_per_ball(pairing, reference[0].S)
    counted = np.sum([x[1] for x in pairs], axis=0)
    whole = float(expected.sum())
    decades = []
    for k in np.flatnonzero(expected > 0.0).tolist():
        enough = min(contacts[k], counted[k]) >= FEWEST
        tolerance = ALIKE
        if enough:
            tolerance += DEVIATIONS * math.sqrt(1.0 / contacts[k] + 1.0 / counted[k])
        decades.append(
            Decade(
                low=10.0 ** (LOWEST + k),
                ratio=float(energy[k] / expected[k]) if enough else None,
                tolerance=tolerance,
                share=float(expected[k]) / whole,
            )
        )
    return Collapse(charge.id, charge.S, reference[0].S, pairing, tuple(decades))


def by_decade(
    charge: Charge, pairing: str, quantity: str = "dissipated"
) -> tuple[np.ndarray, np.ndarray]:
    """Return the energy per ball and revolution over m (omega R)^2, and the contacts counted, in
    each decade from `LOWEST` to `HIGHEST`."""
    result = charge.result.impacts
    assert result is not None
    bins = summed_bins(result, pairing, quantity)
    unit = result.energy_unit_J
    if not bins.contacts_per_s:
        return np.zeros(HIGHEST - LOWEST), np.zeros(HIGHEST - LOWEST)
    edges = bins.energy_low_J, bins.energy_high_J
    revolution = math.tau / charge.case.mill.omega_rad_s
    energy = rebinned(*edges, bins.power_W, unit) * revolution / (charge.balls * unit)
    return energy, rebinned(*edges, bins.contacts_per_s, unit) * result.duration_s
