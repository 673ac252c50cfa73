"""Detach angle of a charge: the mean angle at which its balls in flight were thrown.

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

# Columns of compute mill/detach (docs/reference/styles.md): state, time in flight [s], outermost.
STATE, FLIGHT_TIME, OUTERMOST = "c_detach[1]", "c_detach[22]", "c_detach[23]"
FEWEST_BALLS = 12  # as of a curtain


def throw_angle(dump: Dump, case: Case) -> float | None:
    """Return the mean angle from the vertical at which the balls in flight of the outermost layer
    left, positive on the rising side [rad].

    Only flights that began above the axis are throws. Below it, behind the toe, balls that lie
    against a lifter hop for a moment; a few of them at -135 degrees would change the mean. None if
    fewer than FEWEST_BALLS are in such a flight, or the dump lacks a column.
    """
    columns = ("vx", "vz", STATE, FLIGHT_TIME, OUTERMOST)
    if any(name not in dump.columns for name in columns):
        return None
    time = dump[FLIGHT_TIME]
    thrown = (dump[STATE] == IN_FLIGHT) & (time > 0.0) & (dump[OUTERMOST] == 1.0)
    t, fall = time[thrown], 0.5 * case.mill.gravity_m_s2 * time[thrown] ** 2
    x = dump["x"][thrown] - dump["vx"][thrown] * t
    z = dump["z"][thrown] - dump["vz"][thrown] * t - fall
    above = z > 0.0
    return float(np.mean(np.arctan2(-x, z)[above])) if above.sum() >= FEWEST_BALLS else None
