"""Mean solid fraction of the cross-section in polar cells, from occupancy.csv."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.ndimage import gaussian_filter

from millscale.runs.untrusted import MOST_SERIES, RunFolderError, read_text

OCCUPANCY = "occupancy.csv"
_CELL = ("radius_low", "radius_high", "angle_low_rad", "angle_high_rad")
_COLUMNS = (*_CELL, "solid_fraction")
_REMEDY = "run the case again: millscale run FILE --runs DIR --only ID"


@dataclass(frozen=True)
class PolarCells:
    """Cells of a cross-section: rings about the axis, cut into sectors.

    Attributes:
        radii: (rings + 1,) float, edges over R - a.
        angles: (sectors + 1,) float, edges from the vertical [rad].
    """

    radii: np.ndarray
    angles: np.ndarray

    @property
    def areas(self) -> np.ndarray:
        """Return the areas of the cells over (R - a)^2, (rings, sectors) float."""
        rings = 0.5 * np.diff(self.radii**2)
        return rings[:, None] * np.diff(self.angles)[None, :]

    def is_like(self, other: PolarCells) -> bool:
        """Return whether the cells are the same."""
        return all(
            ours.shape == theirs.shape and np.allclose(ours, theirs, atol=1e-9)
            for ours, theirs in ((self.radii, other.radii), (self.angles, other.angles))
        )

    def smooth(self, values: np.ndarray, resolution: float) -> np.ndarray:
        """Return values (rings, sectors) averaged by a Gaussian kernel.

        Args:
            resolution: standard deviation over R - a, along the radius and along the circle of
                radius 1.
        """
        widths = [resolution / float(np.diff(edges).mean()) for edges in (self.radii, self.angles)]
        return gaussian_filter(values, widths, mode=("nearest", "wrap"))


def read_occupancy(folder: Path) -> tuple[PolarCells, np.ndarray]:
    """Return the cells and the solid fraction (rings, sectors) of a case folder.

    Raises:
        RunFolderError: no occupancy.csv, or one that is not whole.
    """
    path = folder / OCCUPANCY
    lines = read_text(path, MOST_SERIES, _REMEDY).splitlines()
    names = lines[0].split(",") if lines else []
    if missing := [name for name in _COLUMNS if name not in names]:
        raise RunFolderError(path, f"no column {', '.join(missing)}", _REMEDY)
    try:
        rows = np.array([[float(x) for x in line.split(",")] for line in lines[1:]])
        column = {name: rows[:, names.index(name)] for name in _COLUMNS}
        if not np.isfinite(rows).all():
            raise ValueError("a number is not finite")
        edges = [np.unique(np.concatenate([column[a], column[b]])) for a, b in _pairs()]
        shape = tuple(len(x) - 1 for x in edges)
        fraction = column["solid_fraction"].reshape(shape)
    except (ValueError, IndexError) as error:
        raise RunFolderError(path, f"its cells are not whole: {error}", _REMEDY) from None
    return PolarCells(*edges), fraction


def _pairs() -> tuple[tuple[str, str], tuple[str, str]]:
    return (_CELL[0], _CELL[1]), (_CELL[2], _CELL[3])
