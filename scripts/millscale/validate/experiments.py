"""Published measurements beside runs: `millscale validate experiments`.

A row of `drums` is a charge of the drum of Alizadeh et al. with its velocities at the measured
points. A row of `throws` is a single ball with the impacts of its throws. Both are given for the
physical mill: lengths and times are divided by the factors of the law.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from millscale.analysis.finished import Charge, SingleBall
from millscale.analysis.shapes.snapshots import snapshots_of
from millscale.analysis.single_ball.flight import Release, impact_speed_ratio
from millscale.runs.case_file import Case
from millscale.runs.dumps import Dump, read_dump
from millscale.runs.untrusted import RunFolderError

Row = dict[str, Any]
MEASURED = Path("campaigns/experiments/drum-240-mm.csv")
COLUMNS = ("distance_from_axis_m", "velocity_m_s")
# Of the drum: how far the free surface is tilted, by the source; how far from a measured point a
# ball counts [m]; and from the middle of the drum, so that the ends are left out [m].
SURFACE = math.radians(27.0)
NEAR, MIDDLE = 3e-3, 0.1
# Speed of the drum [rad/s], and the distance from the axis beyond which the bed turns with it [m].
OMEGA, NEAR_WALL = math.pi * 11.6 / 30.0, 0.09
# A mean of fewer balls is none: the standard error would be that of the profile's own range.
FEWEST = 30


@dataclass(frozen=True)
class Profile:
    """Velocity down the slope against the distance from the axis along the surface's normal.

    Attributes:
        distance: (n,) float, negative below the axis [m].
        velocity: (n,) float [m/s]; nan where it is not known.
    """

    distance: np.ndarray
    velocity: np.ndarray

    def rms_from(self, measured: Profile, deeper: float = 0.0) -> float | None:
        """Return the root mean square difference from velocities at the same distances [m/s].

        Args:
            deeper: only points that are farther below the axis [m].
        """
        difference = self.velocity - measured.velocity
        known = np.isfinite(difference) & (self.distance < -deeper)
        return float(np.sqrt(np.mean(difference[known] ** 2))) if known.any() else None

    def over_rigid(self, omega: float) -> float | None:
        """Return the mean velocity of the points beyond `NEAR_WALL` over that of a bed that turns
        with the drum [rad/s]; None without such points."""
        deep = np.isfinite(self.velocity) & (self.distance < -NEAR_WALL)
        if not deep.any():
            return None
        return float(np.mean(self.velocity[deep] / (omega * self.distance[deep])))

    def zero(self) -> float | None:
        """Return the distance below the axis at which the velocity first changes its sign, from the
        surface on [m]; None without a change."""
        known = np.isfinite(self.velocity)
        order = np.argsort(-self.distance[known])
        y, u = self.distance[known][order], self.velocity[known][order]
        change = np.flatnonzero((u[:-1] > 0.0) & (u[1:] <= 0.0))
        if not change.size:
            return None
        i = change[0]
        return float(-(y[i] + (y[i + 1] - y[i]) * u[i] / (u[i] - u[i + 1])))


def read_profile(file: Path) -> Profile:
    """Return a measured profile; lines that begin with # are comments.

    Raises:
        RunFolderError: no such file, other columns, or a value that is no number.
    """
    remedy = f"give the file {MEASURED}"
    try:
        lines = [x for x in file.read_text(encoding="utf-8").splitlines() if not x.startswith("#")]
        rows = list(csv.DictReader(lines))
        distance, velocity = (np.array([float(row[name]) for row in rows]) for name in COLUMNS)
    except (OSError, KeyError, TypeError, ValueError) as error:
        cause = f"not a table of {' and '.join(COLUMNS)}: {error}"
        raise RunFolderError(file, cause, remedy) from None
    if len(rows) < 2:
        raise RunFolderError(file, f"{len(rows)} rows, at least 2 are needed", remedy)
    return Profile(distance, velocity)


def to_physical(case: Case) -> tuple[float, float]:
    """Return the physical mill's length and time over those of a case."""
    return 1.0 / case.factors.length, 1.0 / case.factors.time


def profile_of(
    dumps: Iterable[Dump], case: Case, distance: np.ndarray
) -> tuple[np.ndarray, Profile]:
    """Return the velocities of the physical drum near points on the normal of the surface.

    A velocity is the mean over the balls whose centre is within `NEAR` of a point and `MIDDLE` of
    the middle of the drum. The charge is lifted at x < 0.

    Args:
        distance: (n,) float of the points, negative below the axis [m].

    Returns:
        The number of balls of each point, (n,) int, and the profile.
    """
    length, time = to_physical(case)
    sums, counts = np.zeros(len(distance)), np.zeros(len(distance), int)
    cosine, sine = math.cos(SURFACE), math.sin(SURFACE)
    for dump in dumps:
        in_middle = np.abs(length * (dump["y"] - 0.5 * case.mill.simulated_length_m)) < MIDDLE
        x, z, vx, vz = (length * dump[name][in_middle] for name in ("x", "z", "vx", "vz"))
        down = (cosine * vx - sine * vz) / time
        along, across = cosine * x - sine * z, sine * x + cosine * z
        for i, y in enumerate(distance):
            near = along**2 + (across - y) ** 2 < NEAR**2
            sums[i] += down[near].sum()
            counts[i] += int(near.sum())
    velocity = np.where(counts >= FEWEST, sums / np.maximum(counts, 1), np.nan)
    return counts, Profile(distance, velocity)


def drum_row(charge: Charge, measured: Profile) -> Row:
    """Return the row of a charge of the measured drum: settings, state and profile."""
    case, result = charge.case, charge.result
    dumps = [
        read_dump(snapshot.path)
        for snapshot in snapshots_of(charge.folder)
        if result.mean_from_rad <= snapshot.mill_angle <= result.mean_to_rad
    ]
    if not dumps:
        cause = "no dumps in the window of the means"
        raise RunFolderError(charge.folder, cause, "run the case again with dump_angle_rad = 0.1")
    counts, profile = profile_of(dumps, case, measured.distance)
    material = case.material
    return {
        **state_row(charge),
        "ends": case.mill.ends,
        **{
            name: getattr(material, name)
            for name in (
                *("rolling_friction_pp", "rolling_friction_pw"),
                *("static_friction_pp", "static_friction_pw"),
            )
        },
        "dumps": len(dumps),
        "balls_at_points": counts.tolist(),
        "velocity_m_s": [None if np.isnan(u) else round(float(u), 5) for u in profile.velocity],
    }


def state_row(charge: Charge) -> Row:
    """Return what a row of any charge holds."""
    result, ends = charge.result, charge.result.ends
    return {
        "campaign": charge.campaign,
        "id": charge.id,
        "S": charge.S,
        "balls": charge.balls,
        "liner_slip": result.liner_slip,
        "torque": result.dimensionless["torque"],
        "kinetic": result.dimensionless["kinetic"],
        "ends_power_share": ends.power_share if ends else None,
        "is_steady": result.steady.is_steady,
    }


@dataclass(frozen=True)
class Landing:
    """Where a thrown ball lands.

    Attributes:
        angle: from the vertical on the falling side [rad].
        speed: of the centre [m/s].
    """

    angle: float
    speed: float


def landing_on_liner(release: Release, path: float) -> Landing:
    """Return where a ball first comes to a circle of radius `path` about the axis [m]: R - a."""
    time = release.time_to_radius(path)
    x, _, z = release.position_at(time)
    speed = float(np.linalg.norm(release.velocity_at(time)))
    return Landing(math.atan2(x, z) % (2.0 * math.pi), speed)


def throw_row(ball: SingleBall, campaign: str) -> Row:
    """Return the row of a single ball: its releases in the physical mill."""
    case = ball.case
    length, time = to_physical(case)
    physical = case.physical
    return {
        "campaign": campaign,
        "id": ball.id,
        "S": ball.S,
        "state": ball.state,
        "radius_m": physical.radius_m,
        "path_m": length * (case.mill.radius_m - case.ball.radius_m),
        "gravity_m_s2": length / time**2 * case.mill.gravity_m_s2,
        "omega_rad_s": case.mill.omega_rad_s / time,
        "releases": [
            {
                "position_m": [round(length * x, 6) for x in throw.position_m],
                "velocity_m_s": [round(length / time * v, 6) for v in throw.velocity_m_s],
            }
            for throw in ball.result.throws
            if throw.finished
        ],
    }


def releases_of(row: Row) -> list[Release]:
    """Return the releases of a row of `throws`."""
    return [
        Release(np.array(x["position_m"]), np.array(x["velocity_m_s"]), row["gravity_m_s2"])
        for x in row["releases"]
    ]


def closed_form(row: Row) -> Landing:
    """Return where a ball lands that leaves the circle of the centres where the wall's force
    vanishes, without lifters."""
    fall = row["omega_rad_s"] ** 2 * row["path_m"] / row["gravity_m_s2"]
    phi = math.acos(fall)
    return Landing(3.0 * phi, row["omega_rad_s"] * row["path_m"] * impact_speed_ratio(phi))


def is_measured_drum(case: Case) -> bool:
    """Return whether a case is of the drum of the measured profile, by its size and speed."""
    mill = case.physical
    found = (mill.radius_m, mill.omega_rad_s, mill.ball_radius_m)
    return bool(np.allclose(found, (0.12, OMEGA, 1.5e-3), rtol=1e-6))
