"""What was measured on a mill, and the same of a simulated charge."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from millscale.analysis.charge.measured import measure
from millscale.analysis.charge.physical_mill import balls_per_length, physical_mill, physical_power
from millscale.analysis.finished import Charge
from millscale.analysis.measures import NUMBERS, Quantity, Taken
from millscale.analysis.shapes.snapshots import snapshots_of
from millscale.campaign.keys import REQUIRED, Key
from millscale.campaign.reader import read_section, read_text
from millscale.campaign.spellings import spelling_of
from millscale.errors import CampaignError
from millscale.prediction.contour import displacements, mean_contour
from millscale.prediction.noise import WITH_PITCHES, pitch_error
from millscale.runs.dumps import read_dump

MOST_POINTS = 500
_QUANTITIES = {quantity.name: quantity for quantity in NUMBERS}


def _number(label: str, unit: str = "") -> Key:
    return Key("number", f"{label} [{unit}]" if unit else label)


def _of_quantity(name: str) -> tuple[str, Key]:
    quantity = _QUANTITIES[name]
    key = name.replace("_angle_rad", "_rad")
    return key, _number(quantity.label, "rad" if quantity.unit == "deg" else "")


# Of dimensionless numbers the names in result.json; angles are counted as docs/theory has them.
_FROM_RESULT = ("torque", "power", "kinetic", "centre_x", "centre_z", "flying_share")
_FROM_SHAPE = ("toe_angle_rad", "shoulder_angle_rad", "solid_fraction", "mixing_index")
_BY_KEY = {_of_quantity(name)[0]: name for name in (*_FROM_RESULT, *_FROM_SHAPE)}
NUMBER_KEYS = {
    "power_w": _number("power of the mill", "W"),
    "torque_nm": _number("torque of the mill", "N m"),
    **dict(_of_quantity(name) for name in (*_FROM_RESULT, *_FROM_SHAPE)),
}
PROFILE_KEYS = {
    "surface": Key("text", "table x_m, z_m of points on the free surface, .csv"),
    "velocity": Key("text", "table distance_m, velocity_m_s along a line through the axis, .csv"),
}
TARGET_KEYS = {
    **NUMBER_KEYS,
    **PROFILE_KEYS,
    "uncertainty": Key(
        "number", "standard deviation, in the unit of the number; of profiles in m or m/s",
        REQUIRED, above=0.0,
    ),
    "experiment": Key("text", "name of the experiment, if there are several"),
    "slope_deg": Key(
        "number", "velocity: angle of the surface; the line is its normal", least=-90.0, most=90.0
    ),
    "within_m": Key(
        "number", "velocity: balls as near to a point count; default: a ball diameter", above=0.0
    ),
    "correlated_points": Key(
        "number", "of a profile: neighbouring points that share one error", 1.0, least=1.0
    ),
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class Target:
    """Something measured.

    Attributes:
        name: with the name of the experiment if there are several.
        experiment: empty if there is only one.
        label, unit: of the number, or of each point of a profile; factor: shown over SI.
        measured: (p,) float, SI units or dimensionless.
        uncertainty: standard deviation of each of them.
        simulated: returns the same of a charge, (p,) float, nan where it has none.
        noise: returns the standard error of a charge's number from the scatter of its lifter
            pitches; None if it is not known.
        abscissa: (p,) float, where the points of a profile lie [m]; None for a number.
        shared: points of a profile that share one error.
    """

    name: str
    experiment: str
    label: str
    unit: str
    factor: float
    measured: np.ndarray
    uncertainty: float
    simulated: Callable[[Charge], np.ndarray]
    noise: Callable[[Charge], float | None]
    abscissa: np.ndarray | None = None
    shared: float = 1.0

    def differences(self, simulated: np.ndarray) -> np.ndarray:
        """Return simulated less measured over the uncertainty, (p,) float."""
        return (simulated - self.measured) / (self.uncertainty * math.sqrt(self.shared))

    def text(self, value: float) -> str:
        """Return a number as it is shown."""
        return f"{self.factor * value:.4g}"


def target_of(
    path: Path, where: str, entry: Mapping[str, Any], experiments: Sequence[str]
) -> Target:
    """Return the target of an entry of a calibration file.

    Args:
        experiments: names of the experiments; one empty name if there is only one.

    Raises:
        CampaignError: not exactly one quantity, an unknown experiment, or a wrong profile.
    """
    values = read_section(path, where, entry, TARGET_KEYS)
    given = [key for key in (*NUMBER_KEYS, *PROFILE_KEYS) if values[key] is not None]
    if len(given) != 1:
        cause = f"got {', '.join(given) or 'none'}"
        raise CampaignError(
            path, where, cause, "one of " + ", ".join((*NUMBER_KEYS, *PROFILE_KEYS))
        )
    (key,) = given
    experiment = values["experiment"] or ""
    if experiment not in experiments:
        got = f'got "{experiment}"' if experiment else "missing"
        accepted = ", ".join(experiments) if experiments != [""] else "no experiment: there is one"
        raise CampaignError(path, f"{where}.experiment", got, accepted)
    if key in PROFILE_KEYS:
        target = _profile(path, where, key, values)
    else:
        target = _plain(key, values[key], values["uncertainty"] * _unit_of(key, entry))
    name = target.name + (f" ({experiment})" if experiment else "")
    return replace(target, name=name, experiment=experiment)


def _unit_of(key: str, entry: Mapping[str, Any]) -> float:
    """Return the unit in which an entry states a number, over that of its declared key."""
    words = (spelling_of(word, NUMBER_KEYS) for word in entry)
    spelt = [one for one in words if one is not None and one.canonical == key]
    return spelt[0].numerator / spelt[0].denominator if spelt and key not in entry else 1.0


def _plain(key: str, value: float, uncertainty: float) -> Target:
    """Return the target of a number."""
    if key == "power_w":
        return _of_charge(key, "power", "W", value, uncertainty, physical_power, "power")
    if key == "torque_nm":
        return _of_charge(key, "torque", "N m", value, uncertainty, _physical_torque, "torque")
    quantity = _QUANTITIES[_BY_KEY[key]]

    def read(charge: Charge) -> float | None:
        return number_of(charge, quantity)

    made = _of_charge(key, quantity.label, quantity.unit, value, uncertainty, read, quantity.name)
    return replace(made, factor=quantity.factor)


def _of_charge(
    key: str,
    label: str,
    unit: str,
    value: float,
    uncertainty: float,
    read: Callable[[Charge], float | None],
    noisy: str,
) -> Target:
    def simulated(charge: Charge) -> np.ndarray:
        found = read(charge)
        return np.array([math.nan if found is None else found])

    def noise(charge: Charge) -> float | None:
        error = pitch_error(charge, noisy) if noisy in WITH_PITCHES else None
        scale = {"power_w": _power_scale, "torque_nm": _torque_scale}.get(key)
        return error * scale(charge) if error is not None and scale else error

    name = key.removesuffix("_rad").removesuffix("_w").removesuffix("_nm").replace("_", " ")
    if key in ("power", "torque"):
        name = f"{name} number"
    return Target(name, "", label, unit, 1.0, np.array([value]), uncertainty, simulated, noise)


def number_of(charge: Charge, quantity: Quantity) -> float | None:
    """Return a number of a charge; reads its dumps only if the number is of these."""
    if quantity.taken is Taken.ONCE:
        value = quantity.read(charge)
        return None if value is None else float(value)
    return measure([charge], []).numbers[charge][quantity.name]


def _power_scale(charge: Charge) -> float:
    return physical_mill(charge.case, balls_per_length(charge.case)).power_scale


def _torque_scale(charge: Charge) -> float:
    return physical_mill(charge.case, balls_per_length(charge.case)).torque_scale


def _physical_torque(charge: Charge) -> float:
    """Return the torque of the physical mill and its whole charge [N m]."""
    return _torque_scale(charge) * charge.result.dimensionless["torque"]


def _profile(path: Path, where: str, key: str, values: Mapping[str, Any]) -> Target:
    file = path.parent / values[key]
    if key == "surface":
        points = read_table(file, ("x_m", "z_m"))
        places = np.append(0.0, np.cumsum(np.hypot(*np.diff(points, axis=0).T)))

        def simulated(charge: Charge) -> np.ndarray:
            return surface_distances(charge, points)

        measured, label, unit = np.zeros(len(points)), "surface", "m"
    else:
        if values["slope_deg"] is None:
            raise CampaignError(path, f"{where}.slope_deg", "missing", "the angle of the surface")
        table = read_table(file, ("distance_m", "velocity_m_s"))
        places, measured, label, unit = table[:, 0], table[:, 1], "velocity", "m/s"
        slope, within = math.radians(values["slope_deg"]), values["within_m"]

        def simulated(charge: Charge) -> np.ndarray:
            return velocities(charge, places, slope, within)

    return Target(
        label, "", label, unit, 1.0, measured, values["uncertainty"], simulated, _unknown, places,
        values["correlated_points"],
    )  # fmt: skip


def _unknown(charge: Charge) -> None:
    return None


def read_table(file: Path, columns: tuple[str, str]) -> np.ndarray:
    """Return two columns of a table of a measured profile, (n, 2) float; `#` begins a comment.

    Raises:
        CampaignError: not such a table, or fewer than three points.
    """
    accepted = f"a first line {', '.join(columns)} and 3 to {MOST_POINTS} lines of numbers"
    lines = [line for line in read_text(file).splitlines() if line.strip() and line[0] != "#"]
    rows = list(csv.DictReader(io.StringIO("\n".join(lines)), skipinitialspace=True))
    if not 3 <= len(rows) <= MOST_POINTS:
        raise CampaignError(file, "", f"{len(rows)} points", accepted)
    missing = [name for name in columns if name not in rows[0]]
    if missing:
        raise CampaignError(file, "", f"no column {', '.join(missing)}", accepted)
    try:
        found = np.array([[float(row[name]) for name in columns] for row in rows])
    except (TypeError, ValueError) as error:
        raise CampaignError(file, "", str(error), accepted) from None
    if not np.isfinite(found).all():
        raise CampaignError(file, "", "a number is not finite", accepted)
    return found


def surface_distances(charge: Charge, points: np.ndarray) -> np.ndarray:
    """Return how far the surface of a charge lies from measured points [m], (n,) float; nan if it
    does not cross the normal there.

    The surface is the contour of the mean solid fraction. Distances are along the normals of the
    line through the points, in the physical mill.

    Args:
        points: (n, 2) float [x, z], of the physical mill [m], in order along the surface.
    """
    physical = charge.case.physical
    unit = physical.radius_m - physical.ball_radius_m
    tangents = np.gradient(points, axis=0)
    tangents /= np.linalg.norm(tangents, axis=1)[:, None]
    normals = np.column_stack([-tangents[:, 1], tangents[:, 0]])
    return unit * displacements(points / unit, normals, mean_contour(charge))


def velocities(
    charge: Charge, distances: np.ndarray, slope: float, within: float | None = None
) -> np.ndarray:
    """Return the mean velocity down a slope at points on its normal through the axis [m/s], (n,)
    float, in the physical mill; nan where there were no balls.

    The mean is over all dumps of the steady part of the rotation.

    Args:
        distances: (n,) float, of the points from the axis, negative towards the bed [m].
        slope: angle of the surface, which falls towards +x [rad].
        within: distance from a point at which a ball counts [m]; a ball diameter by default.
    """
    case, result = charge.case, charge.result
    length, time = case.factors.length, case.factors.time
    reach = within if within is not None else 2.0 * case.ball.radius_m / length
    sums, counts = np.zeros(len(distances)), np.zeros(len(distances))
    for snapshot in snapshots_of(charge.folder):
        if not result.mean_from_rad <= snapshot.mill_angle <= result.mean_to_rad:
            continue
        dump = read_dump(snapshot.path)
        x, z = dump["x"] / length, dump["z"] / length
        down = (dump["vx"] * math.cos(slope) - dump["vz"] * math.sin(slope)) * time / length
        along = x * math.cos(slope) - z * math.sin(slope)
        across = x * math.sin(slope) + z * math.cos(slope)
        near = (along[:, None] ** 2 + (across[:, None] - distances) ** 2) < reach**2
        sums += down @ near
        counts += near.sum(axis=0)
    return np.where(counts > 0.0, sums / np.maximum(counts, 1.0), np.nan)


__all__ = ["TARGET_KEYS", "Target", "number_of", "read_table", "target_of"]
