"""Reading of series.csv: columns by name, checked for truncation."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from millscale.runs.untrusted import MOST_SERIES, RunFolderError, read_text

Series = dict[str, np.ndarray]

_MOTION = ("step", "time_s", "mill_angle_rad")
_ENERGY = ("kinetic_translation_J", "kinetic_rotation_J", "potential_J")
_EVENTS = (
    *("liner_off_count", "liner_off_angle_rad", "liner_off_mill_angle_rad", "liner_off_groove"),
    *("flight_count", "flight_angle_rad", "flight_mill_angle_rad", "flight_lifter"),
    *("flight_x_m", "flight_y_m", "flight_z_m"),
    *("flight_vx_m_s", "flight_vy_m_s", "flight_vz_m_s", "time_in_flight_s"),
)
_LEDGER = (
    *("elastic_normal_J", "elastic_tangential_J"),
    *("dissipated_normal_J", "dissipated_tangential_J", "dissipated_rolling_J"),
    *("tangential_dashpot_J", "tangential_slip_J", "spring_error_J"),
    *("impacts", "impact_energy_J"),
)
REQUIRED = {
    "single-ball": (
        *_MOTION,
        *("x_m", "y_m", "z_m", "vx_m_s", "vy_m_s", "vz_m_s"),
        *_ENERGY,
        "state",
        *_EVENTS,
    ),
    "multi-ball": (
        *_MOTION,
        *("balls", "mass_kg"),
        *_ENERGY,
        *("centre_x_m", "centre_z_m", "angular_momentum_Nms"),
        *("drive_work_J", "drive_torque_Nm", "drive_power_W", "alternating_torque_Nm"),
        *("balls_on_wall", "balls_in_bed", "balls_in_flight"),
    ),
    "ledger": (
        *_MOTION,
        *_ENERGY,
        "mill_work_J",
        *(f"{pairing}_{term}" for pairing in ("ball_ball", "ball_wall") for term in _LEDGER),
        "residual_J",
    ),
}
# Of a plain drum, and of a charge without a bed or off the liner.
_MAY_BE_NAN = {
    *("box_fixed_mass_fraction", "box_rotating_mass_fraction"),
    *("toe_angle_rad", "shoulder_angle_rad", "liner_slip"),
}
# Columns of versions that sampled torque and power at single steps; they alternate between steps.
_SAMPLED = {"torque_Nm", "power_W"}
_REMEDY = "run the case again: millscale run FILE --runs DIR --only ID"


def read_series(path: Path, kind: str) -> Series:
    """Return the columns of a series.csv by name, each (n,) float.

    Args:
        kind: single-ball or multi-ball, as in case.json; or ledger, for a ledger.csv.

    Raises:
        RunFolderError: missing or cut short, a column missing, a value that is not finite, or
            steps, times or mill angles that do not increase; at rest the angle stays 0.
    """
    lines = read_text(path, MOST_SERIES, _REMEDY).splitlines()
    names = [name.strip() for name in lines[0].split(",")] if lines else []
    missing = [name for name in REQUIRED[kind] if name not in names]
    if missing and kind == "multi-ball" and set(names) >= _SAMPLED:
        cause = "torque and power are samples of single steps, made by an earlier version"
        raise RunFolderError(path, cause, _REMEDY)
    if missing:
        raise RunFolderError(
            path, f"no column {', '.join(missing)}; columns are {', '.join(names)}", _REMEDY
        )
    if len(set(names)) < len(names):
        raise RunFolderError(path, "two columns have the same name", _REMEDY)
    rows = _rows(path, lines[1:], len(names))
    series = {name: rows[:, i] for i, name in enumerate(names)}
    _check(path, series)
    return series


def _rows(path: Path, lines: list[str], columns: int) -> np.ndarray:
    """Return the rows as an array, (n, columns) float."""
    if len(lines) < 2:
        raise RunFolderError(path, f"{len(lines)} rows, at least 2 are needed", _REMEDY)
    for number, line in enumerate(lines, start=2):
        if line.count(",") != columns - 1:
            raise RunFolderError(
                path,
                f"line {number} has {line.count(',') + 1} values, {columns} columns are named: "
                "cut short, or written to while it is read",
                _REMEDY,
            )
    try:
        return np.loadtxt(lines, delimiter=",", ndmin=2, comments=None)
    except ValueError as error:
        raise RunFolderError(path, f"a value is not a number: {error}", _REMEDY) from None


def _check(path: Path, series: Series) -> None:
    for name, values in series.items():
        accepted = np.isfinite(values) | (name in _MAY_BE_NAN and np.isnan(values))
        bad = np.flatnonzero(~accepted)
        if bad.size:
            raise RunFolderError(path, f"{name} is {values[bad[0]]} in line {bad[0] + 2}", _REMEDY)
    for name in _MOTION:
        before, after = series[name][:-1], series[name][1:]
        at_rest = (name == "mill_angle_rad") & (before == 0.0) & (after == 0.0)
        back = np.flatnonzero((after <= before) & ~at_rest)
        if back.size:
            one, other = series[name][back[0] : back[0] + 2]
            raise RunFolderError(
                path,
                f"{name} goes from {one:.12g} to {other:.12g} in line {back[0] + 3}: "
                "two runs in one file, or changed",
                _REMEDY,
            )
