"""The load of a lifter over a revolution, as a strain gauge on it sees, and its toe and shoulder.

Derived here; docs/theory/liner-wear.md.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from millscale.analysis.wear.loads import LinerLoads
from millscale.runs.case_file import Case
from millscale.runs.liner import liner_of


@dataclass(frozen=True)
class LifterLoad:
    """Mean force of the balls on a lifter by its place, per length of the mill.

    Attributes:
        lifter: of the sector.
        angle: (places,) float, of the lifter's middle from the vertical, in (-pi, pi], in the order
            of the rotation [rad].
        along: (places,) float, force against the rotation, along the circumference [N/m].
        outward: (places,) float, force away from the axis [N/m].
        toe, shoulder: between which the force is high, as angles of `SurfaceEnds`; None without a
            force [rad].
    """

    lifter: int
    angle: np.ndarray
    along: np.ndarray
    outward: np.ndarray
    toe: float | None
    shoulder: float | None

    @property
    def size(self) -> np.ndarray:
        """Return the size of the force, (places,) float [N/m]."""
        return np.hypot(self.along, self.outward)


def lifter_loads(loads: LinerLoads, case: Case) -> tuple[LifterLoad, ...]:
    """Return the load of each lifter of a sector; none of a liner without lifters."""
    if not (loads.bins.faces != "groove").any():
        return ()
    liner = liner_of(case.mill)
    per_sector = len(liner.lifter_angles) // liner.sectors
    return tuple(_lifter_load(loads, case, k, per_sector) for k in range(per_sector))


def _lifter_load(loads: LinerLoads, case: Case, lifter: int, per_sector: int) -> LifterLoad:
    """Return the load of a lifter. A piece of it may belong to a sector beside its own, j sectors
    away; it is then in the place of that sector."""
    liner = liner_of(case.mill)
    offset = _wrapped(float(liner.lifter_angles[lifter]) - liner.phase)
    bins, steps = loads.bins, len(loads.places) // liner.sectors
    into, onward = loads.rates("normal_impulse_Ns"), loads.rates("tangential_impulse_Ns")
    force = np.zeros((len(loads.places), 2))
    of_lifter = bins.lifters - lifter
    for j in range(-2, 3):
        own = (bins.faces != "groove") & (of_lifter == j * per_sector)
        # Radial and tangential in the frame of the sector's centre line, then of the lifter.
        there = onward[:, own] @ bins.tangents[own] - into[:, own] @ bins.normals[own]
        c, s = np.cos(offset + j * liner.pitch), np.sin(offset + j * liner.pitch)
        turned = there @ np.array([[c, -s], [s, c]])
        force += np.roll(turned, j * steps, axis=0)
    length = case.mill.simulated_length_m
    angle = _wrapped(np.pi - (loads.places + offset))
    along, outward = -force[:, 1] / length, force[:, 0] / length
    toe, shoulder = _ends(angle, np.hypot(along, outward))
    return LifterLoad(lifter, angle, along, outward, toe, shoulder)


def _wrapped(angle: Any) -> Any:
    """Return an angle, or an array of angles, in (-pi, pi] [rad]."""
    return np.pi - (np.pi - angle) % (2.0 * np.pi)


def _ends(angle: np.ndarray, force: np.ndarray) -> tuple[float | None, float | None]:
    """Return toe and shoulder by a force at places in the order of the rotation."""
    arc = high_arc(force)
    if arc is None:
        return None, None
    first, count = arc
    half = np.pi / len(angle)
    # The angle from the vertical falls as the mill turns.
    shoulder = _wrapped(float(angle[(first + count - 1) % len(angle)]) - half)
    return shoulder + 2.0 * half * count, shoulder


def high_arc(values: np.ndarray) -> tuple[int, int] | None:
    """Return the first place and the number of places of the arc with the high level of the
    two-level step that fits the values on a circle best, in the sense of least squares; None if all
    are equal.

    As `bed_arc` in `core/measure`, which finds the bed by the balls at the wall.

    Args:
        values: (n,) float.
    """
    n = len(values)
    deviation = values - values.mean()
    below = np.concatenate([[0.0], np.cumsum(np.tile(deviation, 2))])
    best, arc = 1e-24 * float(values @ values), None
    for count in range(1, n):
        inside = below[count : count + n] - below[:n]
        first = int(np.argmax(inside))
        explained = inside[first] ** 2 * n / (count * (n - count))
        if inside[first] > 0.0 and explained > best:
            best, arc = explained, (first, count)
    return arc
