"""Rates of breakage from an impact spectrum and the strength of an ore.

No ore is in the simulation. So what an impact does to ore is assumed, and stated as numbers: how
many particles it catches, which share of its energy they take, and how much ore the mill holds.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

from millscale.breakage.spectrum import Spectrum
from millscale.breakage.tavares import TavaresOre, damage

# Fracture energies from the largest of a size downwards, over so many factors of e, and steps.
_FOLDS, _STEPS = 14.0, 280


@dataclass(frozen=True)
class Nip:
    """What an impact catches.

    Attributes:
        particles: particles that share an impact.
        energy_share: of the energy of the impact that they take.

    Raises:
        ValueError: no particle, or a share that is not above 0 and up to 1.
    """

    particles: float
    energy_share: float

    def __post_init__(self) -> None:
        if not (self.particles > 0.0 and 0.0 < self.energy_share <= 1.0):
            raise ValueError(f"{self}; accepted: particles above 0, a share above 0 and up to 1")


@dataclass(frozen=True)
class Grinding:
    """An ore in a mill.

    Attributes:
        spectrum: impacts of the whole mill.
        hold_up: mass of the ore in the mill, as if it were all of one size [kg].
    """

    spectrum: Spectrum
    ore: TavaresOre
    hold_up: float
    nip: Nip

    def __post_init__(self) -> None:
        if not self.hold_up > 0.0:
            raise ValueError(f"hold_up = {self.hold_up!r}; accepted: above 0")

    def specific_energies(self, size: float) -> np.ndarray:
        """Return the energy that a caught particle of a size [m] takes over its mass, by bin of the
        spectrum, (n,) float [J/kg]."""
        share = self.nip.energy_share / (self.nip.particles * self.ore.mass(size))
        return share * self.spectrum.energies

    def impact_rates(self, size: float) -> np.ndarray:
        """Return how often a particle of a size [m] is caught, by bin of the spectrum, (n,) float
        [1/s]."""
        particles = self.hold_up / self.ore.mass(size)
        return self.spectrum.counts * self.nip.particles / particles

    @property
    def specific_power(self) -> float:
        """Energy that the ore takes per second and mass [W/kg]."""
        return self.nip.energy_share * self.spectrum.power / self.hold_up


def selection_rates(grinding: Grinding, sizes: np.ndarray) -> np.ndarray:
    """Return the rate at which particles without damage break, by size [m], (n,) float [1/s].

    S(d) = sum_i nu_i P(e_i, d), with nu_i how often a particle is caught by impacts of bin i.
    Derived here.
    """
    return np.array(
        [
            grinding.impact_rates(size)
            @ grinding.ore.broken(grinding.specific_energies(size), size)
            for size in np.asarray(sizes, float)
        ]
    )


def broken_share(grinding: Grinding, size: float, time: float) -> float:
    """Return the share of particles of a size [m] that break within a time [s], by impacts that
    damage those they do not break.

    Fracture energies lie on a logarithmic grid. An impact of e breaks those below e, and lowers the
    others by their `damage`; a particle between two grid points counts on both. So the shares f
    that are unbroken follow df/dt = M f, and f(t) = exp(M t) f(0). Derived here.
    """
    ore = grinding.ore
    largest = ore.truncation * ore.median_energy(size)
    step = _FOLDS / _STEPS
    edges = largest * np.exp(step * (np.arange(_STEPS + 1) - _STEPS))
    grid = np.sqrt(edges[:-1] * edges[1:])
    below = ore.broken(edges, size)
    shares = np.diff(below)
    shares[0] += below[0]
    change = np.zeros((_STEPS, _STEPS))
    columns = np.arange(_STEPS)
    for energy, rate in zip(
        grinding.specific_energies(size), grinding.impact_rates(size), strict=True
    ):
        if rate <= 0.0:
            continue
        ratio = np.minimum(energy / grid, 1.0)
        left = np.where(ratio < 1.0, 1.0 - damage(ratio, ore.damage_exponent), 0.0)
        # Places on the grid after the impact; those below its first point stay on it.
        place = columns + np.log(np.maximum(left, 1e-300)) / step
        lower = np.clip(np.floor(place).astype(int), 0, _STEPS - 1)
        upper_share = np.clip(place - lower, 0.0, 1.0)
        kept = rate * (left > 0.0)
        np.add.at(change, (lower, columns), kept * (1.0 - upper_share))
        np.add.at(change, (np.minimum(lower + 1, _STEPS - 1), columns), kept * upper_share)
        change[columns, columns] -= rate
    return float(1.0 - (expm(time * change) @ shares).sum())
