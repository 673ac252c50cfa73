"""The power models side by side, for a mill or the physical mill of a case."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from millscale.power_models import austin, bond, hogg_fuerstenau, morrell
from millscale.power_models.limits import Limit, outside
from millscale.power_models.mill import Mill
from millscale.runs.case_file import Case

# Voids of a bed whose campaign gives the number of balls: those of a random packing.
USUAL_POROSITY = 0.4


@dataclass(frozen=True)
class PowerModel:
    """A power model.

    Attributes:
        power: returns the power of a mill [W].
        measured_at: the place in the drive that the power is of.
        limits: within which it holds.
    """

    name: str
    power: Callable[[Mill], float]
    measured_at: str
    limits: tuple[Limit, ...]


@dataclass(frozen=True)
class ModelPower:
    """Power that a model gives for a mill.

    Attributes:
        power_w: power [W]; None if the model has no answer, far outside of its limits.
        measured_at: the place in the drive that the power is of.
        outside_of: limits of the model that the mill lies outside of, in words.
    """

    name: str
    power_w: float | None
    measured_at: str
    outside_of: tuple[str, ...]

    @property
    def power_kw(self) -> float | None:
        """Power [kW]."""
        return None if self.power_w is None else 1e-3 * self.power_w


MODELS = (
    PowerModel(
        "Hogg-Fuerstenau", hogg_fuerstenau.hogg_fuerstenau_power, "charge", hogg_fuerstenau.LIMITS
    ),
    PowerModel("Bond", bond.bond_power, "pinion", bond.LIMITS),
    PowerModel("Austin", austin.austin_power, "shaft", austin.LIMITS),
    PowerModel("Morrell C, net", morrell.morrell_net_power, "charge", morrell.LIMITS),
    PowerModel("Morrell C, gross", morrell.morrell_gross_power, "motor", morrell.LIMITS),
)


def models_for(mill: Mill | Case) -> list[ModelPower]:
    """Return what each model gives for a mill, or for the physical mill of a case.

    A single ball has no power: its list is empty.
    """
    if isinstance(mill, Case):
        if mill.kind == "single-ball":
            return []
        mill = mill_of(mill)
    return [_power_of(model, mill) for model in MODELS]


def _power_of(model: PowerModel, mill: Mill) -> ModelPower:
    power: float | None
    try:
        power = model.power(mill)
    except ValueError:
        power = None
    return ModelPower(model.name, power, model.measured_at, outside(model.limits, mill))


def mill_of(case: Case) -> Mill:
    """Return the physical mill of a case with a charge.

    D is twice the radius at the grooves. J is over pi R^2 L, so that M is the mass of the balls:
    it is less than a filling over the volume inside the liner, which lifters reduce.
    """
    physical, S = case.physical, case.S
    whole = physical.length_m / (S * case.mill.simulated_length_m)
    mass = case.ball.count * case.ball.mass_kg * whole * S**3
    given = case.charge.porosity if case.charge else None
    porosity = USUAL_POROSITY if given is None else given
    bulk_density = case.ball.density_kg_m3 * (1.0 - porosity)
    cross_section = math.pi * physical.radius_m**2
    return Mill(
        diameter=2.0 * physical.radius_m,
        length=physical.length_m,
        filling=mass / (bulk_density * cross_section * physical.length_m),
        fraction_of_critical=physical.omega_rad_s
        * math.sqrt(physical.radius_m / physical.gravity_m_s2),
        bulk_density=bulk_density,
        gravity=physical.gravity_m_s2,
    )
