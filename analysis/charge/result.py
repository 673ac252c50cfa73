"""result.json of a multi-ball case: means over the steady part of the rotation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from millscale.analysis.charge.steady import (
    FEWEST_PITCHES,
    MOST_DRIFT,
    Window,
    choose_window,
    pitch_of,
    standard_error,
    trend,
)
from millscale.analysis.result_file import ChargeResult, EndWalls, Steadiness, TorqueBalance
from millscale.runs.case_file import Case
from millscale.runs.series import Series
from millscale.runs.speed import schedule_of

# Means over the steady part, by their name in result.json.
_MEANS = (
    *("kinetic_translation_J", "kinetic_rotation_J", "potential_J"),
    *("centre_x_m", "centre_z_m"),
)


@dataclass(frozen=True)
class ChargeScales:
    """What makes the quantities of a charge dimensionless; omega after the last change of speed.

    Attributes:
        mass: M [kg], that of the balls in the series: balls of several sizes have not their mean.
        energy: M (omega R)^2 [J].
        torque: M g R [N m].
        power: M g R omega [W].
        length: R [m].
    """

    mass: float
    energy: float
    torque: float
    power: float
    length: float


def charge_scales(case: Case, series: Series) -> ChargeScales:
    """Return the scales of a charge."""
    mill, mass = case.mill, float(series["mass_kg"][0])
    omega = mill.omega_rad_s * schedule_of(case).last_ratio
    torque = mass * mill.gravity_m_s2 * mill.radius_m
    return ChargeScales(
        mass=mass,
        energy=mass * (omega * mill.radius_m) ** 2,
        torque=torque,
        power=torque * omega,
        length=mill.radius_m,
    )


def charge_result(case: Case, series: Series) -> ChargeResult:
    """Return means over the window of `steady.choose_window`, in SI units and dimensionless.

    Torque and power are those of the drive, positive when the charge is lifted: the work done in
    the window over mill angle and time. `torque_balance` sets them against the charge's weight and
    angular momentum. `steady`: whether the charge is in a steady state. `ends`: of end walls.
    """
    angle, time = series["mill_angle_rad"], series["time_s"]
    scales = charge_scales(case, series)
    pitch = pitch_of(case.mill)
    window = choose_window(
        angle,
        [series["centre_x_m"], series["kinetic_translation_J"]],
        pitch,
        schedule_of(case).steady_from,
    )
    work, duration = window.change(angle, series["drive_work_J"]), window.change(angle, time)
    balance = torque_balance(series, scales, window, case.mill.ends == "resting")
    mean = {name: window.mean(angle, series[name]) for name in _MEANS}
    mean |= {
        "drive_torque_Nm": balance.summed_Nm,
        "power_W": work / duration,
        "flying_share": window.mean(angle, series["balls_in_flight"] / series["balls"]),
    }
    by_momentum, by_weight = balance.angular_momentum_Nm, balance.weight_Nm
    alternating = series["alternating_torque_Nm"][(angle > window.begin) & (angle <= window.end)]
    return ChargeResult(
        problem=_problem(case, series),
        mean_from_rad=window.begin,
        mean_to_rad=window.end,
        pitches=window.pitches,
        mean=mean,
        dimensionless={
            "kinetic": mean["kinetic_translation_J"] / scales.energy,
            "kinetic_rotation": mean["kinetic_rotation_J"] / scales.energy,
            "torque": mean["drive_torque_Nm"] / scales.torque,
            "power": mean["power_W"] / scales.power,
            "centre_x": mean["centre_x_m"] / scales.length,
            "centre_z": mean["centre_z_m"] / scales.length,
        },
        standard_error=_standard_errors(series, scales, window),
        torque_balance=balance,
        alternating_torque=float(np.sqrt(np.mean(alternating**2))) / scales.torque,
        steady=_steady(series, window, by_momentum / by_weight if by_weight else None),
        largest_overlap_over_radius=_largest_overlap(case, series),
        rotation_angle_rad=float(angle[-1]),
        ends=_end_walls(case, series, window),
        liner_slip=_liner_slip(series, window),
    )


def _liner_slip(series: Series, window: Window) -> float | None:
    """Return the mean slip on the liner in a window, over the rows with a ball on the liner; None
    without such rows."""
    angle = series["mill_angle_rad"]
    slip = series.get("liner_slip", np.full_like(angle, np.nan))
    known = np.isfinite(slip)
    in_window = known & (angle >= window.begin) & (angle <= window.end)
    return window.mean(angle[known], slip[known]) if in_window.sum() > 1 else None


def _end_walls(case: Case, series: Series, window: Window) -> EndWalls | None:
    """Return power and torque of the end walls in a window; None for periodic ends."""
    if case.mill.ends == "periodic":
        return None
    angle = series["mill_angle_rad"]
    duration = window.change(angle, series["time_s"])
    work = window.change(angle, series["ends_work_J"])
    share = work / whole if (whole := window.change(angle, series["drive_work_J"])) else None
    return EndWalls(work / duration, _end_torque(series, window), share)


def _end_torque(series: Series, window: Window) -> float:
    """Return the mean torque of the end walls on the charge about the axis [N m]."""
    angle = series["mill_angle_rad"]
    return window.change(angle, series["ends_impulse_Nms"]) / window.change(angle, series["time_s"])


def torque_balance(
    series: Series, scales: ChargeScales, window: Window, ends_rest: bool = False
) -> TorqueBalance:
    """Return the mean torque of the drive over a window by its work, and by the charge's weight and
    the change of its angular momentum, and the torque of resting ends on the charge."""
    angle = series["mill_angle_rad"]
    duration = window.change(angle, series["time_s"])
    summed = window.change(angle, series["drive_work_J"]) / (window.end - window.begin)
    by_weight = -scales.torque / scales.length * window.mean(angle, series["centre_x_m"])
    by_momentum = window.change(angle, series["angular_momentum_Nms"]) / duration
    # Turning ends are a part of the drive, resting ones act beside it.
    of_ends = _end_torque(series, window) if ends_rest else None
    difference = (summed + (of_ends or 0.0) - by_weight - by_momentum) / scales.torque
    return TorqueBalance(summed, by_weight, by_momentum, difference, of_ends)


def _standard_errors(
    series: Series, scales: ChargeScales, window: Window
) -> dict[str, float | None]:
    """Return the standard errors of dimensionless means, from the scatter of the pitches; None
    without pitches."""
    if window.pitches < FEWEST_PITCHES:
        return dict.fromkeys(("kinetic", "torque", "centre_x"))
    angle = series["mill_angle_rad"]
    work = np.interp(window.edges, angle, series["drive_work_J"])
    of_pitches = {
        "kinetic": window.pitch_means(angle, series["kinetic_translation_J"]) / scales.energy,
        "torque": np.diff(work) / np.diff(window.edges) / scales.torque,
        "centre_x": window.pitch_means(angle, series["centre_x_m"]) / scales.length,
    }
    return {name: standard_error(values) for name, values in of_pitches.items()}


def _steady(series: Series, window: Window, momentum_share: float | None) -> Steadiness:
    """Return whether the charge is steady in the window, with the numbers that decide it.

    Args:
        momentum_share: torque that changes the angular momentum over that against the weight.
    """
    angle, centre = series["mill_angle_rad"], series["centre_x_m"]
    drift = error = None
    reasons = []
    if window.pitches < FEWEST_PITCHES:
        reasons.append(
            f"the rotation of {angle[-1]:.3g} rad has fewer than {FEWEST_PITCHES} lifter pitches: "
            "too few to show whether the charge is steady"
        )
    else:
        of_pitches = window.pitch_means(angle, centre)
        line, mean = trend(of_pitches), abs(float(of_pitches.mean()))
        if mean > 0.0:
            drift, error = line.change / mean, line.error / mean
        # Twice as much may be chance; a scatter that hides more shows no steady state.
        if drift is not None and abs(drift) > min(max(MOST_DRIFT, 2.0 * error), 2.0 * MOST_DRIFT):
            reasons.append(f"its centre of mass drifts by {100.0 * drift:+.1f} % in the window")
    if momentum_share is not None and abs(momentum_share) > MOST_DRIFT:
        reasons.append(
            f"its angular momentum changes: {100.0 * momentum_share:+.1f} % of the torque"
        )
    return Steadiness(not reasons, tuple(reasons), drift, error, momentum_share)


def _largest_overlap(case: Case, series: Series) -> float | None:
    if "largest_overlap_m" not in series:
        return None
    return float(series["largest_overlap_m"].max() / case.ball.radius_m)


def _problem(case: Case, series: Series) -> str | None:
    count = case.ball.count
    fewest, most = series["balls"].min(), series["balls"].max()
    if fewest == most == count:
        return None
    return f"{count} balls planned, {fewest:.0f} to {most:.0f} in the series: lost or added"
