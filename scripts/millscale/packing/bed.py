"""The settled bed: its largest overlap, how densely it lies, whether it is at rest."""

from __future__ import annotations

import io
import math
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from millscale.packing.ball_sizes import mean_by_mass
from millscale.packing.charge import Packing, Room, largest_overlap, overlaps, periodic_tree
from millscale.packing.random_block import size_levels
from millscale.runs.untrusted import open_regular

HEADER_LINES = 9
COLUMNS = ("x", "y", "z", "vx", "vy", "vz", "radius")
# The bulk begins so many mean diameters away from liner and surface: where order at the walls has
# faded and the loose top layer has ended.
MARGIN = 2.0
POINTS = 100_000
FEWEST_POINTS = 10_000
BATCHES = 20
# Beds overlap by 0.04 radii at S = 2.6 and the paper's modulus, and by depth to the power 2/3 more.
# At a quarter the balls are no Hertz contacts any more: a step too long, or a modulus too low.
LARGEST_OVERLAP = 0.25
# Of a bed: share of balls that touch something, rms speed over sqrt(g d). After the default time
# 0.88 and more touch, and the speed is 0.30 or less; after a quarter of it they are 0.92 and 0.85
# (docs/guide/plan.md, "Settling"). In the initial packing up to 0.08 are as near.
LEAST_HELD = 0.5
MOST_LIVELY = 0.5
# Gap that counts as contact [ball radii]: balls of steel bounce for long, by less than this.
NEAR = 0.01
# Balls a point is tested against when sizes differ: the nearest centre need not be the ball's.
CANDIDATES = 8


def bed_record(path: Path, room: Room, gravity: float, meshed: bool = False) -> dict[str, Any]:
    """Return the part of settled.json about the bed in a dump with the columns `COLUMNS`.

    Args:
        room: of the charge.
        gravity: [m/s^2].
        meshed: the balls lie on panels, which are up to `room.gap` nearer than the arcs.

    Raises:
        ValueError: the file is no such dump, balls overlap by more than `LARGEST_OVERLAP`, or the
            charge has not settled.
    """
    packing, velocities = read_bed(path, room.length, room.closed)
    radius = typical_radius(packing.radii)
    overlap = largest_overlap(packing)
    if overlap > LARGEST_OVERLAP * radius:
        raise ValueError(
            f"balls of the settled bed overlap by {overlap:.3g} m, more than {LARGEST_OVERLAP} of "
            "their radius: take a shorter step_s or a larger youngs_modulus_pa"
        )
    speed = float(np.sqrt((velocities**2).sum(axis=1).mean()))
    held = float(in_contact(room, packing, room.gap if meshed else 0.0, NEAR * radius).mean())
    _check_settled(held, speed, math.sqrt(2.0 * gravity * radius))
    return {
        "largest_overlap_m": overlap,
        "largest_overlap_over_radius": overlap / radius,
        "balls_in_contact": held,
        "bulk_fraction": bulk_fraction(room, packing, np.random.default_rng(0)),
        "rms_speed_m_s": speed,
    }


def _check_settled(held: float, speed: float, of_fall: float) -> None:
    """Refuse a charge that still falls.

    Args:
        held: share of the balls that touch another or the liner, to within `NEAR`.
        speed: root mean square [m/s].
        of_fall: through a ball's radius [m/s].
    """
    if held < LEAST_HELD:
        raise ValueError(
            f"the charge hangs in the air after settling: {held:.0%} of its balls are within {NEAR}"
            f" radii of another or the liner, of a bed {LEAST_HELD:.0%}; take a longer settle_s"
        )
    if speed > MOST_LIVELY * of_fall:
        raise ValueError(
            f"the charge still moves after settling: rms speed {speed:.3g} m/s, a bed has under "
            f"{MOST_LIVELY * of_fall:.3g} m/s, {MOST_LIVELY} of a fall through a ball's radius; "
            "take a longer settle_s"
        )


def in_contact(room: Room, packing: Packing, panels: float, gap: float) -> np.ndarray:
    """Return whether each ball is within a gap of another ball or the liner, (n,) bool.

    Args:
        panels: how much nearer than the liner its panels may be [m].
        gap: [m].
    """
    section = np.ascontiguousarray(packing.centres[:, [0, 2]])
    held = room.liner.nearest(section).distance < packing.radii + panels + gap
    pairs, overlap = overlaps(packing, gap)
    held[pairs[overlap > -gap].ravel()] = True
    if room.closed:
        along = packing.centres[:, 1]
        held |= np.minimum(along, room.length - along) < packing.radii + gap
    return held


def read_bed(path: Path, length: float, closed: bool = False) -> tuple[Packing, np.ndarray]:
    """Return the balls of a dump in a slice of a length [m], and their velocities, (n, 3) float
    [m/s].

    Args:
        closed: between end walls.

    Raises:
        ValueError: the file is no dump with the columns `COLUMNS`.
    """
    with io.TextIOWrapper(open_regular(path), encoding="ascii") as stream:
        header = [next(stream, "") for _ in range(HEADER_LINES)]
        if header[-1].split()[2:] != list(COLUMNS):
            raise ValueError(f"{path}: no dump with the columns {' '.join(COLUMNS)}")
        rows = np.loadtxt(stream, ndmin=2)
    centres = rows[:, :3]
    if not closed:
        # Between rebuilds of its lists the engine lets balls leave the period.
        centres[:, 1] = np.mod(centres[:, 1], length)
    return Packing(centres, rows[:, 6], length, closed), rows[:, 3:6]


def bulk_fraction(room: Room, packing: Packing, random: np.random.Generator) -> float | None:
    """Return the solid fraction in the bulk of a bed; None if the bed is too thin.

    The share of `POINTS` random points that lie in a ball, among points `MARGIN` mean diameters
    inside liner and end walls and as far below the surface: the highest top of the balls within a
    diameter along x. By the definition of a volume; the standard error is under 0.002. Derived
    here.
    """
    centres, radii = packing.centres, packing.radii
    diameter = 2.0 * typical_radius(radii)
    low = centres.min(axis=0) - radii.max()
    high = centres.max(axis=0) + radii.max()
    low[1], high[1] = 0.0, packing.length
    if room.closed:
        low[1], high[1] = MARGIN * diameter, packing.length - MARGIN * diameter
        if low[1] >= high[1]:
            return None
    surface = _surface(packing, low[0], high[0], diameter)
    solid = Solid(packing)
    inside = tested = 0
    for _ in range(BATCHES):
        points = random.uniform(low, high, (POINTS, 3))
        column = ((points[:, 0] - low[0]) / diameter).astype(int)
        points = points[points[:, 2] <= surface[column] - MARGIN * diameter]
        section = np.ascontiguousarray(points[:, [0, 2]])
        points = points[room.liner.nearest(section).distance >= MARGIN * diameter]
        points = points[: POINTS - tested]
        inside += int(solid.covers(points).sum())
        tested += len(points)
        if tested == POINTS:
            break
    return inside / tested if tested >= FEWEST_POINTS else None


def typical_radius(radii: np.ndarray) -> float:
    """Return the mean radius [m]; of several levels of sizes the mean by mass."""
    return float(radii.mean()) if len(size_levels(radii)) == 1 else mean_by_mass(radii)


class Solid:
    """The volume of the balls of a packing, searched level of sizes by level."""

    def __init__(self, packing: Packing) -> None:
        whole, self._origin = periodic_tree(packing)
        self._levels = [
            (cKDTree(whole.data[some], boxsize=whole.boxsize), packing.radii[some])
            for some in size_levels(packing.radii)
        ]

    def covers(self, points: np.ndarray) -> np.ndarray:
        """Return whether points (m, 3) [m] lie in a ball, (m,) bool."""
        held = np.zeros(len(points), bool)
        for tree, radii in self._levels:
            held |= _in_balls(tree, points - self._origin, radii)
        return held


def _surface(packing: Packing, low: float, high: float, width: float) -> np.ndarray:
    """Return the highest top [m] of the balls in a column of x and its neighbours, (n,) float."""
    top = np.full(int((high - low) / width) + 1, -np.inf)
    column = ((packing.centres[:, 0] - low) / width).astype(int)
    np.maximum.at(top, column, packing.centres[:, 2] + packing.radii)
    beside = np.concatenate([[-np.inf], top, [-np.inf]])
    return np.maximum(top, np.maximum(beside[:-2], beside[2:]))


def _in_balls(tree: cKDTree, points: np.ndarray, radii: np.ndarray) -> np.ndarray:
    """Return whether points (m, 3) lie in one of the tree's balls, (m,) bool."""
    if len(points) == 0:
        return np.zeros(0, bool)
    nearest = 1 if np.ptp(radii) == 0.0 else min(CANDIDATES, len(radii))
    distance, ball = tree.query(
        points, k=[*range(1, nearest + 1)], distance_upper_bound=radii.max()
    )
    # A ball out of reach has the index n and an infinite distance.
    return (distance <= np.append(radii, 0.0)[ball]).any(axis=1)
