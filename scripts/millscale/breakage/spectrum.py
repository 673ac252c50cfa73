"""Impact spectrum: how often impacts of an energy happen."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

# Ends of two bins closer than this, relative, are one.
SAME_EDGE = 1e-9


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Impacts per second by energy, of a mill or of one class of pairs.

    Attributes:
        edges: (n + 1,) float, ends of the bins of the energy of one impact, rising [J].
        counts: (n,) float, impacts per second [1/s].
        sums: (n,) float, energy of the impacts of each bin per second [W]; None: each impact has
            the geometric mean of the ends.

    Raises:
        ValueError: wrong lengths, edges that do not rise from above 0, or a negative number.
    """

    edges: np.ndarray
    counts: np.ndarray
    sums: np.ndarray | None = None

    def __post_init__(self) -> None:
        edges, counts = np.asarray(self.edges, float), np.asarray(self.counts, float)
        if edges.ndim != 1 or len(edges) != len(counts) + 1:
            raise ValueError(f"{len(edges)} edges of {len(counts)} bins; accepted: one edge more")
        if not (edges[0] > 0.0 and (np.diff(edges) > 0.0).all() and np.isfinite(edges).all()):
            raise ValueError("edges of a spectrum; accepted: rising numbers above 0")
        others = [counts] if self.sums is None else [counts, np.asarray(self.sums, float)]
        if any(len(x) != len(counts) or not (x >= 0.0).all() for x in others):
            raise ValueError("counts or sums of a spectrum; accepted: numbers from 0, one a bin")

    @classmethod
    def of_bins(
        cls, low: np.ndarray, high: np.ndarray, counts: np.ndarray, sums: np.ndarray
    ) -> Spectrum:
        """Return the spectrum of bins of which empty ones may be left out, as result.json has them.

        Args:
            low, high: (n,) float, ends of the bins, rising [J].
            counts, sums: (n,) float, impacts per second [1/s], and their energy [W].
        """
        low, high = np.asarray(low, float), np.asarray(high, float)
        # Between two bins that do not touch lies an empty one.
        gap = np.append(high[:-1] < low[1:] * (1.0 - SAME_EDGE), True)
        edges = np.sort(np.concatenate([low, high[gap]]))
        places = np.searchsorted(edges, low)
        every = np.zeros((2, len(edges) - 1))
        every[:, places] = counts, sums
        return cls(edges, every[0], every[1])

    @property
    def energies(self) -> np.ndarray:
        """Mean energy of an impact of each bin, (n,) float [J]."""
        middle = np.sqrt(self.edges[:-1] * self.edges[1:])
        if self.sums is None:
            return middle
        return np.where(self.counts > 0.0, self.sums / np.maximum(self.counts, 1e-300), middle)

    @property
    def rate(self) -> float:
        """Impacts per second [1/s]."""
        return float(np.sum(self.counts))

    @property
    def power(self) -> float:
        """Energy of all impacts per second [W]."""
        return float(np.sum(self.energies * self.counts))

    def scaled(self, energy: float, rate: float) -> Spectrum:
        """Return the spectrum of impacts of so many times the energy and the number per second.

        From a scaled mill to the physical one these are (m omega^2 R^2) and (N omega), physical
        over scaled, with N the balls of the whole mill over those that were simulated.
        """
        power = energy * rate * self.energies * self.counts
        return Spectrum(energy * self.edges, rate * self.counts, power)

    def __add__(self, other: Spectrum) -> Spectrum:
        """Return the spectrum of both classes.

        Raises:
            ValueError: other bins.
        """
        if not np.array_equal(self.edges, other.edges):
            raise ValueError("spectra of other bins cannot be added")
        sums = self.energies * self.counts + other.energies * other.counts
        return Spectrum(self.edges, self.counts + other.counts, sums)
