"""case.json: every number of a case, in SI units. Its types, how it is read, and how it is written.

A case.json may be damaged, or written to do harm. Words of it go into decks, which can run
programs, so they hold only letters, digits, hyphens and underscores. Numbers are finite, and counts
have limits. Keys that no section names are not read.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Final, Literal

import msgspec
from msgspec import Meta, Struct

from millscale.runs.case_digest import case_digest, case_identity
from millscale.runs.layout import CASE_FILE
from millscale.runs.typed import as_typed
from millscale.runs.untrusted import ID, RunFolderError, read_object

SCHEMA: Final = 1
LARGEST_FILE_BYTES = 1 << 20
MOST_BALLS, MOST_STEPS, MOST_RANKS = 10**9, 10**15, 10**5
REMEDY = "write it again with: millscale generate FILE --runs DIR"

# A word of a deck: `liner.stl`, `history`, `constant-gravity`.
DECK_WORD = r"^[a-z][a-z0-9_-]{0,40}(\.[a-z]{1,8})?\Z"

_BOUND = 1e300
Number = Annotated[float, Meta(gt=-_BOUND, lt=_BOUND, description="a finite number")]
Positive = Annotated[float, Meta(gt=0.0, lt=_BOUND, description="a finite number > 0")]
Word = Annotated[str, Meta(pattern=DECK_WORD, description="a plain word")]
Steps = Annotated[int, Meta(ge=0, le=MOST_STEPS)]
Interval = Annotated[int, Meta(ge=1, le=MOST_STEPS)]
Lifters = Annotated[int, Meta(ge=0, le=10**4)]
ProfileNode = tuple[
    Number, Number, Number, Annotated[int, Meta(ge=0, le=3)], Annotated[int, Meta(ge=0, le=1)]
]
Kind = Literal["single-ball", "multi-ball"]
Ends = Literal["periodic", "turning", "resting"]
# Of `_core.SpeedSchedule`: mill angle at which a change of the speed begins, mill angle that it
# takes [rad], speed afterwards over that of the mill.
SpeedChange = tuple[Number, Number, Positive]
WallKind = Literal["analytic", "mesh"]
Surface = Literal["fast", "default"]
Precision = Literal["double", "mixed"]
Switch = Literal["on", "off"]


class Section(Struct, frozen=True, kw_only=True, omit_defaults=True):
    """A part of case.json. Keys that a file may lack have a default, and are not written then."""


class PhysicalMill(Section, frozen=True):
    """The physical mill; `face_angle_deg` of the lifters' faces from their centre line."""

    radius_m: Positive
    ball_radius_m: Positive
    gravity_m_s2: Positive
    omega_rad_s: Positive
    length_m: Positive
    lifter_top_radius_m: Number
    lifter_top_width_m: Number
    groove_width_m: Number
    lifters: Lifters
    face_angle_deg: Number

    @property
    def percent_of_critical(self) -> float:
        """Return the speed in % of sqrt(g / (R - a)). That of a scaled mill differs with a / R."""
        critical = math.sqrt(self.gravity_m_s2 / (self.radius_m - self.ball_radius_m))
        return 100.0 * self.omega_rad_s / critical


class Mill(Section, frozen=True):
    """The scaled mill, its operating point and the numbers that follow from it.

    Attributes:
        simulated_length_m: of the piece that is simulated, between its ends.
        detach_angle_deg: of a point mass, from the vertical; None if the mill centrifuges.
        phase_rad: of groove 0 from the bottom, at rest.
        area_m2: of the cross-section inside the liner.
        profile: nodes of `_core.Profile`, of a liner that is not of trapezoidal lifters.
        ends: along the axis; turning and resting ones are walls.
        end_static_friction, end_rolling_friction: of ball and end wall, if it has its own.
    """

    radius_m: Positive
    length_m: Positive
    simulated_length_m: Positive
    gravity_m_s2: Positive
    omega_rad_s: Positive
    froude: Number
    critical_speed_rad_s: Number
    percent_of_critical: Number
    detach_angle_deg: Number | None
    regime: str
    lifter_top_radius_m: Number
    lifter_top_width_m: Number
    groove_width_m: Number
    lifters: Lifters
    face_angle_deg: Number
    phase_rad: Number
    area_m2: Number
    profile: tuple[ProfileNode, ...] | None = None
    ends: Ends = "periodic"
    end_static_friction: Number | None = None
    end_rolling_friction: Number | None = None


class LinerFile(Section, frozen=True):
    """The file that states the liner, as it was; `mill.profile` is what was made of it."""

    name: str
    sha256: str


class LinerState(Section, frozen=True):
    """The liner at a time of its life."""

    name: Annotated[str, Meta(pattern=DECK_WORD)]
    hours: Number | None = None
    tonnes: Number | None = None


class Factors(Section, frozen=True):
    """Factors scaled / physical of the similarity law.

    Attributes:
        friction: of the sliding friction between balls; of policy friction-matched only.
    """

    length: Number
    mass: Number
    time: Number
    energy: Number
    friction: Positive | None = None


class Groups(Section, frozen=True):
    """Ratios to the ball size, which no policy keeps.

    Attributes:
        length_over_mill_radius: of a mill with end walls; that of the physical mill is kept.
    """

    ball_radius_over_mill_radius: Number
    lifter_height_over_ball_diameter: Number
    groove_width_over_ball_diameter: Number
    length_over_ball_diameter: Number
    length_over_mill_radius: Number | None = None


class Material(Section, frozen=True):
    """Elastic constants and coefficients, ball-ball (pp) and ball-wall (pw)."""

    youngs_modulus_pa: Positive
    shear_modulus_pa: Number
    poisson_ratio: Number
    restitution_pp: Number
    restitution_pw: Number
    static_friction_pp: Number
    static_friction_pw: Number
    rolling_friction_pp: Number
    rolling_friction_pw: Number
    stiffness: str


class BallClass(Section, frozen=True):
    """Balls of one size and material; `material` if it is not that of the case."""

    radius_m: Positive
    density_kg_m3: Positive
    count: Annotated[int, Meta(ge=1, le=MOST_BALLS)]
    material: Material | None = None


class Balls(Section, frozen=True):
    """The balls; radii are normally distributed, cut at `truncation` standard deviations.

    Attributes:
        radius_m: the mean; with classes the mean by mass.
        mass_kg: mean over the balls.
        start_m: centre at the start, (x, y, z); of a single ball only.
        classes: of a charge of several sizes or materials.
    """

    radius_m: Positive
    density_kg_m3: Positive
    mass_kg: Positive
    radius_std_m: Number
    truncation: Number
    count: Annotated[int, Meta(ge=1, le=MOST_BALLS)]
    start_m: tuple[Number, Number, Number] | None = None
    classes: Annotated[tuple[BallClass, ...], Meta(max_length=100)] = ()


class Times(Section, frozen=True):
    """The time step, its limits, and the durations of the case.

    Attributes:
        step_choice: "given", or "advised" with the limit that binds.
        start_s: simulated time at which the mill starts to turn.
        steps, duration_s: of the run that turns the mill: rest and rotation of a single ball,
            rotation of a charge.
        limit_fraction: step over `damping_limit_s`.
        speed_changes: ramp and steps of the speed; none: at full speed from the start.
    """

    step_s: Positive
    step_choice: str
    rest_steps: Steps
    settle_steps: Steps
    rotation_steps: Steps
    start_s: Number
    rotation_angle_rad: Number
    duration_s: Number
    steps: Interval
    sample_angle_rad: Number
    rayleigh_time_s: Number
    rayleigh_fraction: Number
    damping_limit_s: Number
    limit_fraction: Number
    mean_overlap_m: Number
    impact_speed_m_s: Number
    collision_time_s: Number
    steps_per_contact: Number
    speed_changes: tuple[SpeedChange, ...] = ()


class Charge(Section, frozen=True):
    """The charge as the campaign gives it; `filling` and `porosity` are None if it gives a count.

    Attributes:
        solid_fraction: volume of the balls over that of the mill.
        slice_length_m: None for the whole length of the mill.
    """

    filling: Number | None
    porosity: Number | None
    solid_fraction: Number
    slice_length_m: Number | None
    settle_s: Number


class Wall(Section, frozen=True):
    """How the liner is represented; `curvature_deg` of a mesh only."""

    kind: WallKind
    chord_error_m: Number
    axial_divisions: Annotated[int, Meta(ge=1, le=10**4)]
    triangles: Annotated[int, Meta(ge=0, le=10**9)]
    curvature_deg: Number | None = None


class Deck(Section, frozen=True, forbid_unknown_fields=True):
    """Values of the switches of the decks. A switch of another version cannot be obeyed, so that
    unknown keys are refused."""

    pair: Word
    rolling_model_pp: Word
    rolling_model_pw: Word
    tangential_model_pp: Word
    tangential_model_pw: Word
    dumps: Switch
    surface: Surface
    tangential_damping: Word
    wall_damping: Word | None = None
    precision: Precision = "double"
    ledger: Switch = "off"
    liner_loads: Switch = "off"
    impacts: Switch = "off"


class Domain(Section, frozen=True):
    """The engine's box around the mill, and its neighbour skin."""

    half_box_m: Positive
    skin_m: Number


class Output(Section, frozen=True):
    """Steps and mill angles between outputs."""

    thermo_steps: Interval
    sample_steps: Interval
    dump_angle_rad: Number
    dump_steps: Interval
    restart_angle_rad: Number
    restart_steps: Interval


class Statement(Section, frozen=True):
    """A part of the physics, and why it is modelled or left out."""

    what: str
    reason: str


class Modelled(Section, frozen=True, rename={"inside": "in", "outside": "out"}):
    """What the case models (`in`), and what it leaves out (`out`)."""

    inside: tuple[Statement, ...]
    outside: tuple[Statement, ...]


class Predicted(Section, frozen=True):
    """Cost on one core."""

    particle_steps: int
    ranks: int
    wall_time_s: Number
    output_bytes: int


class Case(Section, frozen=True, kw_only=True):
    """One case: one scaled mill to simulate, every number of it resolved. SI units.

    Attributes:
        time_factor: scaled / physical time of scheme froude; else 0.
        friction_exponent: k of a scaled mill of policy friction-matched; None stands for 1.
        seed: of the initial packing; 0 for a single ball.
        predicted_energy_ratio, centre_path_energy_ratio: energy change of one ball, scaled /
            physical, of a point mass and of the ball's centre on its path R - a.
        charge: of a multi-ball case only.
        liner_file: of a liner that a file states.
        liner_state: of a liner that the campaign states at several times of its life.
        digest: hash of all that decides the case. Of a case that was read, hash of what was read.
    """

    schema: Literal[1]
    id: Annotated[str, Meta(pattern=ID, description="such as sb-cg-paper-S1.000")]
    campaign: str
    kind: Kind
    scheme: Word
    policy: Word
    S: Positive
    time_factor: Number
    friction_exponent: Positive | None = None
    allow_centrifuging: bool
    seed: Annotated[int, Meta(ge=0, le=10**9)]
    physical: PhysicalMill
    mill: Mill
    factors: Factors
    predicted_energy_ratio: Number
    centre_path_energy_ratio: Number
    groups: Groups
    ball: Balls
    material: Material
    time: Times
    charge: Charge | None = None
    liner_file: LinerFile | None = None
    liner_state: LinerState | None = None
    wall: Wall
    deck: Deck
    domain: Domain
    output: Output
    warnings: tuple[str, ...]
    model: Modelled
    versions: dict[str, str]
    predicted: Predicted
    digest: Annotated[str, Meta(pattern=r"^[0-9a-f]{64}\Z", description="a SHA-256")]

    @property
    def is_physical(self) -> bool:
        """Whether the case is the physical mill: the same in all schemes and policies."""
        return abs(self.S - 1.0) < 1e-9

    @property
    def identity(self) -> str:
        """Hash of all that decides the case but its names: equal for the same case elsewhere."""
        # Read back: a default that a campaign states is written, but not by a case that is read.
        return case_identity(as_typed(Case, self.document).document)

    @property
    def document(self) -> dict[str, Any]:
        """Content of case.json as JSON types, sections by name."""
        document: dict[str, Any] = msgspec.to_builtins(self)
        return document

    def text(self) -> str:
        """Return case.json as it is written."""
        return json.dumps(self.document, indent=2, allow_nan=False) + "\n"


def load_case(folder: Path) -> Case:
    """Return the case of a case folder.

    Raises:
        RunFolderError: no case.json, or not one of this schema; names the first wrong key.
    """
    path = Path(folder) / CASE_FILE
    return case_of(path, read_object(path, REMEDY, LARGEST_FILE_BYTES))


def case_of(path: Path, document: dict[str, Any]) -> Case:
    """Return the case of the content of a case.json.

    Args:
        path: of the file, for messages.

    Raises:
        RunFolderError: names the first key that is not accepted.
    """
    try:
        case = as_typed(Case, document)
    except ValueError as error:
        raise RunFolderError(path, str(error), REMEDY) from None
    if case.wall.kind == "mesh" and case.wall.curvature_deg is None:
        raise RunFolderError(path, "wall.curvature_deg is missing, of a mesh", REMEDY)
    return msgspec.structs.replace(case, digest=case_digest(document))


def is_outdated(campaign: Mapping[str, Any], case: Case) -> bool:
    """Return whether the campaign was edited after case.json was written.

    Args:
        campaign: content of campaign.json, which holds the digests of the cases as they should be.
    """
    wanted = campaign.get("digests")
    if not isinstance(wanted, Mapping) or case.id not in wanted:
        return False
    return bool(wanted[case.id] != case.digest)
