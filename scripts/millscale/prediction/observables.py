"""What is predicted of a physical mill, in the units people use.

One row for each observable: which measured quantity of the scaled mills it is extrapolated from,
what makes its error, and what a dimensionless number of 1 is in the physical mill. To predict
another measured quantity, add a row.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from millscale.analysis.charge.groove_flow import groove_flow
from millscale.analysis.charge.physical_mill import PhysicalMill
from millscale.analysis.charge.result import charge_scales
from millscale.analysis.finished import Charge
from millscale.analysis.measures import NUMBERS
from millscale.analysis.result_file import PAIRINGS
from millscale.prediction.kinds import Kind
from millscale.prediction.mass_flow import box_refused

Numbers = Mapping[str, float | None]


@dataclass(frozen=True)
class Observable:
    """A measured quantity, extrapolated to the physical mill.

    Attributes:
        read: returns it from a charge and the numbers of `measures.NUMBERS` by name: a number
            without units, or in rad; None if the charge lacks it.
        unit: in which the physical mill's value is shown.
        scale: returns what a number of 1 is in that unit.
        kind: what makes its error, which gives the prior of the exponent.
        restates: name of the observable whose value it is in another unit; empty if it has its own.
        refuse: returns why its value at S = 1 does not follow from these charges; empty if it does.
    """

    name: str
    label: str
    unit: str
    scale: Callable[[PhysicalMill], float]
    kind: Kind
    read: Callable[[Charge, Numbers], float | None]
    restates: str = ""
    refuse: Callable[[Sequence[Charge]], str] | None = None

    @property
    def measured_as(self) -> str:
        """Return the name of the observable that has its number."""
        return self.restates or self.name


_MEASURES = frozenset(quantity.name for quantity in NUMBERS)


def _row(
    name: str,
    label: str,
    unit: str,
    scale: Callable[[PhysicalMill], float],
    kind: Kind,
    restates: str = "",
) -> Observable:
    """Return an observable that is a row of `measures.NUMBERS`."""
    key = restates or name
    assert key in _MEASURES, key

    def read(_: Charge, numbers: Numbers) -> float | None:
        return numbers[key]

    return Observable(name, label, unit, scale, kind, read, restates)


def _kilo(scale: Callable[[PhysicalMill], float]) -> Callable[[PhysicalMill], float]:
    return lambda mill: 1e-3 * scale(mill)


def _power(mill: PhysicalMill) -> float:
    return mill.power_scale


def _energy(mill: PhysicalMill) -> float:
    return mill.energy_scale


def _radius(mill: PhysicalMill) -> float:
    return mill.radius


def _degree(_: PhysicalMill) -> float:
    return math.degrees(1.0)


OBSERVABLES = (
    _row("power", "power", "kW", _kilo(_power), Kind.FRICTION),
    _row(
        "specific_power",
        "power over mass of balls",
        "kW/t",
        lambda mill: mill.power_scale / mill.mass,
        Kind.FRICTION,
        restates="power",
    ),
    _row(
        "torque",
        "torque",
        "kN m",
        lambda mill: 1e-3 * mill.torque_scale,
        Kind.FRICTION,
        restates="power",
    ),
    _row("kinetic", "kinetic energy of the charge", "kJ", _kilo(_energy), Kind.FRICTION),
    _row("kinetic_rotation", "spin energy of the balls", "kJ", _kilo(_energy), Kind.DILATION),
    _row("centre_x", "centre of mass, x", "m", _radius, Kind.FRICTION),
    _row("centre_z", "centre of mass, z", "m", _radius, Kind.SHAPE),
    _row("toe_angle_rad", "toe", "deg", _degree, Kind.SHAPE),
    _row("solid_fraction", "solid fraction of the bed", "-", lambda _: 1.0, Kind.DILATION),
    _row("flying_share", "balls in flight", "%", lambda _: 100.0, Kind.DILATION),
    Observable(
        "mass_flow",
        "mass flow in the grooves at the bottom",
        "kg/s",
        lambda mill: mill.mass * mill.omega,
        Kind.DILATION,
        lambda charge, _: groove_flow(charge),
        refuse=box_refused,
    ),
    _row("shoulder_angle_rad", "shoulder", "deg", _degree, Kind.SHAPE),
    _row("curtain_share", "balls in curtains", "%", lambda _: 100.0, Kind.SHAPE),
    _row(
        "curtain_width",
        "width of the curtains",
        "m",
        lambda mill: mill.radius - mill.ball_radius,
        Kind.SHAPE,
    ),
    _row("throw_angle_rad", "balls thrown at", "deg", _degree, Kind.UNKNOWN),
)


def _dissipated(pairing: str, term: str) -> Observable:
    """Return the power that contacts of a pairing dissipate by one cause."""

    def read(charge: Charge, _: Numbers) -> float | None:
        ledger = charge.result.ledger
        if ledger is None:
            return None
        energy = getattr(ledger.pairings[pairing], f"dissipated_{term}_J")
        return float(energy / ledger.duration_s / charge_scales(charge.case, charge.series).power)

    words = f"dissipated, {pairing.replace('_', '-')}, {term}"
    return Observable(
        f"dissipated_{pairing}_{term}", words, "kW", _kilo(_power), Kind.UNKNOWN, read
    )


# Of charges with an energy budget.
DISSIPATION = tuple(
    _dissipated(pairing, term)
    for pairing in PAIRINGS
    for term in ("normal", "tangential", "rolling")
)


def observables_of(charges: Sequence[Charge]) -> tuple[Observable, ...]:
    """Return what is predicted from charges."""
    has_budget = any(charge.result.ledger is not None for charge in charges)
    return (*OBSERVABLES, *(DISSIPATION if has_budget else ()))


def kind_of(name: str) -> Kind:
    """Return the kind of an observable by its name."""
    return next(row.kind for row in (*OBSERVABLES, *DISSIPATION) if row.name == name)
