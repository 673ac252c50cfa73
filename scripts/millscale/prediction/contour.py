"""The surface contour of the physical mill, extrapolated along the normals of a scaled mill's.

Lengths are over R - a, so that similar mills coincide. A charge's contour is that of its mean solid
fraction over all dumps of the steady window, inside the circle of the lifter tops. Along each
normal of the mean contour at the smallest S the displacements of all contours are extrapolated to
S = 1 as any other observable (`extrapolation`).
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from millscale.analysis.finished import Charge
from millscale.analysis.shapes.comparison import curve_distances
from millscale.analysis.shapes.contour import surface_contour
from millscale.analysis.shapes.shape import contour_grid, snapshots_at, unit_length, wanted_angles
from millscale.analysis.shapes.snapshots import Snapshot
from millscale.prediction.extrapolation import SAME_S, ExtrapolationError, Group, Noise, by_ratio
from millscale.prediction.kinds import Kind
from millscale.prediction.noise import FEWEST_SEED_FREEDOM
from millscale.prediction.points import extrapolate_points, noise_of_points
from millscale.runs.case_file import Case
from millscale.runs.dumps import read_dump
from millscale.runs.untrusted import RunFolderError

# Distance of neighbouring normals, and the farthest that contours lie apart, over R - a.
SPACING, REACH = 0.02, 0.25
# Parts of the steady window whose scatter gives the noise of a run without seeds.
BLOCKS = 4
# Corners of the circle of the lifter tops.
_CORNERS = 720


@dataclass(frozen=True)
class PredictedContour:
    """The free surface of the physical mill's bed; lengths over R - a.

    Attributes:
        points: (n, 2) float [x, z] on the surface.
        half_widths: (n,) float, of the interval along the normal.
        check: mean and largest distance from the contour of a physical mill that was left out.
        nearest: the same of the smallest scaled S, for comparison.
        inside: share of the points whose interval holds that contour.
        shifts: displacements of each run in the mean over the points, by S; counted positive
            towards the contour of the largest S.
        noise: of one run, at a point.
    """

    points: np.ndarray
    half_widths: np.ndarray
    check: tuple[float, float] | None
    nearest: tuple[float, float] | None
    shifts: tuple[Group, ...]
    noise: Noise
    inside: float | None = None

    def document(self, unit_m: float) -> dict[str, Any]:
        """Return it as JSON types, lengths in m.

        Args:
            unit_m: R - a of the physical mill [m].
        """

        def distances(pair: tuple[float, float] | None) -> dict[str, float] | None:
            return None if pair is None else {"mean": pair[0], "largest": pair[1]}

        return {
            "points_m": (unit_m * self.points).round(6).tolist(),
            "half_widths_m": (unit_m * self.half_widths).round(6).tolist(),
            "half_width_mean": float(self.half_widths.mean()),
            "distance_from_left_out": distances(self.check),
            "distance_of_smallest_S_from_left_out": distances(self.nearest),
            "share_inside": self.inside,
        }


@functools.cache
def mean_contour(charge: Charge) -> np.ndarray:
    """Return the longest line of the contour of a charge's mean solid fraction, (n, 2) float.

    Reads all dumps of the steady window, once for each charge.

    Raises:
        RunFolderError: no dumps in the steady window, or no surface.
    """
    return _contour(charge, _snapshots(charge))


def block_contours(charge: Charge) -> list[np.ndarray]:
    """Return the contours of the successive quarters of a charge's steady window.

    Raises:
        RunFolderError: fewer than two dumps in a quarter, or no surface.
    """
    found = _snapshots(charge)
    if len(found) < 2 * BLOCKS:
        raise RunFolderError(
            charge.folder,
            f"{len(found)} dumps in the steady window, {2 * BLOCKS} are needed",
            "dump more often, or add a seed",
        )
    size = len(found) / BLOCKS
    edges = [round(i * size) for i in range(BLOCKS + 1)]
    return [_contour(charge, found[a:b]) for a, b in itertools.pairwise(edges)]


def _snapshots(charge: Charge) -> list[Snapshot]:
    """Return the dumps of the steady window.

    Raises:
        RunFolderError: there is none.
    """
    result = charge.result
    angles = [
        angle
        for angle in wanted_angles(result.rotation_angle_rad)
        if result.mean_from_rad <= angle <= result.mean_to_rad
    ]
    found = snapshots_at(charge.folder, angles)
    if not found:
        raise RunFolderError(charge.folder, "no dumps in the steady window", "dump more often")
    return [found[angle] for angle in sorted(found)]


def _contour(charge: Charge, snapshots: Sequence[Snapshot]) -> np.ndarray:
    """Return the longest line of the contour of the mean solid fraction of some dumps."""
    case = charge.case
    unit, length = unit_length(case), case.mill.simulated_length_m / unit_length(case)
    centres, areas = [], []
    for snapshot in snapshots:
        dump = read_dump(snapshot.path)
        centres.append(dump.positions[:, [0, 2]] / unit)
        volumes = 4.0 / 3.0 * np.pi * (dump["radius"] / unit) ** 3
        areas.append(volumes / length / len(snapshots))
    line = surface_line(case, np.vstack(centres), np.concatenate(areas))
    if line is None:
        raise RunFolderError(charge.folder, "its bed has no surface", "look at it in OVITO")
    return line


def surface_line(case: Case, centres: np.ndarray, areas: np.ndarray) -> np.ndarray | None:
    """Return the longest line of the contour of balls inside the circle of the lifter tops, (n, 2)
    float; None if there is none.

    Args:
        centres: (m, 2) float [x, z] of the balls of all dumps, over R - a.
        areas: (m,) float, as in `solid_fraction`, over the number of dumps.
    """
    tops = case.mill.lifter_top_radius_m if case.mill.lifters else case.mill.radius_m
    turn = np.linspace(0.0, 2.0 * np.pi, _CORNERS, endpoint=False)
    circle = tops / unit_length(case) * np.column_stack([np.cos(turn), np.sin(turn)])
    contour = surface_contour(centres, areas, circle, contour_grid(case))
    return max(contour.lines, key=_length) if contour.lines else None


def predict_contour(
    charges: Sequence[Charge], left_out: Sequence[Charge] = (), level: float = 0.95
) -> PredictedContour:
    """Extrapolate the contour to S = 1.

    Args:
        charges: of two or more values of S.
        left_out: charges of S = 1 to compare with.

    Raises:
        ExtrapolationError: too few charges, or contours too far apart.
        RunFolderError: a charge has no dumps or no surface.
    """
    lines = {charge: mean_contour(charge) for charge in charges}
    first = min(charge.S for charge in charges)
    nearest = [lines[charge] for charge in charges if charge.S - first < SAME_S]
    base, normals = with_normals(nearest[0])
    if len(nearest) > 1:
        moved = np.mean([displacements(base, normals, line) for line in nearest], axis=0)
        base, normals = with_normals(base + moved[:, None] * normals)
    by_charge = {charge: displacements(base, normals, line) for charge, line in lines.items()}
    known = np.all([np.isfinite(values) for values in by_charge.values()], axis=0)
    if known.mean() < 0.5:
        raise ExtrapolationError("the contours of the scaled mills lie too far apart")
    groups = by_ratio((charge.S, values) for charge, values in by_charge.items())
    few = sum(len(seeds) - 1 for _, seeds in groups) < FEWEST_SEED_FREEDOM
    of_blocks = _noise_of_blocks(charges, base, normals) if few else None
    at_points = [(S, [seed[known] for seed in seeds]) for S, seeds in groups]
    noise, _ = noise_of_points(at_points, of_blocks)
    values, widths = extrapolate_points(at_points, noise, level, Kind.SHAPE.prior)
    truth = [mean_contour(charge) for charge in left_out]
    base, normals = base[known], normals[known]
    surface = base + values[:, None] * normals
    return PredictedContour(
        surface,
        widths,
        _distances(surface, truth),
        _distances(base, truth),
        _shifts(at_points),
        noise,
        _share_inside(base, normals, truth, values, widths),
    )


def displacements(base: np.ndarray, normals: np.ndarray, line: np.ndarray) -> np.ndarray:
    """Return how far a line lies from each point along its normal, (n,) float; nan if it does not
    cross the normal within `REACH`.

    Args:
        base: (n, 2) float. normals: (n, 2) float, of length 1. line: (m, 2) float.
    """
    start, step = line[:-1], np.diff(line, axis=0)
    # base + d n = start + s step for each point (rows) and each piece of the line (columns).
    across = normals[:, None, 0] * step[None, :, 1] - normals[:, None, 1] * step[None, :, 0]
    gap = start[None] - base[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        along = (gap[..., 0] * step[None, :, 1] - gap[..., 1] * step[None, :, 0]) / across
        share = (gap[..., 0] * normals[:, None, 1] - gap[..., 1] * normals[:, None, 0]) / across
    along[~((share >= 0.0) & (share <= 1.0) & (np.abs(along) <= REACH))] = np.nan
    nearest = np.full(len(base), np.nan)
    crosses = np.isfinite(along).any(axis=1)
    rows = np.flatnonzero(crosses)
    nearest[rows] = along[rows, np.nanargmin(np.abs(along[rows]), axis=1)]
    return nearest


def with_normals(line: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return points evenly along a line and the normals there, (n, 2) float each."""
    line = line[np.isfinite(line).all(axis=1)]
    travelled = np.append(0.0, np.cumsum(np.hypot(*np.diff(line, axis=0).T)))
    places = np.linspace(0.0, travelled[-1], max(3, round(travelled[-1] / SPACING) + 1))
    points = np.column_stack([np.interp(places, travelled, column) for column in line.T])
    # Tangents over two spacings, in which the grid of the solid fraction does not show.
    tangents = np.gradient(points, axis=0)
    tangents /= np.linalg.norm(tangents, axis=1)[:, None]
    return points, np.column_stack([-tangents[:, 1], tangents[:, 0]])


def _noise_of_blocks(charges: Sequence[Charge], base: np.ndarray, normals: np.ndarray) -> Noise:
    """Return the noise of one contour from the quarters of each run, over all points.

    Raises:
        RunFolderError: a run has too few dumps, or no surface.
    """
    squares = []
    for charge in charges:
        moved = np.array([displacements(base, normals, line) for line in block_contours(charge)])
        squares.append(np.nanmean(np.var(moved, axis=0, ddof=1)) / BLOCKS)
    return Noise(math.sqrt(float(np.mean(squares))), float(len(charges) * (BLOCKS - 1)))


def _share_inside(
    base: np.ndarray,
    normals: np.ndarray,
    truth: Sequence[np.ndarray],
    values: np.ndarray,
    half_widths: np.ndarray,
) -> float | None:
    """Return the share of the points whose interval holds the mean of other contours."""
    if not truth:
        return None
    errors = np.mean([displacements(base, normals, line) for line in truth], axis=0) - values
    known = np.isfinite(errors)
    return float(np.mean(np.abs(errors[known]) <= half_widths[known])) if known.any() else None


def _shifts(at_points: Sequence[tuple[float, Sequence[np.ndarray]]]) -> tuple[Group, ...]:
    """Return the displacements of each run in the mean over the points, by S."""
    towards = np.sign(np.mean(at_points[-1][1], axis=0))
    return tuple(
        Group(S, tuple(float(np.mean(towards * seed)) for seed in seeds)) for S, seeds in at_points
    )


def _distances(line: np.ndarray, others: Sequence[np.ndarray]) -> tuple[float, float] | None:
    """Return mean and largest distance from other contours, in the mean over them."""
    if not others:
        return None
    mean, largest = np.mean([curve_distances([line], [other]) for other in others], axis=0)
    return float(mean), float(largest)


def _length(line: np.ndarray) -> float:
    return float(np.hypot(*np.diff(line, axis=0).T).sum())
