"""A campaign: what the file says, checked, in SI, with every alternative resolved."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from pathlib import Path

from millscale import _core
from millscale.campaign.contacts import ContactOptions
from millscale.campaign.lines import Places
from millscale.liner.given import Given
from millscale.runs.case_file import Ends, Kind, SpeedChange, WallKind


@dataclass(frozen=True)
class Mill:
    """The physical mill. SI units; omega in rad/s. Friction of the end walls; None: the liner's."""

    radius: float
    length: float
    gravity: float
    omega: float
    allow_centrifuging: bool
    ends: Ends = "periodic"
    end_static_friction: float | None = None
    end_rolling_friction: float | None = None


@dataclass(frozen=True)
class LinerShape:
    """Lifters of the physical mill's liner; groove_width or face_angle is None."""

    lifters: int
    lifter_top_radius: float
    lifter_top_width: float
    groove_width: float | None
    face_angle: float | None
    phase: float

    def profile(self, radius: float) -> _core.Profile:
        """Return the liner of the physical mill of a radius [m].

        Raises:
            ValueError: no such liner exists.
        """
        if self.face_angle is not None:
            return _core.Lifters.from_face_angle(
                radius,
                self.lifter_top_radius,
                self.lifter_top_width,
                self.face_angle,
                self.lifters,
                self.phase,
            )
        assert self.groove_width is not None  # as the reader of campaign files has checked
        return _core.Lifters(
            radius,
            self.lifter_top_radius,
            self.lifter_top_width,
            self.groove_width,
            self.lifters,
            self.phase,
        )


Liner = LinerShape | Given


@dataclass(frozen=True)
class LinerState:
    """The liner at a time of its life; hours and tonnes milled are None if not stated."""

    name: str
    hours: float | None
    tonnes: float | None
    liner: Liner


@dataclass(frozen=True)
class BallClass:
    """Balls of one size and material.

    Attributes:
        share: of all balls, by number.
        material: None for that of the campaign.
    """

    radius: float
    density: float
    share: float
    material: Material | None = None

    @property
    def volume(self) -> float:
        """Volume of a ball [m^3]."""
        return 4.0 / 3.0 * math.pi * self.radius**3


@dataclass(frozen=True)
class Ball:
    """Balls, the same in every planned mill. Radii are normal, cut at `truncation` deviations.

    Attributes:
        radius: a, the mean; with classes the mean by mass, sum m a / sum m.
        classes: of several sizes or materials; none: all balls are of one kind.
    """

    radius: float
    density: float
    radius_std: float
    truncation: float
    classes: tuple[BallClass, ...] = ()

    @property
    def smallest(self) -> float:
        """Smallest radius [m]."""
        radii = [one.radius for one in self.classes]
        return min(radii) if radii else self.radius - self.radius_std * self.truncation

    @property
    def largest(self) -> float:
        """Largest radius [m]."""
        radii = [one.radius for one in self.classes]
        return max(radii) if radii else self.radius + self.radius_std * self.truncation

    @property
    def mean_by_number(self) -> float:
        """Mean radius by number of balls [m]."""
        return sum(one.share * one.radius for one in self.classes) or self.radius


@dataclass(frozen=True)
class Material:
    """Elastic constants of balls and wall, and coefficients ball-ball (pp) and ball-wall (pw)."""

    youngs_modulus: float
    poisson_ratio: float
    restitution_pp: float
    restitution_pw: float
    static_friction_pp: float
    static_friction_pw: float
    rolling_friction_pp: float
    rolling_friction_pw: float


@dataclass(frozen=True)
class Wall:
    """How the liner is represented; chord_error is the physical mill's [m]; None: the program's."""

    kind: WallKind
    chord_error: float | None
    axial_divisions: int | None


@dataclass(frozen=True)
class Charge:
    """The charge of a multi-ball part: counts by planned, or filling and porosity.

    Models of S below `seeds_from` take the first seed only.
    """

    counts: tuple[int, ...] | None
    filling: float | None
    porosity: float
    slice_length: float | None
    seeds: tuple[int, ...]
    seeds_from: float

    def seeds_at(self, S: float) -> tuple[int, ...]:
        """Return the seeds of the scaled mills of a radius ratio."""
        return self.seeds if self.seeds_from <= S else self.seeds[:1]


@dataclass(frozen=True)
class CampaignPart:
    """Scaled mills with one kind of charge. Times and the step are those of the physical mill.

    Attributes:
        kind: "single-ball" or "multi-ball".
        ratios: S of the scaled mills.
        schemes, policies: of the similarity law.
        step: time step [s]; None: advised from the limits of the contact law.
        wait: rest (single ball) or settling (multi-ball) before rotation [s].
        rotation_angle, sample_angle, dump_angle, restart_angle: of the mill [rad].
        charge: multi-ball only.
        speed_changes: of `_core.SpeedSchedule`, in the mill's angle.
        ledger: keeps account of the energy; multi-ball only.
        liner_loads: records the loads of the balls on the liner; multi-ball only.
        impacts: records the energy of contacts; multi-ball only.
    """

    kind: Kind
    ratios: tuple[float, ...]
    schemes: tuple[str, ...]
    policies: tuple[str, ...]
    step: float | None
    wait: float
    rotation_angle: float
    sample_angle: float
    dump_angle: float
    restart_angle: float
    charge: Charge | None
    ledger: bool = False
    liner_loads: bool = False
    impacts: bool = False
    speed_changes: tuple[SpeedChange, ...] = ()


@dataclass(frozen=True)
class Campaign:
    """Everything a campaign file says.

    Attributes:
        contacts: between balls.
        friction_exponent: k of policy friction-matched.
        force: model terms that the decks keep although the scene does not need them.
        ranks, jobs: None leaves the number to the machine.
        output_budget: disk that a case may take [bytes].
        warnings: about values that are not used, or unusual.
        states: of the liner over its life; empty: it has one.
        state: the one of `liner`; None if there are none.
        places: lines of the keys in the file, for later mistakes.
    """

    file: Path
    name: str
    about: str
    mill: Mill
    liner: Liner
    ball: Ball
    material: Material
    wall: Wall
    stiffness: str
    contacts: ContactOptions
    force: tuple[str, ...]
    time_factor: float | None
    time_exponent: float | None
    friction_exponent: float
    parts: tuple[CampaignPart, ...]
    ranks: int | None
    jobs: int | None
    output_budget: float
    warnings: tuple[str, ...]
    states: tuple[LinerState, ...] = ()
    state: LinerState | None = None
    places: Places = field(default_factory=Places, compare=False, repr=False)

    def in_each_state(self) -> tuple[Campaign, ...]:
        """Return the campaign with the liner of each state; itself if there are none."""
        if not self.states:
            return (self.with_liner(self.liner),)
        return tuple(self.with_liner(state.liner, state) for state in self.states)

    def with_liner(self, liner: Liner, state: LinerState | None = None) -> Campaign:
        """Return the campaign with a liner, and what there is to say about its file."""
        notes = liner.warnings if isinstance(liner, Given) else ()
        return replace(self, liner=liner, state=state, warnings=(*notes, *self.warnings))
