"""Energy change of a single ball between two mill angles in free flight."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from millscale.analysis.single_ball.events import Flight
from millscale.analysis.single_ball.flight import Release
from millscale.runs.series import Series


@dataclass(frozen=True)
class Ball:
    """A ball and the operating point of its mill: mass [kg], gravity [m/s^2], speed of the mill
    [rad/s]."""

    mass: float
    gravity: float
    omega: float


@dataclass(frozen=True)
class EnergyChange:
    """Change of energy between two mill angles [J]. In free flight the two are equal and opposite.

    Attributes:
        begin, end: mill angles [rad].
        in_flight: whether the ball flies freely from `begin` to `end`.
    """

    begin: float
    end: float
    kinetic: float
    potential: float
    in_flight: bool


def change_on_parabola(flight: Flight, ball: Ball, begin: float, end: float) -> float:
    """Return the gain of kinetic energy between two mill angles of a flight [J].

    Exact, from the recorded release: dv/dt = -g.

    Args:
        begin, end: mill angles [rad].
    """
    release = Release(flight.position, flight.velocity, ball.gravity)
    times = (np.array([begin, end]) - flight.mill_angle) / ball.omega
    return float(np.diff(release.kinetic_change(times, ball.mass))[0])


def sampled_change(series: Series, begin: float, end: float, seen: list[Flight]) -> EnergyChange:
    """Return the change between two mill angles, interpolated in the series.

    Args:
        seen: all confirmed flights of the series.

    Raises:
        ValueError: the series does not reach both angles.
    """
    angle = series["mill_angle_rad"]
    if not (0.0 <= begin <= end <= angle[-1]):
        raise ValueError(
            f"mill angles {begin:g} to {end:g} rad are not in the series, 0 to {angle[-1]:g} rad"
        )
    first = max(0, int(np.searchsorted(angle, 0.0, side="right")) - 1)
    kinetic, potential = (
        np.diff(np.interp([begin, end], angle[first:], series[name][first:]))[0]
        for name in ("kinetic_translation_J", "potential_J")
    )
    inside = any(f.mill_angle <= begin and end <= f.mill_angle_end for f in seen)
    return EnergyChange(begin, end, float(kinetic), float(potential), inside)


def change_from_release(series: Series, flight: Flight, ball: Ball, window: float) -> EnergyChange:
    """Return the change from the recorded release to the series `window` of mill rotation later.

    This checks `change_on_parabola`: the end comes from the samples of the engine, and potential
    and kinetic energy are separate."""
    rows = flight.rows
    end = flight.mill_angle + window
    at_release = (
        0.5 * ball.mass * float(np.dot(flight.velocity, flight.velocity)),
        ball.mass * ball.gravity * float(flight.position[2]),
    )
    angle = np.concatenate([[flight.mill_angle], series["mill_angle_rad"][rows]])
    kinetic, potential = (
        float(np.interp(end, angle, np.concatenate([[start], series[name][rows]]))) - start
        for start, name in zip(at_release, ("kinetic_translation_J", "potential_J"), strict=True)
    )
    return EnergyChange(flight.mill_angle, end, kinetic, potential, end <= flight.mill_angle_end)


def deviation_from_parabola(series: Series, flight: Flight, ball: Ball) -> tuple[float, float]:
    """Return the largest difference of kinetic and of potential energy between the samples of a
    flight and the parabola from its recorded release [J]."""
    if not flight.rows.size:
        return 0.0, 0.0
    time = (series["mill_angle_rad"][flight.rows] - flight.mill_angle) / ball.omega
    gain = Release(flight.position, flight.velocity, ball.gravity).kinetic_change(time, ball.mass)
    kinetic = 0.5 * ball.mass * float(np.dot(flight.velocity, flight.velocity)) + gain
    potential = ball.mass * ball.gravity * flight.position[2] - gain
    return (
        float(np.max(np.abs(series["kinetic_translation_J"][flight.rows] - kinetic))),
        float(np.max(np.abs(series["potential_J"][flight.rows] - potential))),
    )
