"""Mean velocity of a charge over its cross-section, from dumps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from millscale.analysis.shapes.solid_fraction import HALF_WIDTH
from millscale.runs.case_file import Case
from millscale.runs.dumps import Dump

CELL = 0.04  # smallest width over R - a
CELL_OVER_BALL_RADIUS = 3.0
# Balls of all dumps in a cell: the mean of fewer is that of single balls.
FEWEST_BALLS = 3
COLUMNS = ("vx", "vz")


@dataclass(frozen=True)
class VelocityField:
    """Balls and their momentum in square cells of the cross-section, summed over dumps.

    Attributes:
        edges: (n + 1,) float, of the cells along x and z, over R - a.
        balls: (n, n) float [z, x].
        mass: (n, n) float [kg].
        momentum: (2, n, n) float, of x and z, [kg] times omega R.
    """

    edges: np.ndarray
    balls: np.ndarray
    mass: np.ndarray
    momentum: np.ndarray

    def __add__(self, other: VelocityField) -> VelocityField:
        return VelocityField(
            self.edges,
            self.balls + other.balls,
            self.mass + other.mass,
            self.momentum + other.momentum,
        )

    @property
    def middles(self) -> np.ndarray:
        """Return the middles of the cells along each axis over R - a, (n,) float."""
        return 0.5 * (self.edges[1:] + self.edges[:-1])

    @property
    def velocity(self) -> np.ndarray:
        """Return the mean velocity over omega R, weighted by mass, (2, n, n) float; NaN in cells of
        fewer than FEWEST_BALLS."""
        known = self.balls >= FEWEST_BALLS
        return np.where(known, self.momentum / np.where(known, self.mass, 1.0), np.nan)

    @property
    def speed(self) -> np.ndarray:
        """Return the size of the mean velocity over omega R, (n, n) float."""
        return np.hypot(*self.velocity)


def velocity_field(dump: Dump, case: Case) -> VelocityField | None:
    """Return the velocity field of one dump; None if it has no velocities."""
    if any(name not in dump.columns for name in COLUMNS):
        return None
    mill, radius = case.mill, case.ball.radius_m
    unit = mill.radius_m - radius
    width = max(CELL, CELL_OVER_BALL_RADIUS * radius / unit)
    count = int(np.ceil(2.0 * HALF_WIDTH / width))
    edges = np.linspace(-HALF_WIDTH, HALF_WIDTH, count + 1)
    column, row = (
        np.clip(np.searchsorted(edges, dump[axis] / unit) - 1, 0, count - 1) for axis in "xz"
    )
    mass = _mass(dump, case)

    def summed(weights: np.ndarray | None = None) -> np.ndarray:
        total = np.bincount(row * count + column, weights, count * count)
        return total.reshape(count, count).astype(float)

    scale = mill.omega_rad_s * mill.radius_m
    momentum = np.stack([summed(mass * dump[name] / scale) for name in COLUMNS])
    return VelocityField(edges, summed(), summed(mass), momentum)


def _mass(dump: Dump, case: Case) -> np.ndarray:
    """Return the mass of each ball [kg]; of several densities by its class."""
    ball = case.ball
    density = np.full(len(dump), ball.density_kg_m3)
    if ball.classes and "type" in dump.columns:
        kinds = dump["type"].astype(int) - 1
        for kind, one in enumerate(ball.classes):
            density[kinds == kind] = one.density_kg_m3
    return density * 4.0 / 3.0 * np.pi * dump["radius"] ** 3
