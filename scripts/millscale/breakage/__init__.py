"""Breakage of ore from impact spectra, by published models: post-processing, no ore is simulated.

    >>> import numpy as np
    >>> from millscale.breakage import Spectrum, t10
    >>> spectrum = Spectrum(np.array([0.1, 1.0, 10.0]), np.array([1000.0, 20.0]))
    >>> f"{spectrum.power:.0f} W in {spectrum.rate:.0f} impacts per second"
    '379 W in 1020 impacts per second'
    >>> f"{t10(0.5, largest=60.0, rate=0.8):.1f} % finer than a tenth"
    '19.8 % finer than a tenth'

Formulas, sources and limits: docs/theory/breakage.md.
"""

from millscale.breakage.austin import AustinSelection, fit_austin
from millscale.breakage.jk import JOULE_PER_KG, specific_energy_for, t10
from millscale.breakage.selection import Grinding, Nip, broken_share, selection_rates
from millscale.breakage.spectrum import Spectrum
from millscale.breakage.tavares import TavaresOre, damage

__all__ = [
    "JOULE_PER_KG",
    "AustinSelection",
    "Grinding",
    "Nip",
    "Spectrum",
    "TavaresOre",
    "broken_share",
    "damage",
    "fit_austin",
    "selection_rates",
    "specific_energy_for",
    "t10",
]
