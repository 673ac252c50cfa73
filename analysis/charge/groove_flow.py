"""Mass in the monitoring box by phase of a lifter pitch, and the mass flow in the grooves.

The balls between the lifters move with the mill, so the mass that the grooves carry past the box
each second is m omega / theta, m the mean mass in the box and theta the angle of the box. Derived
here; a layer that slips on the liner carries less.
"""

from __future__ import annotations

import numpy as np

from millscale.analysis.charge.steady import FEWEST_PITCHES, Window, standard_error
from millscale.analysis.finished import Charge
from millscale.analysis.shapes.cross_section import groove_box
from millscale.analysis.shapes.mass_flow import FRAMES
from millscale.runs.case_file import Case

COLUMN = FRAMES["fixed"]
# Phases of a lifter pitch.
PHASES = 20


def box_angle(case: Case) -> float | None:
    """Return the angle of the monitoring box [rad]; None in a plain drum.

    It is the angle of the sector between liner and lifter tops that is as large as the box.
    """
    corners = groove_box(case)
    if corners is None:
        return None
    x, z = corners.T
    area = 0.5 * abs(float(x @ np.roll(z, -1) - z @ np.roll(x, -1)))
    mill = case.mill
    return 2.0 * area / (mill.radius_m**2 - mill.lifter_top_radius_m**2)


def groove_flow(charge: Charge) -> float | None:
    """Return the mass flow in the grooves at the bottom over M omega; None without a box."""
    angle = box_angle(charge.case)
    masses = pitch_masses(charge)
    if angle is None or masses is None:
        return None
    return float(masses.mean()) / angle


def groove_flow_error(charge: Charge) -> float | None:
    """Return the standard error of `groove_flow` from the scatter of the lifter pitches."""
    angle = box_angle(charge.case)
    masses = pitch_masses(charge)
    return None if angle is None or masses is None else standard_error(masses.mean(axis=1)) / angle


def pitch_masses(charge: Charge) -> np.ndarray | None:
    """Return the share of the charge in the box, (pitches, `PHASES`) float; None without a box or
    enough pitches."""
    result = charge.result
    if not charge.has(COLUMN) or result.pitches < FEWEST_PITCHES:
        return None
    edges = np.linspace(result.mean_from_rad, result.mean_to_rad, result.pitches * PHASES + 1)
    window = Window(result.mean_from_rad, result.mean_to_rad, edges)
    series = charge.series
    means = window.pitch_means(series["mill_angle_rad"], series[COLUMN])
    return means.reshape(result.pitches, PHASES)
