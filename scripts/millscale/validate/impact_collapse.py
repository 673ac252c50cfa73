"""Spectra of impacts of several S, decade by decade: `millscale validate impact-collapse`.

Energies are over m (omega R)^2 and over m g R, sums per ball and revolution, so that similar mills
share them. Derived here; docs/theory/impacts.md.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from millscale.analysis.charge.impacts import (
    ALIKE,
    DEVIATIONS,
    FEWEST,
    HIGHEST,
    LOWEST,
    by_decade,
    energy_unit,
    summed_bins,
)
from millscale.analysis.charge.scaled_mills import ScaledMill, scaled_mills
from millscale.analysis.finished import Charge
from millscale.analysis.finished_campaign import load_campaign
from millscale.engine.record import provenance
from millscale.runs.untrusted import RunFolderError
from millscale.runs.writing import write_json, write_text
from millscale.validate.impact_collapse_page import COMMAND, draw, page

Row = dict[str, Any]
QUANTITIES = ("dissipated", "available")
# Decades with less than this share of the energy of each mill are left out.
LEAST_SHARE = 1e-3


def write_impact_collapse(folders: Sequence[Path], docs: Path) -> str:
    """Write results/impact-collapse.json, its figure and its page; return the page.

    Args:
        folders: runs folders of finished campaigns of one physical mill, scheme and policy.

    Raises:
        RunFolderError: fewer than two S have spectra, or the mills are of several kinds.
    """
    document = {"schema": 1, **provenance(), "command": COMMAND, **collapse(folders)}
    file = docs / "results/impact-collapse.json"
    file.parent.mkdir(parents=True, exist_ok=True)
    write_json(file, document)
    draw(document, file.with_suffix(".png"))
    text = page(document)
    write_text(file.with_suffix(".md"), text)
    return text


def collapse(folders: Sequence[Path]) -> Row:
    """Return mills and spectra of runs folders as a JSON object.

    Raises:
        RunFolderError: as `write_impact_collapse`.
    """
    charges = [
        charge
        for folder in folders
        for charge in load_campaign(folder).charges
        if charge.result.impacts is not None
    ]
    _check(charges, folders[0])
    mills = sorted(scaled_mills(charges), key=lambda mill: mill.first.S)
    return {
        "scheme": mills[-1].first.scheme,
        "policy": mills[-1].first.policy,
        "stiffness": mills[-1].first.stiffness,
        "reference_S": mills[0].first.S,
        "mills": [_mill_row(mill) for mill in mills],
        "spectra": [
            _spectra(mills, name, pairing, per)
            for name in QUANTITIES
            for pairing, per in (
                ("ball_ball", "ball"),
                ("ball_wall", "ball"),
                ("ball_wall", "area"),
            )
        ],
    }


def _check(charges: Sequence[Charge], folder: Path) -> None:
    if len({charge.S for charge in charges}) < 2:
        cause = "fewer than two S have spectra of their impacts"
        raise RunFolderError(folder, cause, "run campaigns/impact-collapse.toml")
    if any(charge.case.physical != charges[0].case.physical for charge in charges):
        cause = "its charges are of several physical mills"
        raise RunFolderError(folder, cause, "give campaigns of one physical mill")
    kinds = {(x.scheme, x.variant, x.stiffness) for x in charges if not x.is_physical}
    if len(kinds) > 1 or len({x.key for x in charges}) < len(charges):
        known = "; ".join(sorted(", ".join(kind) for kind in kinds))
        cause = f"its charges are of several kinds, or one is given twice: {known}"
        raise RunFolderError(folder, cause, "give campaigns of one scheme and policy")


def _mill_row(mill: ScaledMill) -> Row:
    """Return what the page states of a mill."""
    case, results = mill.first.case, [charge.result for charge in mill.seeds]
    impacts = [result.impacts for result in results if result.impacts is not None]
    unit = energy_unit(case)
    return {
        "S": mill.first.S,
        "seeds": [charge.seed for charge in mill.seeds],
        "balls": case.ball.count,
        "slice_ball_diameters": case.mill.simulated_length_m / (2.0 * case.ball.radius_m),
        "froude": case.mill.froude,
        "energy_unit_J": unit,
        "step_over_limit": case.time.limit_fraction,
        "window_rad": [impacts[0].from_rad, impacts[0].to_rad],
        "steady": all(result.steady.is_steady for result in results),
        "largest_overlap_over_radius": max(
            (x for r in results if (x := r.largest_overlap_over_radius) is not None), default=None
        ),
        "sum_error": max(of.sum_error for x in impacts for of in x.pairings.values()),
    }


def _spectra(mills: Sequence[ScaledMill], quantity: str, pairing: str, per: str) -> Row:
    """Return a spectrum of all mills.

    Args:
        per: ball, or area of the liner: mills that are filled alike have S times the area for each
            ball, because the balls are not scaled.
    """
    found = [
        _Decades(mill, quantity, pairing, mill.first.S if per == "area" else 1.0) for mill in mills
    ]
    reference = found[0]
    shown = np.max([x.mean / max(x.mean.sum(), 1e-300) for x in found], axis=0) >= LEAST_SHARE
    return {
        "quantity": quantity,
        "pairing": pairing,
        "per": per,
        "decades": [
            {
                "low": 10.0 ** (LOWEST + k),
                "share": float(reference.mean[k] / reference.mean.sum()),
                "mills": [x.against(reference, k) for x in found[1:]],
            }
            for k in np.flatnonzero(shown).tolist()
        ],
        "all": [x.against(reference, None) for x in found[1:]],
        "alike_shares": [x.alike_share(reference) for x in found[1:]],
        "curves": [_curve(mill, quantity, pairing) for mill in mills if per == "ball"],
    }


class _Decades:
    """Energy of the contacts of a mill by decade, per ball and revolution, over a divisor.

    Attributes:
        S: of the mill.
        mean, error: (decades,) float, over the seeds, and its standard error.
        contacts: (decades,) float, counted in all seeds.
    """

    def __init__(self, mill: ScaledMill, quantity: str, pairing: str, divisor: float) -> None:
        of_seeds = [by_decade(charge, pairing, quantity) for charge in mill.seeds]
        self.S = mill.first.S
        self._energy = np.array([energy for energy, _ in of_seeds]) / divisor
        self.contacts = np.sum([contacts for _, contacts in of_seeds], axis=0)
        self.mean = self._energy.mean(axis=0)
        self.error = self._error(self._energy, self.contacts)

    @staticmethod
    def _error(energy: np.ndarray, contacts: np.ndarray) -> np.ndarray:
        """Return the standard error of means over the first axis; of one seed by the count."""
        if len(energy) > 1:
            return energy.std(axis=0, ddof=1) / math.sqrt(len(energy))
        return energy[0] / np.sqrt(np.maximum(contacts, 1.0))

    def of(self, decade: int | None) -> tuple[float, float, float]:
        """Return mean, error and contacts of a decade; None: of all."""
        if decade is not None:
            return self.mean[decade], self.error[decade], self.contacts[decade]
        energy, contacts = self._energy.sum(axis=1, keepdims=True), self.contacts.sum(keepdims=True)
        return energy.mean(), self._error(energy, contacts)[0], contacts[0]

    def against(self, reference: _Decades, decade: int | None) -> Row:
        """Return a decade over that of the reference; ratio null with too few contacts."""
        mean, error, contacts = self.of(decade)
        other, other_error, other_contacts = reference.of(decade)
        if min(contacts, other_contacts) < FEWEST or not (mean > 0.0 and other > 0.0):
            return {"S": self.S, "ratio": None, "error": None, "alike": False}
        ratio = mean / other
        spread = ratio * math.hypot(error / mean, other_error / other)
        return {
            "S": self.S,
            "ratio": float(ratio),
            "error": float(spread),
            "alike": bool(abs(ratio - 1.0) <= ALIKE + DEVIATIONS * spread),
        }

    def alike_share(self, reference: _Decades) -> float:
        """Return the share of the reference's energy in decades that agree."""
        alike = [self.against(reference, k)["alike"] for k in range(HIGHEST - LOWEST)]
        return float(reference.mean[alike].sum() / reference.mean.sum())


def _curve(mill: ScaledMill, quantity: str, pairing: str) -> Row:
    """Return the spectrum of a mill in the engine's bins: mean of the seeds, least and most.

    Energies are over m (omega R)^2, values per decade, ball and revolution.
    """
    seeds: list[dict[tuple[float, float], float]] = []
    for charge in mill.seeds:
        result = charge.result.impacts
        assert result is not None
        bins, unit = summed_bins(result, pairing, quantity), result.energy_unit_J
        revolution = math.tau / charge.case.mill.omega_rad_s
        seeds.append(
            {
                (low, high): power * revolution / (charge.balls * unit) / math.log10(high / low)
                for low, high, _, power in bins.rows()
            }
        )
    edges = sorted(set().union(*seeds))
    values = np.array([[of.get(edge, 0.0) for edge in edges] for of in seeds])
    return {
        "S": mill.first.S,
        "energy": [math.sqrt(low * high) / energy_unit(mill.first.case) for low, high in edges],
        "mean": values.mean(axis=0).tolist(),
        "least": values.min(axis=0).tolist(),
        "most": values.max(axis=0).tolist(),
    }
