"""Throw angle of a charge: the median angle at which its balls in flight were thrown.

A ball in flight has no contact, so position and velocity give the position at which its flight
began:

    r0 = r - v t + g t^2 / 2,    t the time in flight, g downwards along z

Derived here. Air drag is not modelled. The dump's six digits leave 1e-5 of r and of v t.
"""

from __future__ import annotations

import numpy as np

from millscale.analysis.shapes.curtain import IN_FLIGHT
from millscale.runs.case_file import Case
from millscale.runs.dumps import Dump

# Columns of compute mill/detach: state, time in flight [s];
# docs/reference/styles/compute-mill-detach.md.
STATE, FLIGHT_TIME = "c_detach[1]", "c_detach[22]"
COLUMNS = ("vx", "vz", STATE, FLIGHT_TIME)
FEWEST_BALLS = 12  # as of a curtain


def launch_points(dump: Dump, case: Case) -> tuple[np.ndarray, np.ndarray]:
    """Return which balls are in a confirmed flight, (n,) bool, and the points [x, z] at which these
    flights began, (m, 2) float [m]."""
    time = dump[FLIGHT_TIME]
    flying = (dump[STATE] == IN_FLIGHT) & (time > 0.0)
    t, fall = time[flying], 0.5 * case.mill.gravity_m_s2 * time[flying] ** 2
    x = dump["x"][flying] - dump["vx"][flying] * t
    z = dump["z"][flying] - dump["vz"][flying] * t - fall
    return flying, np.column_stack([x, z])


def throw_angle(dump: Dump, case: Case, radius: float) -> float | None:
    """Return the median angle from the vertical at which the balls in flight left, positive on the
    rising side [rad].

    Only flights that began above the axis and outside a circle are throws: those of balls that a
    lifter carried. Inside the circle balls roll down the surface, and hop. Below the axis, behind
    the toe, balls that lie against a lifter hop. All layers of the charge count: the layer next to
    the liner is a different share of the charge at every S. None if fewer than FEWEST_BALLS are in
    such a flight, or the dump lacks a column.

    Args:
        radius: of the circle about the axis [m].
    """
    if any(name not in dump.columns for name in COLUMNS):
        return None
    x, z = launch_points(dump, case)[1].T
    thrown = (z > 0.0) & (np.hypot(x, z) > radius)
    return float(np.median(np.arctan2(-x, z)[thrown])) if thrown.sum() >= FEWEST_BALLS else None
