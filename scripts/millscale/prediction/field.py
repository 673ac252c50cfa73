"""The mean solid fraction over the cross-section of the physical mill.

The surface of the bed moves with S, and a cell that it passes follows no power of S. So each sector
is extrapolated in moved coordinates: the radius outside of which a share u of the balls of the
sector lies follows the law, for each u, and so does the sum of the sector. Derived here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from millscale.analysis.finished import Charge
from millscale.analysis.shapes.occupancy import PolarCells, read_occupancy
from millscale.prediction.extrapolation import (
    ExtrapolationError,
    by_ratio,
    check_norm,
    weights,
)
from millscale.prediction.kinds import Kind

# Standard deviation of the kernel that fields are averaged with, over R - a.
RESOLUTION = 0.03
# Shares u of the balls of a sector.
SHARES = 1000


@dataclass(frozen=True)
class PredictedField:
    """Mean solid fraction of the physical mill, averaged by a kernel of width `RESOLUTION`.

    It has no interval: the layers of balls at the liner have the width of a ball, so they do not
    follow the law, and an interval of noise and exponent held a mill that was left out too rarely.

    Attributes:
        cells: lengths over R - a.
        values: (rings, sectors) float.
        check: share of the balls that a physical mill that was left out has elsewhere.
        nearest: the same of the smallest scaled S, for comparison.
    """

    cells: PolarCells
    values: np.ndarray
    check: float | None = None
    nearest: float | None = None

    def document(self) -> dict[str, Any]:
        """Return its numbers as JSON types, without the cells (`csv`)."""
        return {
            "resolution": RESOLUTION,
            "share_elsewhere_than_left_out": self.check,
            "share_elsewhere_of_smallest_S_than_left_out": self.nearest,
        }

    def csv(self) -> str:
        """Return a row for each cell, ring by ring from the axis, as occupancy.csv has."""
        head = "radius_low,radius_high,angle_low_rad,angle_high_rad,solid_fraction"
        radii, angles = self.cells.radii, self.cells.angles
        rows = [
            f"{radii[i]:.6g},{radii[i + 1]:.6g},{angles[j]:.9g},{angles[j + 1]:.9g},{value:.5f}"
            for (i, j), value in np.ndenumerate(self.values)
        ]
        return "\n".join([head, *rows, ""])


def predict_field(charges: Sequence[Charge], left_out: Sequence[Charge] = ()) -> PredictedField:
    """Extrapolate the mean solid fraction to S = 1.

    Args:
        charges: of two or more values of S.
        left_out: charges of S = 1 to compare with.

    Raises:
        ExtrapolationError: too few charges, values of S too close together, or cells that differ.
        RunFolderError: a charge has no occupancy.csv.
    """
    read = {charge: read_occupancy(charge.folder) for charge in (*charges, *left_out)}
    cells = read[charges[0]][0]
    for charge, (other, _) in read.items():
        if not cells.is_like(other):
            raise ExtrapolationError(f"{charge.id} and {charges[0].id} have other cells")
    groups = by_ratio((charge.S, read[charge][1]) for charge in charges)
    if len(groups) < 2:
        raise ExtrapolationError("an extrapolation needs two values of S or more")
    S = np.array([ratio for ratio, _ in groups])
    runs = np.array([len(fields) for _, fields in groups], dtype=float)
    at_mean = weights(S, runs, Kind.DILATION.prior.middle)
    check_norm(S, float(np.linalg.norm(at_mean)))
    means = [np.mean(fields, axis=0) for _, fields in groups]
    field = PredictedField(cells, cells.smooth(moved(means, at_mean, cells), RESOLUTION))
    if not left_out:
        return field
    truth, near = (
        cells.smooth(np.mean(fields, axis=0), RESOLUTION)
        for fields in ([read[charge][1] for charge in left_out], groups[0][1])
    )
    return replace(
        field,
        check=share_elsewhere(field.values, truth, cells),
        nearest=share_elsewhere(near, truth, cells),
    )


def share_elsewhere(ours: np.ndarray, theirs: np.ndarray, cells: PolarCells) -> float:
    """Return the share of the balls that one field has elsewhere than the other."""
    areas = cells.areas
    return float((np.abs(ours - theirs) * areas).sum() / (2.0 * (theirs * areas).sum()))


def moved(fields: Sequence[np.ndarray], by: np.ndarray, cells: PolarCells) -> np.ndarray:
    """Return the weighted sum of fields in moved coordinates, (rings, sectors) float.

    Args:
        fields: (rings, sectors) float each.
        by: their weights, which sum to 1.
    """
    sums = np.array([(field * cells.areas).sum(axis=0) for field in fields])
    radii = np.array([radii_of_shares(field, cells) for field in fields])
    total = np.maximum(by @ sums, 0.0)
    edges = cells.radii
    # The ends keep every ball inside the cells.
    place = np.clip(np.tensordot(by, radii, axes=1), edges[0], np.nextafter(edges[-1], 0.0))
    ring = np.searchsorted(edges, place, side="right") - 1
    sectors = fields[0].shape[1]
    counts = np.zeros(fields[0].shape)
    np.add.at(counts, (ring, np.broadcast_to(np.arange(sectors), ring.shape)), 1.0)
    return counts / SHARES * total / cells.areas


def radii_of_shares(field: np.ndarray, cells: PolarCells) -> np.ndarray:
    """Return the radius outside of which each share of the balls of a sector lies, (`SHARES`,
    sectors) float; that of the liner in an empty sector."""
    shares = (np.arange(SHARES) + 0.5) / SHARES
    squares = cells.radii[::-1] ** 2
    found = np.full((SHARES, field.shape[1]), cells.radii[-1])
    for j, sector in enumerate((field * cells.areas).T):
        outside = np.append(0.0, np.cumsum(sector[::-1]))
        if outside[-1] > 0.0:
            # Balls are even over the area of a cell.
            found[:, j] = np.sqrt(np.interp(shares * outside[-1], outside, squares))
    return found
