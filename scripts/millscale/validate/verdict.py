"""Verdict on a run of a hard case: energy error, overlap, spin noise, lost balls."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from millscale.validate.cases import IMPACT, REST, Case, Mill
from millscale.validate.deck import SERIES, Ran
from millscale.validate.scenes import DEEP, Balls

STABLE, INACCURATE, UNSTABLE = "stable", "inaccurate", "unstable"
# The mean kinetic energy of a few hundred balls over a quarter of a second differs by up to 7 %
# between resolved runs (`scatter` of the results): twice that. Of a blow the share of its energy,
# of a bed at rest the share of m g a of each ball.
ENERGY_LIMIT = {"mill": 0.15, IMPACT: 0.05, REST: 1e-3}
# Hertz's law holds for small overlaps only.
OVERLAP_LIMIT = 0.30
# Speed of the surface that changes sign from step to step, over that of a fall by half a radius:
# a tenth of it is felt by Coulomb's limit of a resting contact.
SPIN_LIMIT = 0.10
_COLUMN = {name: k for k, name in enumerate(SERIES)}


@dataclass(frozen=True)
class Measured:
    """One run; the meaning of `energy` depends on the kind of the case."""

    energy: float
    max_overlap: float  # over the smallest radius
    spin_noise: float
    lost: int
    stopped_by: str | None


def measure(case: Case, mill: Mill, balls: Balls, ran: Ran) -> Measured:
    """Return the numbers of a run; NaN for those it did not reach."""
    series, radius = ran.series, mill.radii[-1]
    count = len(balls.radius)
    if not len(series):
        return Measured(np.nan, np.nan, np.nan, 0, ran.stopped_by)
    present = count + (1 if balls.late is not None else 0)
    last = series[-1, _COLUMN["balls"]]
    done = ran.stopped_by is None
    return Measured(
        _energy(case, mill, balls, series) if done else np.nan,
        float(series[:, _COLUMN["overlap"]].max() / radius),
        spin_noise(ran.spins, mill) if done else np.nan,
        int(present - last) if done else max(0, int(count - last)),
        ran.stopped_by,
    )


def _energy(case: Case, mill: Mill, balls: Balls, series: np.ndarray) -> float:
    """Return the energy of a run, by the kind of its case.

    For a mill: the mean kinetic energy of the second half [J]. For an impact: the remaining over
    the initial kinetic energy. For a bed at rest: the remaining kinetic energy over N m g a.
    """
    kinetic = series[:, _COLUMN["translation"]] + series[:, _COLUMN["rotation"]]
    if case.kind == IMPACT:
        return float(kinetic[-1] / energy_put_in(mill, balls))
    if case.kind == REST:
        weight = mass(mill, balls.radius).sum() * mill.gravity * mill.radii[0]
        return float(kinetic[-len(kinetic) // 10 :].max() / weight)
    return float(kinetic[len(kinetic) // 2 :].mean())


def mass(mill: Mill, radius: np.ndarray) -> np.ndarray:
    """Return the masses of balls, (n,) [kg]."""
    return 4.0 / 3.0 * np.pi * mill.density * radius**3


def energy_put_in(mill: Mill, balls: Balls) -> float:
    """Return the kinetic energy of the impact, or the elastic energy of initial overlaps [J]."""
    thrown = balls.late or balls
    kinetic = 0.5 * mass(mill, thrown.radius) @ (thrown.velocity**2).sum(axis=1)
    if kinetic > 0.0:
        return float(kinetic)
    radius = mill.radii[0]
    young = 0.5 * mill.youngs_modulus / (1.0 - mill.poisson_ratio**2)
    each = 8.0 / 15.0 * young * np.sqrt(0.5 * radius) * (DEEP * radius) ** 2.5
    return float(each * _contacts(balls, mill))


def _contacts(balls: Balls, mill: Mill) -> int:
    """Return overlapping pairs, also those across the periodic boundary."""
    separation = balls.position[:, None] - balls.position[None]
    found = 0
    for seam in (-mill.length, 0.0, mill.length):
        distance = np.linalg.norm(separation + np.array([0.0, seam, 0.0]), axis=2)
        found += int(((distance < 1.999 * mill.radii[0]) & (distance > 0.0)).sum())
    return found // 2


def spin_noise(spins: np.ndarray, mill: Mill) -> float:
    """Return the rms of the part of the spins that alternates from step to step, times the ball
    radius, over sqrt(g a). This part is a quarter of the second difference."""
    if len(spins) < 5:
        return float("nan")
    flips = 0.25 * np.diff(spins[2:], n=2, axis=0)  # the first steps follow a set-up
    radius = mill.radii[-1]
    return float(np.sqrt((flips**2).sum(axis=2).mean()) * radius / np.sqrt(mill.gravity * radius))


def energy_error(case: Case, found: Measured, reference: float) -> float:
    """Return the error against the energy at small steps.

    It is relative for a mill, and a fraction of the initial energy for an impact. All remaining
    energy of a bed at rest is error.
    """
    if case.kind == REST:
        return found.energy
    error = abs(found.energy - reference)
    return error if case.kind == IMPACT else error / reference


def verdict(case: Case, found: Measured, error: float) -> str:
    """Return STABLE, INACCURATE or UNSTABLE."""
    if found.stopped_by or found.lost or not np.isfinite(error):
        return UNSTABLE
    limits = (
        error <= ENERGY_LIMIT[case.kind],
        found.max_overlap <= OVERLAP_LIMIT,
        found.spin_noise <= SPIN_LIMIT,
    )
    return STABLE if all(limits) else INACCURATE
