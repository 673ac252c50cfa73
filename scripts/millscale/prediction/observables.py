"""What is predicted of a physical mill, in the units people use.

One row for each observable: which measured quantity of the scaled mills it is extrapolated from,
and what a dimensionless number of 1 is in the physical mill. To predict another measured quantity,
add a row.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from millscale.analysis.measures import NUMBERS, Quantity
from millscale.runs.case_file import Case


@dataclass(frozen=True)
class PhysicalMill:
    """The physical mill and its whole charge, SI units.

    Attributes:
        length: along the axis [m].
        balls: in the whole length.
        mass: of the balls [kg].
    """

    radius: float
    length: float
    gravity: float
    omega: float
    lifters: int
    ball_radius: float
    balls: float
    mass: float

    @property
    def torque_scale(self) -> float:
        """M g R [N m]."""
        return self.mass * self.gravity * self.radius

    @property
    def power_scale(self) -> float:
        """M g R omega [W]."""
        return self.torque_scale * self.omega

    @property
    def energy_scale(self) -> float:
        """M (omega R)^2 [J]."""
        return self.mass * (self.omega * self.radius) ** 2


def balls_per_length(case: Case) -> float:
    """Return the balls of the physical mill per length [1/m]: N S^2 / L' of the scaled mill, equal
    in all mills that are filled alike."""
    return case.ball.count * case.S**2 / case.mill.simulated_length_m


def physical_mill(case: Case, balls_per_metre: float) -> PhysicalMill:
    """Return the physical mill of a case.

    Args:
        balls_per_metre: of `balls_per_length`.
    """
    mill = case.physical
    balls = balls_per_metre * mill.length_m
    return PhysicalMill(
        radius=mill.radius_m,
        length=mill.length_m,
        gravity=mill.gravity_m_s2,
        omega=mill.omega_rad_s,
        lifters=mill.lifters,
        ball_radius=mill.ball_radius_m,
        balls=balls,
        mass=balls * case.ball.mass_kg,
    )


@dataclass(frozen=True)
class Observable:
    """A measured quantity, extrapolated to the physical mill.

    Attributes:
        quantity: of `measures.NUMBERS`; its value is a number without units, or in rad.
        unit: in which the physical mill's value is shown.
        scale: returns what a number of 1 is in that unit.
        not_extrapolated: why its value at S = 1 does not follow from scaled mills; empty if it
            does.
    """

    quantity: Quantity
    label: str
    unit: str
    scale: Callable[[PhysicalMill], float]
    digits: int = 3
    not_extrapolated: str = ""

    @property
    def name(self) -> str:
        return self.quantity.name


_BY_NAME = {quantity.name: quantity for quantity in NUMBERS}


def _row(
    name: str,
    label: str,
    unit: str,
    scale: Callable[[PhysicalMill], float],
    digits: int = 3,
    not_extrapolated: str = "",
) -> Observable:
    return Observable(_BY_NAME[name], label, unit, scale, digits, not_extrapolated)


OBSERVABLES = (
    _row("power", "power", "kW", lambda mill: 1e-3 * mill.power_scale),
    _row("torque", "torque", "kN m", lambda mill: 1e-3 * mill.torque_scale),
    _row("kinetic", "kinetic energy of the charge", "kJ", lambda mill: 1e-3 * mill.energy_scale),
    _row("kinetic_rotation", "spin energy of the balls", "kJ", lambda m: 1e-3 * m.energy_scale, 4),
    _row("centre_x", "centre of mass, x", "m", lambda mill: mill.radius),
    _row("centre_z", "centre of mass, z", "m", lambda mill: mill.radius),
    _row("toe_angle_rad", "toe", "deg", lambda _: math.degrees(1.0), 1),
    _row("solid_fraction", "solid fraction of the bed", "-", lambda _: 1.0, 4),
    _row("flying_share", "balls in flight", "%", lambda _: 100.0, 1),
    _row(
        "shoulder_angle_rad",
        "shoulder",
        "deg",
        lambda _: math.degrees(1.0),
        1,
        "measured in a ring one ball diameter wide, it does not change steadily with S",
    ),
    _row(
        "throw_angle_rad",
        "balls thrown at",
        "deg",
        lambda _: math.degrees(1.0),
        1,
        "it changes abruptly near S = 1 in the mills that were tried",
    ),
)
