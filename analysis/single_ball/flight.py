"""Flight of a released ball: closed forms and the parabola (no drag, gravity towards -z)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


def impact_angle(phi: float) -> float:
    """Return the angle from the vertical, on the falling side, where the ball returns to its circle
    [rad].

    A ball on a circle (a smooth drum, its centre on R - a) that leaves at `phi` from the vertical,
    where the wall's force vanishes (V^2 = g Rc cos(phi)), returns to the circle at 3 phi.
    Derived here; valid for 0 < phi < pi/2.

    Args:
        phi: angle from the vertical at release, on the rising side [rad].
    """
    return 3.0 * phi


def flight_time(speed: float, phi: float, gravity: float) -> float:
    """Return the time from that release to that impact, 4 V sin(phi) / g [s]. Derived here.

    Args:
        speed: V, of the ball's centre at release [m/s].
        phi: angle from the vertical at release [rad].
        gravity: [m/s^2].
    """
    return 4.0 * speed * np.sin(phi) / gravity


def impact_speed_ratio(phi: float) -> float:
    """Return the speed at that impact over speed at release, sqrt(1 + 8 sin^2(phi)) [-]. Derived
    here."""
    return float(np.sqrt(1.0 + 8.0 * np.sin(phi) ** 2))


@dataclass(frozen=True)
class Release:
    """A released ball.

    Attributes:
        position: (3,) float [m].
        velocity: (3,) float [m/s].
        gravity: towards -z [m/s^2].
    """

    position: np.ndarray
    velocity: np.ndarray
    gravity: float

    def position_at(self, time) -> np.ndarray:
        """Return the position [m], `time` after release [s], (..., 3)."""
        t = np.asarray(time, float)[..., None]
        fall = np.array([0.0, 0.0, -0.5 * self.gravity])
        return np.asarray(self.position) + np.asarray(self.velocity) * t + fall * t**2

    def velocity_at(self, time) -> np.ndarray:
        """Return the velocity [m/s], `time` after release [s], (..., 3)."""
        t = np.asarray(time, float)[..., None]
        return np.asarray(self.velocity) + np.array([0.0, 0.0, -self.gravity]) * t

    def kinetic_change(self, time, mass: float) -> np.ndarray:
        """Return the kinetic energy gained, and potential lost, since release [J]:
        m (-g v_z t + g^2 t^2 / 2)."""
        t = np.asarray(time, float)
        g = self.gravity
        return mass * (-g * self.velocity[2] * t + 0.5 * (g * t) ** 2)

    def time_to_radius(self, radius: float) -> float:
        """Return the first time after release at which the ball's centre is `radius` from the mill
        axis and moves outward [s]; inf if never. A ball released on that circle is not counted at t
        = 0."""
        x, _, z = self.position
        vx, _, vz = self.velocity
        g = self.gravity
        gap = (
            0.25 * g**2,
            -g * vz,
            vx**2 + vz**2 - g * z,
            2.0 * (x * vx + z * vz),
            x**2 + z**2 - radius**2,
        )
        roots = np.roots(gap)
        real = roots.real[abs(roots.imag) < 1e-6 * (1.0 + abs(roots))]
        outward = np.polyval(np.polyder(gap), real) > 0.0
        later = real[(real > 0.0) & outward]
        return float(later.min()) if later.size else np.inf


def release_on_circle(radius: float, phi: float, gravity: float) -> Release:
    """Return the ball of `impact_angle` as it leaves its circle of `radius` [m] at `phi` [rad].

    Its speed is V = sqrt(g Rc cos(phi)), along the rotation: over the top, towards +x.
    """
    speed = np.sqrt(gravity * radius * np.cos(phi))
    return Release(
        radius * np.array([-np.sin(phi), 0.0, np.cos(phi)]),
        speed * np.array([np.cos(phi), 0.0, np.sin(phi)]),
        gravity,
    )
