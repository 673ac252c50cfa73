"""The paper's numbers, Powder Technology 335 (2018) 91-102, doi 10.1016/j.powtec.2018.05.012."""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from millscale.runs.case_file import Case

TABLES = Path(__file__).parent / "tables"
_ENERGY_TABLES = {
    "constant-gravity": "table8_energy_constant_gravity",
    "constant-speed": "table9_energy_constant_speed",
}
LIFTERS = 25  # in all of Table 4
CURTAINS = (2, 4, 6, 7)  # Fig. 12
SAME_S = 1e-3  # S of a case and of a table row; Table 4 prints three decimals


@dataclass(frozen=True)
class ReportedEnergy:
    """A row of Table 8 or 9: S, energy change [J], predicted ratio, actual ratio."""

    S: float
    change: float
    predicted: float
    ratio: float


@dataclass(frozen=True)
class ReportedThrow:
    """Section 4.1 for one scheme: mill angles of the window [rad], correlation of Fig. 8 [-],
    detaching angle read off Fig. 6 [deg]."""

    begin: float
    end: float
    correlation: float
    detach_angle_deg: float

    @property
    def window(self) -> float:
        """Return the mill rotation between the two angles [rad]."""
        return self.end - self.begin


@cache
def table(name: str) -> tuple[dict[str, float | str], ...]:
    """Return the rows of a table by column name; numbers as float.

    Args:
        name: file name in tables/ without its ending.
    """
    lines = (TABLES / f"{name}.csv").read_text(encoding="utf-8").splitlines()
    rows = csv.DictReader(line for line in lines if not line.startswith("#"))
    return tuple({key: _number(value) for key, value in row.items()} for row in rows)


def is_papers_mill(case: Case) -> bool:
    """Return whether the physical mill of a case is the paper's; its length may be another."""
    geometry, operation = table("table4_geometry")[0], table("table6_constant_gravity")[0]
    ball = next(x for x in table("table5_parameters") if x["parameter"] == "particle_radius")
    mill = case.physical
    pairs = (
        (mill.radius_m, 1e-3 * geometry["R_mm"]),
        (mill.lifter_top_radius_m, 1e-3 * geometry["r_mm"]),
        (mill.lifters, LIFTERS),
        (mill.ball_radius_m, ball["value"]),
        (mill.gravity_m_s2, operation["gravity_m_s2"]),
        (mill.omega_rad_s, operation["omega_rad_s"]),
    )
    # Rounded as people type them: 9.55 rpm for 1 rad/s.
    return all(math.isclose(given, number, rel_tol=1e-3) for given, number in pairs)


def scheme_row(rows: tuple[dict, ...], S: float) -> dict | None:
    """Return the row of a table with a column S that belongs to S; None if there is none."""
    return next((row for row in rows if abs(row["S"] - S) <= SAME_S), None)


def reported_energies(scheme: str) -> tuple[ReportedEnergy, ...]:
    """Return Table 8 or 9; empty for a scheme that is not the paper's."""
    if scheme not in _ENERGY_TABLES:
        return ()
    ratio_of = {row["model"]: row["S"] for row in table("table4_geometry")}
    predicted = "inverse_S" if scheme == "constant-gravity" else "inverse_S_squared"
    return tuple(
        ReportedEnergy(
            ratio_of[row["model"]], row["energy_change_J"], row[predicted], row["actual_ratio"]
        )
        for row in table(_ENERGY_TABLES[scheme])
    )


def reported_energy(scheme: str, S: float) -> ReportedEnergy | None:
    """Return the row of Table 8 or 9 that belongs to S; None if there is none."""
    return next((row for row in reported_energies(scheme) if abs(row.S - S) <= SAME_S), None)


def reported_throw(scheme: str) -> ReportedThrow | None:
    """Return the numbers of section 4.1 for a scheme; None if it is not the paper's."""
    for row in table("section_4_1_single_ball"):
        if row["scheme"] == scheme:
            return ReportedThrow(
                row["theta_a_rad"], row["theta_b_rad"], row["correlation"], row["detach_angle_deg"]
            )
    return None


def reported_charge(S: float) -> dict | None:
    """Return the row of Table 10 that belongs to S (total_mass_kg, particles, elapsed_h); None if
    there is none."""
    mill = scheme_row(table("table4_geometry"), S)
    if mill is None:
        return None
    return next(row for row in table("table10_wall_time") if row["model"] == mill["model"])


def longest_window() -> float:
    """Return the mill rotation over which energy changes are taken if all flights last that long:
    that of Table 8 [rad]."""
    return reported_throw("constant-gravity").window


def _number(value: str) -> float | str:
    try:
        return float(value)
    except ValueError:
        return value
