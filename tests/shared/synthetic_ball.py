"""A single ball that hops, is carried on a circle, and is thrown: series.csv in closed form."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from millscale.analysis.single_ball.flight import Release

DETACH, LINER_OFF = math.radians(35.5), math.radians(63.9)
START = 0.1


@dataclass(frozen=True)
class Segment:
    """A part of the motion: a parabola (`release`), or with the mill on the circle from `psi`."""

    begin: float
    end: float
    release: Release | None = None
    psi: float = 0.0
    turning: bool = True


@dataclass(frozen=True)
class Off:
    """Liner contact lost: time, mill angle, angle from the vertical."""

    time: float
    mill_angle: float
    angle: float


class Motion:
    """Motion of a ball of a case, segment by segment."""

    def __init__(self, case: dict[str, Any]) -> None:
        self.omega, self.gravity = case["mill"]["omega_rad_s"], case["mill"]["gravity_m_s2"]
        self.mass = case["ball"]["mass_kg"]
        self.radius = case["mill"]["radius_m"] - case["ball"]["radius_m"]
        self.step = case["time"]["step_s"]
        self.sample = max(1, round(case["time"]["sample_angle_rad"] / (self.omega * self.step)))
        self.segments = [Segment(0.0, START, turning=False)]
        self.offs: list[Off] = []
        self.psi = 0.0

    @property
    def now(self) -> float:
        return self.segments[-1].end

    def place(self, psi: float) -> np.ndarray:
        """Return the centre of the ball on its circle."""
        return self.radius * np.array([-math.sin(psi), 0.0, -math.cos(psi)])

    def hop(self, psi: float, mill_turn: float) -> None:
        """Fly to another point of the circle while the mill turns by `mill_turn`."""
        time = mill_turn / self.omega
        fall = np.array([0.0, 0.0, 0.5 * self.gravity * time])
        velocity = (self.place(psi) - self.place(self.psi)) / time + fall
        self._fly(Release(self.place(self.psi), velocity, self.gravity), time)
        self.psi = psi

    def carry(self, angle: float, leaves_liner_at: float | None = None) -> None:
        """Move with the mill until `angle` from the vertical."""
        psi = math.pi - angle
        if leaves_liner_at is not None:
            time = self.now + (math.pi - leaves_liner_at - self.psi) / self.omega
            self.offs.append(Off(time, self.omega * (time - START), leaves_liner_at))
        end = self.now + (psi - self.psi) / self.omega
        self.segments.append(Segment(self.now, end, psi=self.psi))
        self.psi = psi

    def throw(self) -> Release:
        """Leave the circle with its speed, and fly to where the path crosses it again."""
        along = np.array([-math.cos(self.psi), 0.0, math.sin(self.psi)])
        release = Release(self.place(self.psi), self.omega * self.radius * along, self.gravity)
        self._fly(release, release.time_to_radius(self.radius))
        x, _, z = release.position_at(self.segments[-1].end - self.segments[-1].begin)
        self.psi = math.atan2(-x, -z)
        return release

    def _fly(self, release: Release, time: float) -> None:
        self.segments.append(Segment(self.now, self.now + time, release=release))

    def series(self) -> dict[str, np.ndarray]:
        """Return the columns of series.csv, sampled every `sample` steps."""
        rows, records = [], {"off": None, "flight": None, "offs": 0, "flights": 0}
        steps = np.arange(0, int(self.now / self.step) + 1, self.sample)
        launched = [s for s in self.segments if s.release]
        for step in steps:
            time = step * self.step
            records["offs"] = sum(off.time < time for off in self.offs)
            records["flights"] = sum(s.begin < time for s in launched)
            off = self.offs[records["offs"] - 1] if records["offs"] else None
            flight = launched[records["flights"] - 1] if records["flights"] else None
            rows.append(self._row(step, time, (records["offs"], off), (records["flights"], flight)))
        return {name: np.array([row[name] for row in rows], float) for name in rows[0]}

    def _row(self, step, time, offs, flights) -> dict[str, float]:
        segment = next(s for s in reversed(self.segments) if s.begin <= time)
        position, velocity = self._state(segment, time)
        speed2 = float(velocity @ velocity)
        energy = {"kinetic_translation_J": 0.5 * self.mass * speed2, "kinetic_rotation_J": 0.0}
        energy["potential_J"] = self.mass * self.gravity * position[2]
        return {
            "step": step,
            "time_s": time,
            "mill_angle_rad": self._mill_angle(time),
            **{f"{axis}_m": p for axis, p in zip("xyz", position, strict=True)},
            **{f"v{axis}_m_s": v for axis, v in zip("xyz", velocity, strict=True)},
            **{f"spin_{axis}_rad_s": 0.0 for axis in "xyz"},
            **energy,
            "state": 3 if segment.release else 1,
            **_off_columns(*offs),
            **self._flight_columns(*flights),
            "time_in_flight_s": time - segment.begin if segment.release else 0.0,
        }

    def _state(self, segment: Segment, time: float) -> tuple[np.ndarray, np.ndarray]:
        since = time - segment.begin
        if segment.release:
            return segment.release.position_at(since), segment.release.velocity_at(since)
        if not segment.turning:
            return self.place(0.0), np.zeros(3)
        position = self.place(segment.psi + self.omega * since)
        return position, self.omega * np.array([position[2], 0.0, -position[0]])

    def _mill_angle(self, time: float) -> float:
        return self.omega * max(0.0, time - START)

    def _flight_columns(self, count: int, flight: Segment | None) -> dict[str, float]:
        position = flight.release.position if flight else np.zeros(3)
        velocity = flight.release.velocity if flight else np.zeros(3)
        return {
            "flight_count": count,
            "flight_angle_rad": math.atan2(-position[0], position[2]) if flight else 0.0,
            "flight_mill_angle_rad": self._mill_angle(flight.begin) if flight else 0.0,
            "flight_lifter": 3 if flight else 0,
            **{f"flight_{axis}_m": p for axis, p in zip("xyz", position, strict=True)},
            **{f"flight_v{axis}_m_s": v for axis, v in zip("xyz", velocity, strict=True)},
        }


def _off_columns(count: int, off: Off | None) -> dict[str, float]:
    return {
        "liner_off_count": count,
        "liner_off_angle_rad": off.angle if off else 0.0,
        "liner_off_mill_angle_rad": off.mill_angle if off else 0.0,
        "liner_off_groove": 3 if off else 0,
    }


def usual_motion(case: dict[str, Any], cycles: int = 2) -> Motion:
    """Return two hops at the start, then cycles of lift, throw and three hops down to the bottom.

    Before each throw the ball hops once near the lifter's tip, in the upper half.
    """
    motion = Motion(case)
    motion.hop(0.35, 0.3)
    motion.hop(0.2, 0.2)
    for cycle in range(cycles):
        motion.carry(DETACH + 0.2, leaves_liner_at=LINER_OFF)
        motion.hop(motion.psi + 0.08, 0.06)
        motion.carry(DETACH - math.radians(0.4) * cycle)
        motion.throw()
        motion.hop(-0.8, 0.5)
        motion.hop(-0.35, 0.3)
    motion.carry(math.radians(100.0))
    return motion
