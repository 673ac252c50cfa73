"""The physical mill of a scaled mill, with its whole charge; its power from a scaled mill."""

from __future__ import annotations

from dataclasses import dataclass

from millscale.analysis.finished import Charge
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


def physical_power(charge: Charge) -> float:
    """Return the power of the physical mill and its whole charge by one scaled mill [W].

    M g R omega of the physical mill times the scaled mill's dimensionless power.
    """
    mill = physical_mill(charge.case, balls_per_length(charge.case))
    return mill.power_scale * charge.result.dimensionless["power"]
