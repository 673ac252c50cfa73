"""Types of result.json, which holds what the analysis of one case found.

The names of the fields are the keys of the file; their units: docs/reference/files.md.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Any

PAIRINGS = ("ball_ball", "ball_wall")


@dataclass(frozen=True)
class Thrown:
    """The throw of one cycle, as result.json holds it."""

    mill_angle_rad: float
    angle_deg: float
    lifter: int
    position_m: tuple[float, float, float]
    velocity_m_s: tuple[float, float, float]
    flight_length_rad: float
    finished: bool
    liner_off_mill_angle_rad: float | None
    liner_off_angle_deg: float | None

    @property
    def mill_angle_end_rad(self) -> float:
        """Return the mill angle of the last sample in flight [rad]."""
        return self.mill_angle_rad + self.flight_length_rad


@dataclass(frozen=True)
class RegionBounds:
    """Mill angles at which the regions II, III, IV and the next II begin [rad]."""

    settled_rad: float | None
    thrown_rad: float
    impact_rad: float | None
    settled_again_rad: float | None


@dataclass(frozen=True)
class ThrowEnergy:
    """Energy change of the first throw, on its parabola and in the samples."""

    begin_rad: float
    window_rad: float
    change_J: float
    kinetic_sampled_J: float
    potential_sampled_J: float
    off_parabola_kinetic_J: float
    off_parabola_potential_J: float


@dataclass(frozen=True)
class PaperAngles:
    """Energy change between the mill angles of Table 8 or 9 of the paper."""

    begin_rad: float
    end_rad: float
    kinetic_J: float
    potential_J: float
    in_flight: bool


@dataclass(frozen=True)
class SingleBallResult:
    """result.json of a single-ball case; `problem`: why there is no throw."""

    problem: str | None
    cycles: int
    throws: tuple[Thrown, ...]
    detach_angle_deg: float | None
    detach_angle_mean_deg: float | None
    detach_angle_std_deg: float | None
    liner_off_angle_deg: float | None
    liner_off_angle_mean_deg: float | None
    liner_off_angle_std_deg: float | None
    regions: RegionBounds | None
    throw_energy: ThrowEnergy | None
    paper_angles: PaperAngles | None
    unseen_events: int
    rotation_angle_rad: float

    def document(self) -> dict[str, Any]:
        """Return its content of result.json."""
        return _as_json(asdict(self))


@dataclass(frozen=True)
class TorqueBalance:
    """Mean torque of the drive by its two ways [N m]; their difference is over M g R.

    Attributes:
        resting_ends_Nm: torque of resting end walls on the charge; None without them.
    """

    summed_Nm: float
    weight_Nm: float
    angular_momentum_Nm: float
    difference: float
    resting_ends_Nm: float | None = None


@dataclass(frozen=True)
class EndWalls:
    """Power and torque of the end walls in the window of the means.

    Attributes:
        power_W: work of the ends on the charge over time; a part of the power of the drive. Ends at
            rest do no work.
        torque_Nm: on the charge about the axis; positive when it lifts the charge.
        power_share: of the power of the drive; None if that is 0.
    """

    power_W: float
    torque_Nm: float
    power_share: float | None


@dataclass(frozen=True)
class Steadiness:
    """Whether a charge is steady in the window of its means, with the numbers that decide it."""

    is_steady: bool
    reasons: tuple[str, ...]
    centre_x_drift: float | None
    centre_x_drift_error: float | None
    angular_momentum_share: float | None


@dataclass(frozen=True)
class PairingBudget:
    """Terms of the energy budget of one pairing, ball-ball or ball-wall [J]."""

    elastic_normal_J: float
    elastic_tangential_J: float
    dissipated_normal_J: float
    dissipated_tangential_J: float
    dissipated_rolling_J: float
    tangential_dashpot_J: float
    tangential_slip_J: float
    spring_error_J: float
    tangential_spring_J: float
    dissipated_J: float
    impacts: float
    impact_energy_J: float


@dataclass(frozen=True)
class ImpactSpectrum:
    """Impacts per revolution by energy, bin by bin; empty bins are left out."""

    energy_low_J: tuple[float, ...]
    energy_high_J: tuple[float, ...]
    impacts: tuple[float, ...]
    energy_J: tuple[float, ...]


@dataclass(frozen=True)
class EnergyBudget:
    """Energy budget of the last revolution, or of all of a shorter rotation."""

    from_rad: float
    to_rad: float
    duration_s: float
    mill_work_J: float
    kinetic_translation_J: float
    kinetic_rotation_J: float
    potential_J: float
    elastic_J: float
    dissipated_J: float
    spring_error_J: float
    ball_ball: PairingBudget
    ball_wall: PairingBudget
    closure: float
    closure_of_forces: float
    impacts: dict[str, ImpactSpectrum] = field(default_factory=dict)

    @property
    def pairings(self) -> dict[str, PairingBudget]:
        """Return the terms of each pairing by its name."""
        return {name: getattr(self, name) for name in PAIRINGS}


@dataclass(frozen=True)
class LifterForce:
    """Force of the balls on a lifter over a revolution, per length of the mill.

    Attributes:
        lifter: of a sector, in the direction of rotation.
        largest_at_rad: place of the lifter's middle, from the vertical.
        toe_rad, shoulder_rad: between which the force is high; None without a force.
    """

    lifter: int
    mean_N_m: float
    largest_N_m: float
    largest_at_rad: float
    toe_rad: float | None
    shoulder_rad: float | None


@dataclass(frozen=True)
class LinerLoadsResult:
    """Loads of the balls on the liner and its ends, means over the window of liner_loads.csv.

    Attributes:
        torque_Nm: of the balls on the mill about its axis; ends at rest count too.
        slip_share: of each face in the slip work on the liner; None without slip.
        lifters: of a sector; none of a liner without lifters.
    """

    from_rad: float
    to_rad: float
    duration_s: float
    torque_Nm: float
    slip_power_W: float
    normal_dissipation_W: float
    impacts_per_s: float
    impact_power_W: float
    slip_share: dict[str, float | None]
    lifters: tuple[LifterForce, ...]


@dataclass(frozen=True)
class EnergyBins:
    """Contacts per second by their energy, bin by bin; empty bins are left out.

    Attributes:
        contacts_per_s, power_W: contacts that end in a second, and the sum of their energy.
    """

    energy_low_J: tuple[float, ...] = ()
    energy_high_J: tuple[float, ...] = ()
    contacts_per_s: tuple[float, ...] = ()
    power_W: tuple[float, ...] = ()

    def rows(self) -> list[tuple[float, ...]]:
        """Return the bins: low, high, contacts per second, power."""
        columns = (self.energy_low_J, self.energy_high_J, self.contacts_per_s, self.power_W)
        return list(zip(*columns, strict=True))


@dataclass(frozen=True)
class ContactClass:
    """Spectra of the contacts of two classes of balls, or of a class with the liner.

    Attributes:
        ball_class, other_class: from 1; other_class None: liner and ends.
        dissipated, available: by the energy a contact dissipates, and by that of its approach.
    """

    pairing: str
    ball_class: int
    other_class: int | None
    dissipated: EnergyBins
    available: EnergyBins


@dataclass(frozen=True)
class PairingImpacts:
    """Impacts of one pairing of bodies.

    Attributes:
        contacts_per_s: contacts that end.
        available_W: energy of their approach, per second.
        ended_W, lasting_W: dissipated by contacts that end; by those that last, as the change over
            the window of what they have dissipated.
        dissipated_W: by all contacts, summed in the kernels without regard to contacts.
        sum_error: of the first two against the third, relative.
    """

    contacts_per_s: float
    available_W: float
    ended_W: float
    lasting_W: float
    dissipated_W: float
    sum_error: float


@dataclass(frozen=True)
class ImpactsResult:
    """Impacts of the last revolution, or of the second half of a rotation of less than two.

    Attributes:
        energy_unit_J: m (omega R)^2, m the mean mass of a ball.
    """

    from_rad: float
    to_rad: float
    duration_s: float
    energy_unit_J: float
    ball_ball: PairingImpacts
    ball_wall: PairingImpacts
    classes: tuple[ContactClass, ...]

    @property
    def pairings(self) -> dict[str, PairingImpacts]:
        """Return the impacts of each pairing by its name."""
        return {name: getattr(self, name) for name in PAIRINGS}


@dataclass(frozen=True)
class ChargeResult:
    """result.json of a multi-ball case.

    Attributes:
        mean_from_rad, mean_to_rad: mill angles between which means are taken.
        pitches: whole lifter pitches between them.
        mean: means in SI units, by name.
        dimensionless: means over the scales of the charge, by name.
        standard_error: of some of `dimensionless`; None without pitches.
        ledger: the energy budget; None where none was kept.
        ends: of end walls; None with periodic ends.
        liner_slip: of the balls on the liner; None where the series lacks it.
        segregation: radial index of each class of balls; None of one class.
        liner_loads, impacts: None where none were recorded.
    """

    problem: str | None
    mean_from_rad: float
    mean_to_rad: float
    pitches: int
    mean: dict[str, float]
    dimensionless: dict[str, float]
    standard_error: dict[str, float | None]
    torque_balance: TorqueBalance
    alternating_torque: float
    steady: Steadiness
    largest_overlap_over_radius: float | None
    rotation_angle_rad: float
    ledger: EnergyBudget | None = None
    ends: EndWalls | None = None
    liner_slip: float | None = None
    segregation: tuple[float, ...] | None = None
    liner_loads: LinerLoadsResult | None = None
    impacts: ImpactsResult | None = None

    def document(self) -> dict[str, Any]:
        """Return its content of result.json."""
        content = _as_json(asdict(self))
        for absent in ("ledger", "ends", "segregation", "liner_loads", "impacts"):
            if content[absent] is None:
                del content[absent]
        if self.torque_balance.resting_ends_Nm is None:
            del content["torque_balance"]["resting_ends_Nm"]
        return content


def _as_json(value: Any) -> Any:
    """Return nested values with the types that JSON text is read into."""
    if isinstance(value, dict):
        return {key: _as_json(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_as_json(inner) for inner in value]
    return value
