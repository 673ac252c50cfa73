"""Wear of the liner by Archard and by Finnie, and its rate in the physical mill.

J. F. Archard, J. Appl. Phys. 24 (1953) 981-988, doi 10.1063/1.1721448: worn volume K F s / H. With
Coulomb's friction mu F s is the slip work W, so the volume is k W with k = K / (mu H).
I. Finnie, Wear 3 (1960) 87-103, doi 10.1016/0043-1648(60)90055-7: worn volume of an impact k E f,
with E = 1/2 m v^2 and f of the angle of the impact. Limits: docs/theory/liner-wear.md.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from millscale.analysis.wear.loads import LinerLoads
from millscale.runs.case_file import Case
from millscale.runs.speed import schedule_of

# Law: the load that a constant multiplies.
LAWS = {"archard": "slip_work_J", "finnie": "finnie_energy_J"}


@dataclass(frozen=True)
class WearRate:
    """Energy that wears the liner of the physical mill, per area and time.

    Attributes:
        law: of LAWS.
        edges: (bins + 1,) float, arc length over that of a pitch.
        flux: (bins,) float [W/m^2].
        error: (bins,) float, standard error of the flux by the scatter of the sectors; nan of fewer
            than two sectors [W/m^2].
    """

    law: str
    edges: np.ndarray
    flux: np.ndarray
    error: np.ndarray

    @property
    def mean(self) -> float:
        """Return the mean over the profile [W/m^2]."""
        return float(np.average(self.flux, weights=np.diff(self.edges)))


def wear_rate(loads: LinerLoads, case: Case, law: str) -> WearRate:
    """Return the rate of wear in the physical mill by the loads of a scaled mill.

    Args:
        law: of LAWS.
    """
    of_sectors = loads.of_sectors(LAWS[law])
    bins, sectors = loads.bins, len(of_sectors)
    area = case.mill.simulated_length_m * bins.widths
    flux = physical_flux(case) * of_sectors / (area * loads.duration)
    error = np.full(len(area), np.nan)
    if sectors > 1:
        error = flux.std(axis=0, ddof=1) / np.sqrt(sectors)
    return WearRate(law, bins.edges / bins.edges[-1], flux.mean(axis=0), error)


def physical_flux(case: Case) -> float:
    """Return energy per area and time of the physical mill over that of its scaled mill.

    Power scales as M g R omega. The mass of the whole charge is S^2 L / L' times that of the scaled
    mill, the area of the liner S L / L' times. Derived here.
    """
    ratio = schedule_of(case).last_ratio

    def scale(mill: Any) -> float:
        return float(mill.gravity_m_s2 * mill.radius_m * mill.omega_rad_s * ratio)

    return case.S * scale(case.physical) / scale(case.mill)


def mean_rate(rates: list[WearRate]) -> WearRate:
    """Return the mean of the rates of equal mills, such as of several seeds."""
    flux = np.array([rate.flux for rate in rates])
    error = np.array([rate.error for rate in rates])
    return WearRate(
        rates[0].law,
        rates[0].edges,
        flux.mean(axis=0),
        np.sqrt((error**2).sum(axis=0)) / len(rates),
    )
