"""Events of a single ball: confirmed flights, which of them is the throw of a cycle, and the
regions I to IV of the motion.

Angles are from the vertical, positive on the rising side, as recorded by compute mill/detach.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from millscale.runs.series import Series

SETTLED_SPEED = 0.1  # of omega R: a ball slower than this relative to the mill is carried


@dataclass(frozen=True)
class LinerOff:
    """Loss of contact with the liner; the ball may still be in contact with a lifter.

    Attributes:
        angle: from the vertical [rad].
    """

    mill_angle: float
    angle: float
    groove: int


@dataclass(frozen=True)
class Flight:
    """A confirmed free flight.

    Attributes:
        mill_angle, angle: of its begin [rad].
        lifter: the sector the ball left from.
        position, velocity: (3,) float, at its begin [m], [m/s].
        rows: (k,) int, samples taken during it; empty if it fell between two samples.
        finished: whether it ended before the series did.
        mill_angle_end: mill angle of the last sample in flight [rad].
    """

    mill_angle: float
    angle: float
    lifter: int
    position: np.ndarray
    velocity: np.ndarray
    rows: np.ndarray
    finished: bool
    mill_angle_end: float

    @property
    def length(self) -> float:
        """Return the mill rotation during the flight, to the last sample in it [rad]."""
        return max(0.0, self.mill_angle_end - self.mill_angle)


@dataclass(frozen=True)
class Throw:
    """The throw of one cycle: the flight, and where the liner was left before it (if recorded).

    Attributes:
        lift: sample at which the ball, carried up, passed the height of the axis.
        next_lift: the same of the next cycle, or the number of samples.
    """

    flight: Flight
    liner_off: LinerOff | None
    lift: int
    next_lift: int


@dataclass(frozen=True)
class Regions:
    """Mill angles that bound the regions of the first cycle [rad]; None if not reached.

    I from the start of rotation, II from `settled`, III from `thrown`, IV from `impact`, II again
    from `settled_again`.
    """

    settled: float | None
    thrown: float
    impact: float | None
    settled_again: float | None


def flights(series: Series) -> list[Flight]:
    """Return the confirmed flights that the samples show, in order."""
    return [_flight(series, row) for row in _new_records(series["flight_count"])]


def liner_offs(series: Series) -> list[LinerOff]:
    """Return the confirmed losses of liner contact that the samples show, in order."""
    return [
        LinerOff(
            float(series["liner_off_mill_angle_rad"][row]),
            float(series["liner_off_angle_rad"][row]),
            int(series["liner_off_groove"][row]),
        )
        for row in _new_records(series["liner_off_count"])
    ]


def unseen_events(series: Series) -> int:
    """Return the number of confirmed events that a later one overwrote before the next sample."""
    counts = (series["flight_count"], series["liner_off_count"])
    return int(sum(np.maximum(np.diff(count, prepend=0.0) - 1.0, 0.0).sum() for count in counts))


def throws(series: Series) -> list[Throw]:
    """Return the throw of every cycle.

    A cycle begins where the ball is lifted through the height of the axis on the rising side. Its
    throw is the longest flight that begins above the axis before the next lift: bounces at the
    start and after the fall begin below, and those off a lifter in the upper half are short.
    """
    lifts = lift_rows(series)
    seen, offs = flights(series), liner_offs(series)
    found = []
    for lift, next_lift in pairwise([*lifts, series["step"].size]):
        begin = series["mill_angle_rad"][lift - 1] if lift > 0 else -np.inf
        end = series["mill_angle_rad"][next_lift] if next_lift < series["step"].size else np.inf
        cycle = [f for f in seen if begin <= f.mill_angle < end and f.position[2] > 0.0]
        if cycle:
            throw = max(cycle, key=lambda f: f.length if f.finished else np.inf)
            found.append(Throw(throw, _last_off(offs, throw), lift, next_lift))
    return found


def lift_rows(series: Series) -> list[int]:
    """Return the (k,) samples at which the ball has just risen above the axis on the rising side (x
    < 0).

    A ball that starts there counts as lifted in the first sample.
    """
    above = series["z_m"] >= 0.0
    rising = above & ~np.concatenate([[False], above[:-1]]) & (series["x_m"] < 0.0)
    return np.flatnonzero(rising).tolist()


def regions(series: Series, throw: Throw, omega: float, radius: float) -> Regions:
    """Return the regions I to IV around a throw.

    Args:
        omega: speed of the mill [rad/s].
        radius: of the mill at the liner [m].
    """
    carried = mill_relative_speed(series, omega) < SETTLED_SPEED * omega * radius
    flight = throw.flight
    turning = int(np.searchsorted(series["mill_angle_rad"], 0.0, side="right"))
    impact = settled_again = None
    if flight.finished and flight.rows.size:
        row = int(flight.rows[-1]) + 1
        impact = float(series["mill_angle_rad"][row])
        if throw.next_lift < series["step"].size:
            settled_again = _settled(series, carried, row, throw.next_lift)
    settled = _settled(series, carried, min(turning, throw.lift), throw.lift)
    return Regions(settled, flight.mill_angle, impact, settled_again)


def mill_relative_speed(series: Series, omega: float) -> np.ndarray:
    """Return the (n,) speed of the ball relative to the turning mill, in the cross-section
    [m/s]."""
    return np.hypot(
        series["vx_m_s"] - omega * series["z_m"], series["vz_m_s"] + omega * series["x_m"]
    )


def _settled(series: Series, carried: np.ndarray, begin: int, lift: int) -> float | None:
    """Return the mill angle from which on the ball is carried up to the lift; None if it never
    is."""
    moving = np.flatnonzero(~carried[begin:lift])
    row = begin + (moving[-1] + 1 if moving.size else 0)
    return float(series["mill_angle_rad"][row]) if row < lift or row == begin else None


def _new_records(count: np.ndarray) -> list[int]:
    return np.flatnonzero(np.diff(count, prepend=0.0) > 0.0).tolist()


def _flight(series: Series, row: int) -> Flight:
    in_flight = series["time_in_flight_s"][row:]
    going = (in_flight > 0.0) & (series["flight_count"][row:] == series["flight_count"][row])
    going[1:] &= np.diff(in_flight) > 0.0
    over = np.flatnonzero(~going)
    samples = int(over[0]) if over.size else going.size
    rows = np.arange(row, row + samples)
    mill_angle = float(series["flight_mill_angle_rad"][row])
    return Flight(
        mill_angle=mill_angle,
        angle=float(series["flight_angle_rad"][row]),
        lifter=int(series["flight_lifter"][row]),
        position=np.array([series[f"flight_{axis}_m"][row] for axis in "xyz"]),
        velocity=np.array([series[f"flight_v{axis}_m_s"][row] for axis in "xyz"]),
        rows=rows,
        finished=bool(over.size),
        mill_angle_end=float(series["mill_angle_rad"][rows[-1]]) if rows.size else mill_angle,
    )


def _last_off(offs: list[LinerOff], throw: Flight) -> LinerOff | None:
    before = [off for off in offs if off.mill_angle <= throw.mill_angle]
    return before[-1] if before else None
