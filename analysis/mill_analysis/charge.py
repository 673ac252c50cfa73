"""result.json of a multi-ball case: means over the steady part of the rotation."""

from __future__ import annotations

from typing import Any

import numpy as np

from mill_analysis.series import Series


def charge_scales(case: dict[str, Any]) -> dict[str, float]:
    """Mass of the charge M [kg] and what its series are made dimensionless with: energy
    M (omega R)^2 [J], torque M g R [N m], power M g R omega [W], length R [m]."""
    mill, ball = case["mill"], case["ball"]
    mass = ball["mass_kg"] * ball["count"]
    torque = mass * mill["gravity_m_s2"] * mill["radius_m"]
    return {
        "mass": mass,
        "energy": mass * (mill["omega_rad_s"] * mill["radius_m"]) ** 2,
        "torque": torque,
        "power": torque * mill["omega_rad_s"],
        "length": mill["radius_m"],
    }


def mean_over_rotation(mill_angle: np.ndarray, values: np.ndarray, begin: float) -> float:
    """Mean over mill angle from `begin` [rad] to the end of the series.

    Args:
        mill_angle: (n,) float, not decreasing [rad].
        values: (n,) float.

    Raises:
        ValueError: fewer than two samples from `begin` on.
    """
    steady = mill_angle >= begin
    if steady.sum() < 2:
        raise ValueError(
            f"series ends at {mill_angle[-1]:g} rad, a mean from {begin:g} rad needs two"
        )
    angle = mill_angle[steady]
    return float(np.trapezoid(values[steady], angle) / (angle[-1] - angle[0]))


def charge_result(case: dict[str, Any], series: Series) -> dict[str, Any]:
    """Means over the second half of the rotation, in SI units and over `charge_scales`.

    Power and torque are those of the drive: positive when the charge is lifted.
    """
    angle = series["mill_angle_rad"]
    begin = 0.5 * float(angle[-1])
    scales = charge_scales(case)
    mean = {
        name: mean_over_rotation(angle, values, begin)
        for name, values in (
            ("kinetic_translation_J", series["kinetic_translation_J"]),
            ("kinetic_rotation_J", series["kinetic_rotation_J"]),
            ("potential_J", series["potential_J"]),
            ("drive_torque_Nm", -series["torque_Nm"]),
            ("power_W", series["power_W"]),
            ("centre_x_m", series["centre_x_m"]),
            ("centre_z_m", series["centre_z_m"]),
            ("flying_share", series["balls_in_flight"] / series["balls"]),
        )
    }
    return {
        "problem": _problem(case, series),
        "mean_from_rad": begin,
        "mean_to_rad": float(angle[-1]),
        "mean": mean,
        "dimensionless": {
            "kinetic": mean["kinetic_translation_J"] / scales["energy"],
            "kinetic_rotation": mean["kinetic_rotation_J"] / scales["energy"],
            "torque": mean["drive_torque_Nm"] / scales["torque"],
            "power": mean["power_W"] / scales["power"],
            "centre_x": mean["centre_x_m"] / scales["length"],
            "centre_z": mean["centre_z_m"] / scales["length"],
        },
        "largest_overlap_over_radius": _largest_overlap(case, series),
        "rotation_angle_rad": float(angle[-1]),
    }


def _largest_overlap(case: dict[str, Any], series: Series) -> float | None:
    if "largest_overlap_m" not in series:
        return None
    return float(series["largest_overlap_m"].max() / case["ball"]["radius_m"])


def _problem(case: dict[str, Any], series: Series) -> str | None:
    count = case["ball"]["count"]
    fewest, most = series["balls"].min(), series["balls"].max()
    if fewest == most == count:
        return None
    return f"{count} balls planned, {fewest:.0f} to {most:.0f} in the series: lost or added"
