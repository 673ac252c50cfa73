"""Where thrown balls land: the angle at which their parabola meets the circle of the toe.

A ball in flight has no contact, so its path follows from position and velocity. Balls that land
beyond the toe hit the bare liner; those short of it fall on the charge. Derived here. Air drag and
collisions in flight are not modelled.
"""

from __future__ import annotations

import numpy as np

from millscale.analysis.shapes.throw_angle import COLUMNS, FEWEST_BALLS, launch_points
from millscale.runs.case_file import Case
from millscale.runs.dumps import Dump

# Samples of a flight, between which the crossing of the circle is interpolated.
_SAMPLES = 400


def landing_angle(dump: Dump, case: Case, radius: float) -> float | None:
    """Return the median angle at which thrown balls meet a circle, as toe angles are counted: from
    the vertical, down the rising side and through the bottom [rad].

    The balls are those of `throw_angle.throw_angle`. None if fewer than FEWEST_BALLS were thrown,
    or the dump lacks a column.

    Args:
        radius: of the circle about the axis [m].
    """
    if any(name not in dump.columns for name in COLUMNS):
        return None
    flying, launch = launch_points(dump, case)
    thrown = (launch[:, 1] > 0.0) & (np.hypot(*launch.T) > radius)
    if thrown.sum() < FEWEST_BALLS:
        return None
    now = np.column_stack([dump[name][flying][thrown] for name in ("x", "z", "vx", "vz")])
    angles = landing_angles(now, case.mill.gravity_m_s2, radius)
    known = angles[np.isfinite(angles)]
    return float(np.median(known)) if len(known) >= FEWEST_BALLS else None


def landing_angles(now: np.ndarray, gravity: float, radius: float) -> np.ndarray:
    """Return the angles in [0, 2 pi) at which balls in flight leave a circle, (n,) float [rad]; nan
    where a ball does not pass through it.

    Args:
        now: x, z, vx, vz of each ball, (n, 4) float [m, m/s].
        gravity: downwards along z [m/s^2].
        radius: of the circle about the axis [m].
    """
    x, z, vx, vz = now.T
    # Until the ball is a radius below the axis, where it is outside the circle for good.
    end = (vz + np.sqrt(np.maximum(vz**2 + 2.0 * gravity * (z + radius), 0.0))) / gravity
    t = end[:, None] * np.linspace(0.0, 1.0, _SAMPLES)
    path_x, path_z = x[:, None] + vx[:, None] * t, z[:, None] + vz[:, None] * t - gravity / 2 * t**2
    beyond = np.hypot(path_x, path_z) - radius
    leaves = (beyond[:, :-1] < 0.0) & (beyond[:, 1:] >= 0.0)
    rows = np.arange(len(now))
    last = leaves.shape[1] - 1 - np.argmax(leaves[:, ::-1], axis=1)
    low, high = beyond[rows, last], beyond[rows, last + 1]
    share = np.where(leaves.any(axis=1), -low / np.where(high == low, 1.0, high - low), np.nan)
    land_x, land_z = (
        path[rows, last] + share * (path[rows, last + 1] - path[rows, last])
        for path in (path_x, path_z)
    )
    return np.arctan2(-land_x, land_z) % (2.0 * np.pi)
