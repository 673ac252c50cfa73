"""Noise of one run: from the scatter between seeds, or between the lifter pitches of a run."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from millscale.analysis.charge.groove_flow import groove_flow_error
from millscale.analysis.charge.result import ChargeScales, charge_scales
from millscale.analysis.charge.steady import FEWEST_PITCHES, Window, standard_error
from millscale.analysis.finished import Charge
from millscale.prediction.extrapolation import Group, Noise, pooled_noise
from millscale.runs.series import Series

# Fewer degrees of freedom make Student's factor so wide that the scatter of the pitches is better.
FEWEST_SEED_FREEDOM = 2
SEEDS, PITCHES = "seeds", "lifter pitches"

_Column = Callable[[Series, ChargeScales], np.ndarray]
# Dimensionless columns of series.csv by the name of the observable whose mean they are; of toe and
# shoulder the ends of the bed along the wall, which vary as those of its surface do.
_COLUMNS: dict[str, _Column] = {
    "kinetic": lambda series, scales: series["kinetic_translation_J"] / scales.energy,
    "kinetic_rotation": lambda series, scales: series["kinetic_rotation_J"] / scales.energy,
    "centre_x": lambda series, scales: series["centre_x_m"] / scales.length,
    "centre_z": lambda series, scales: series["centre_z_m"] / scales.length,
    "flying_share": lambda series, _: series["balls_in_flight"] / series["balls"],
    "toe_angle_rad": lambda series, _: series["toe_angle_rad"],
    "shoulder_angle_rad": lambda series, _: series["shoulder_angle_rad"],
}
ENDS = frozenset({"toe_angle_rad", "shoulder_angle_rad"})
# Torque and power are work over angle: the same dimensionless number in a steady mill.
_OF_WORK = frozenset({"power", "torque"})
WITH_PITCHES = _OF_WORK | _COLUMNS.keys() | {"mass_flow"}


def noise_of(
    name: str, groups: Sequence[Group], charges: Sequence[Charge]
) -> tuple[Noise | None, str]:
    """Return the noise of one run of an observable, and what it was found from.

    From the seeds where they have degrees of freedom enough; else from the lifter pitches of all
    runs, where series.csv has the observable; else None.
    """
    freedom = sum(len(group.values) - 1 for group in groups)
    if freedom >= FEWEST_SEED_FREEDOM:
        return pooled_noise(groups), SEEDS
    if of_pitches := pitch_noise(name, charges):
        return of_pitches, PITCHES
    return (pooled_noise(groups), SEEDS) if freedom else (None, "")


def pitch_noise(name: str, charges: Sequence[Charge]) -> Noise | None:
    """Return the noise of one run from the lifter pitches of all; None if a run has none."""
    errors = [pitch_error(charge, name) for charge in charges]
    known = [error for error in errors if error is not None]
    if not known or len(known) < len(charges):
        return None
    count = sum(charge.result.pitches - 1 for charge in charges)
    return Noise(math.sqrt(math.fsum(error**2 for error in known) / len(known)), float(count))


def pitch_error(charge: Charge, name: str) -> float | None:
    """Return the standard error of an observable's mean from the scatter of the lifter pitches.

    Accounts for the correlation of successive pitches (`steady.standard_error`). None without
    enough pitches or without a column of it.
    """
    result, series = charge.result, charge.series
    if name not in WITH_PITCHES or result.pitches < FEWEST_PITCHES:
        return None
    if name == "mass_flow":
        return groove_flow_error(charge)
    edges = np.linspace(result.mean_from_rad, result.mean_to_rad, result.pitches + 1)
    angle, scales = series["mill_angle_rad"], charge_scales(charge.case, series)
    if name in _OF_WORK:
        work = np.interp(edges, angle, series["drive_work_J"])
        return standard_error(np.diff(work) / np.diff(edges) / scales.torque)
    if name in ENDS and not charge.has(name):
        return None
    window = Window(result.mean_from_rad, result.mean_to_rad, edges)
    return standard_error(window.pitch_means(angle, _COLUMNS[name](series, scales)))
