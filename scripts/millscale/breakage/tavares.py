"""Fracture energies and damage of particles: the model of Tavares and King."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np
from scipy.special import ndtr, ndtri

# Halvings of an interval that find the damage to the last digits of a double.
_HALVINGS = 60
# Ranges of published materials, as a public document quotes them (docs/theory/breakage.md).
USUAL = {
    "size_exponent": (0.45, 2.3),
    "damage_exponent": (3.0, 5.4),
    "largest_t10": (38.8, 76.3),
    "t10_rate": (0.0115, 0.0932),
}


@dataclass(frozen=True)
class TavaresOre:
    """Strength of an ore by the model of Tavares; every number must come from tests of the ore.

    Attributes:
        density: of the particles [kg/m^3].
        residual_energy: e_inf, median specific fracture energy of large particles [J/kg].
        size: d_0, below which particles are stronger [m].
        size_exponent: phi.
        scatter: sigma, standard deviation of the logarithm of the fracture energies.
        truncation: largest fracture energy of a size over its median, e_max / e_50.
        damage_exponent: gamma.
        largest_t10: A [%].
        t10_rate: b', over e / e_50.
        stiffness_ratio: stiffness of the particle over that of the surface that hits it, k_p / k_s;
            0 if e_inf is that measured on steel.

    Raises:
        ValueError: a number that no ore has.
    """

    density: float
    residual_energy: float
    size: float
    size_exponent: float
    scatter: float
    truncation: float
    damage_exponent: float
    largest_t10: float
    t10_rate: float
    stiffness_ratio: float = 0.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            least = {"truncation": 1.0, "stiffness_ratio": -1e-300}.get(field.name, 0.0)
            most = 100.0 if field.name == "largest_t10" else math.inf
            if not least < value <= most:
                raise ValueError(f"{field.name} of an ore: {value!r}; accepted: above {least:g}")

    def unusual(self) -> list[str]:
        """Return which numbers lie outside of the ranges of published materials."""
        return [
            f"{name} {getattr(self, name):g}, usual {least:g} to {most:g}"
            for name, (least, most) in USUAL.items()
            if not least <= getattr(self, name) <= most
        ]

    def mass(self, size: float) -> float:
        """Return the mass of a particle of a size [m], as a sphere [kg]."""
        return self.density * math.pi / 6.0 * size**3

    def median_energy(self, size: float) -> float:
        """Return the median specific fracture energy of a size [m], e_50 [J/kg].

        e_50 = e_inf / (1 + k_p / k_s) (1 + (d_0 / d)^phi)

        Source: L. M. Tavares, R. P. King, Int. J. Miner. Process. 54 (1998) 1-28, as the documents
        of docs/theory/breakage.md quote it.
        """
        stronger = 1.0 + (self.size / size) ** self.size_exponent
        return self.residual_energy / (1.0 + self.stiffness_ratio) * stronger

    def broken(self, energy: np.ndarray, size: float) -> np.ndarray:
        """Return the share of unbroken particles of a size [m] whose specific fracture energy is
        below an energy [J/kg], (n,) float: the probability to break by one impact.

        P = Phi(ln(e* / e_50) / sigma),   e* = e_max e / (e_max - e): an upper-truncated log-normal

        Source: the same.
        """
        energy = np.asarray(energy, float)
        median = self.median_energy(size)
        largest = self.truncation * median
        inside = np.clip(energy, 1e-300, (1.0 - 1e-12) * largest)
        relative = largest * inside / (largest - inside)
        share = ndtr(np.log(relative / median) / self.scatter)
        return np.where(energy >= largest, 1.0, np.where(energy <= 0.0, 0.0, share))

    def energy_of_share(self, share: np.ndarray, size: float) -> np.ndarray:
        """Return the inverse of `broken` [J/kg]."""
        median = self.median_energy(size)
        largest = self.truncation * median
        relative = median * np.exp(self.scatter * ndtri(share))
        return largest * relative / (largest + relative)

    def t10(self, energy: np.ndarray, size: float) -> np.ndarray:
        """Return the mass of the fragments finer than a tenth of the particle [%].

        t10 = A (1 - exp(-b' e / e_50b))

        e_50b is the median fracture energy of the particles that an impact of e breaks.

        Source: the same, and the documentation of Rocky.
        """
        half = 0.5 * self.broken(energy, size)
        median = self.energy_of_share(half, size)
        ratio = np.divide(energy, median, out=np.zeros_like(median), where=median > 0.0)
        return -self.largest_t10 * np.expm1(-self.t10_rate * ratio)


def damage(ratio: np.ndarray, exponent: float) -> np.ndarray:
    """Return the damage D of particles by an impact that does not break them, (n,) float.

        D = (2 gamma / (2 gamma + 5 - 5 D) r)^(2 gamma / 5),   e_after = (1 - D) e_before

    Args:
        ratio: r, specific energy of the impact over the fracture energy, 0 to 1.
        exponent: gamma.

    It follows from a Hertz contact whose stiffness falls with its deformation, F = k (1 - D)
    alpha^1.5 with D = (alpha / alpha_c)^gamma: the work to alpha over that to alpha_c is D^(5 / 2
    gamma) (2 gamma + 5 - 5 D) / 2 gamma. Derived here, and as the source has it. D is 1 at r = 1.

    Source: L. M. Tavares, R. P. King, Powder Technol. 123 (2002) 138-146, as a public document
    quotes it; another quotes a factor 1 - D in the numerator, with which D would not reach 1.
    """
    ratio = np.clip(np.asarray(ratio, float), 0.0, 1.0)
    power, twice = 2.5 / exponent, 2.0 * exponent
    low, high = np.zeros_like(ratio), np.ones_like(ratio)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        below = middle**power * (twice + 5.0 - 5.0 * middle) / twice < ratio
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return 0.5 * (low + high)
