"""The mill that a power model is evaluated for."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

STANDARD_GRAVITY = 9.81


@dataclass(frozen=True)
class Mill:
    """A cylindrical mill with flat ends and a dry charge. SI units.

    Attributes:
        diameter: D, inside the liner [m].
        length: L, inside the liner [m].
        filling: J, volume of the charge at rest over that of the mill.
        fraction_of_critical: phi, speed over the critical speed of D.
        bulk_density: mass of the charge over its volume at rest, voids included [kg/m^3].
        ball_bulk_density: mass of its balls over the same volume; None if it is balls alone.
        gravity: [m/s^2].

    Raises:
        ValueError: a value that no mill has.
    """

    diameter: float
    length: float
    filling: float
    fraction_of_critical: float
    bulk_density: float
    ball_bulk_density: float | None = None
    gravity: float = STANDARD_GRAVITY

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            share = field.name == "filling"
            if value is None and field.name == "ball_bulk_density":
                continue
            if not 0.0 < value < (1.0 if share else math.inf):
                accepted = "a share above 0 and below 1" if share else "a number above 0"
                raise ValueError(f"{field.name} of a mill: {value!r}; accepted: {accepted}")

    @property
    def radius(self) -> float:
        """R [m]."""
        return 0.5 * self.diameter

    @property
    def omega(self) -> float:
        """Speed of rotation [rad/s]: phi sqrt(g / R)."""
        return self.fraction_of_critical * math.sqrt(self.gravity / self.radius)

    @property
    def mass(self) -> float:
        """Mass of the charge, M [kg]."""
        return self.bulk_density * self._charge_volume

    @property
    def ball_mass(self) -> float:
        """Mass of its balls [kg]."""
        return (self.ball_bulk_density or self.bulk_density) * self._charge_volume

    @property
    def _charge_volume(self) -> float:
        return self.filling * math.pi * self.radius**2 * self.length

    def torque_number(self, power: float) -> float:
        """Return the torque of a power [W] over M g R: the lever arm of the charge over R."""
        return power / (self.omega * self.mass * self.gravity * self.radius)
