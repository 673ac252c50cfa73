"""Every key of a campaign file: type, range, default, meaning. All defaults live here."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from millscale.campaign.contacts import DAMPINGS, PRECISIONS, SURFACES
from millscale.campaign.units import UNITS, split_unit
from millscale.liner.given import PRESETS
from millscale.liner.lengths import LENGTHS
from millscale.liner.sector import CLOCKWISE, COUNTER
from millscale.runs.case_file import Ends, Kind


class Required:
    """Marks a key that has no default."""

    def __repr__(self) -> str:
        return "required"


REQUIRED: Final = Required()
SCHEMES: Final = ("constant-gravity", "constant-speed", "froude")
FRICTION_MATCHED: Final = "friction-matched"
POLICIES: Final = ("paper", "corrected", "offset-liner", FRICTION_MATCHED)
READINGS: Final = ("trapezoid", "parallel")
ENDS: Final[tuple[Ends, ...]] = ("periodic", "turning", "resting")
STIFFNESSES: Final = ("fixed", "overlap-matched")
KINDS: Final[dict[str, Kind]] = {"single_ball": "single-ball", "multi_ball": "multi-ball"}
ADVISED: Final = "advised"
# Terms of the decks that a scene may do without (deck_terms decides), and `force` puts in.
FORCIBLE: Final = ("pair", "rolling", "history", "dumps")

# Smallest and largest size of a quantity, by the unit that ends its key: from mills of sand to
# mills on any planet. A number beyond is a slip, and products of a few leave floating point.
SIZES: Final = {
    "_kg_m3": (1e-3, 1e6),
    "_m_s2": (1e-9, 1e9),
    "_rad_s": (1e-9, 1e6),
    "_percent": (1e-6, 1e6),
    "_rpm": (1e-9, 1e7),
    "_deg": (1e-9, 1e9),
    "_rad": (1e-9, 1e9),
    "_pa": (1.0, 1e15),
    "_m": (1e-6, 1e6),
    "_s": (1e-12, 1e9),
    "": (1e-9, 1e9),
}


def size_range(key: str) -> tuple[float, float]:
    """Return the smallest and largest size that a key accepts, in the unit that ends the key."""
    suffix = split_unit(key)[1]
    if suffix in SIZES or suffix not in UNITS:
        return SIZES.get(suffix, SIZES[""])
    unit = UNITS[suffix]
    for other, sizes in SIZES.items():
        si = UNITS.get(other)
        if si and si.dimension == unit.dimension and si.numerator == si.denominator:
            factor = unit.denominator / unit.numerator
            return sizes[0] * factor, sizes[1] * factor
    return SIZES[""]


@dataclass(frozen=True)
class Key:
    """What a key accepts.

    Attributes:
        type: "number", "integer", "flag" or "text".
        meaning: what the key is, for the reference and the messages.
        default: value of an absent key; None if it may be absent, REQUIRED if it may not.
        above, least, most: bounds, `above` exclusive.
        choices: words accepted; beside numbers if the type is "number".
        many: a list of such values.
    """

    type: str
    meaning: str
    default: Any = None
    above: float | None = None
    least: float | None = None
    most: float | None = None
    choices: tuple[str, ...] = ()
    many: bool = False

    def accepted(self) -> str:
        """Return the accepted values in words."""
        bounds = [
            f"{sign} {bound:g}"
            for sign, bound in ((">", self.above), (">=", self.least), ("<=", self.most))
            if bound is not None
        ]
        what = {"number": "number", "integer": "whole number", "text": "text"}.get(self.type, "")
        what = f"{what}s" if self.many else f"a {what}"
        words = [f'"{choice}"' for choice in self.choices]
        if self.type == "flag":
            words = ["true", "false"]
        elif self.type != "text" or not words:
            words = [f"{what} {' and '.join(bounds)}".strip(), *words]
        return ("a list of " if self.many else "") + " or ".join(words)


@dataclass(frozen=True)
class Table:
    """An array of tables, such as `[[ball.class]]`; every entry has these keys.

    Attributes:
        meaning: what an entry is, for the reference and the messages.
        most: entries accepted.
    """

    meaning: str
    keys: Mapping[str, Key]
    most: int = 1000


def _positive(meaning: str, default: Any = None) -> Key:
    return Key("number", meaning, default, above=0.0)


def _share(meaning: str, default: Any = REQUIRED, least: float = 0.0) -> Key:
    return Key("number", meaning, default, least=least, most=1.0)


def _friction(meaning: str) -> Key:
    return Key("number", meaning, REQUIRED, least=0.0, most=10.0)


def _schemes(default: Any) -> Key:
    return Key("text", "similarity schemes", default, choices=SCHEMES, many=True)


def _policies(default: Any) -> Key:
    meaning = "what the law changes because the balls are not scaled"
    return Key("text", meaning, default, choices=POLICIES, many=True)


def _models() -> dict[str, Key]:
    ratio = "radius ratios of the scaled mills, S = physical / scaled radius"
    radius = "the same as radii of the scaled mills at the liner, R / S [m]"
    return {
        "S": Key("number", ratio, least=1.0, many=True),
        "scaled_radius_m": Key("number", radius, above=0.0, many=True),
    }


def _study(step: float | str, sample: float, restart: float, ramp: float) -> dict[str, Key]:
    """Return the keys that [single_ball] and [multi_ball] share."""
    return {
        **_models(),
        "schemes": _schemes(None),
        "policies": _policies(None),
        "rotation_angle_rad": _positive("mill rotation to simulate [rad]"),
        "revolutions": _positive("the same in turns"),
        "rotation_s": _positive("the same as time of the physical mill [s]"),
        "step_s": Key(
            "number",
            "time step of the physical mill [s], or from the limits of the contact law",
            step,
            above=0.0,
            choices=(ADVISED,),
        ),
        "sample_angle_rad": _positive("mill rotation between rows of series.csv [rad]", sample),
        "dump_angle_rad": _positive(
            "mill rotation between dumps [rad]; default: 0.5, or all of a shorter rotation"
        ),
        "restart_angle_rad": _positive("mill rotation between restart files [rad]", restart),
        "ramp_turns": Key(
            "number",
            "turns of the mill from rest to its speed, evenly accelerated; 0: at once",
            ramp,
            least=0.0,
            most=100.0,
        ),
    }


def _of_a_file() -> dict[str, Key]:
    """Return the keys about a file with a liner, of [liner] and [[liner.state]]."""
    return {
        "unit": Key("text", "of the file, if it does not state one", choices=tuple(LENGTHS)),
        "layer": Key("text", "of a drawing; default: all of them"),
        "turns": Key(
            "text",
            "direction of rotation in the file, x to the right and y up; needed if the lifters "
            "are not symmetric",
            choices=(CLOCKWISE, COUNTER),
        ),
        "tolerance_m": _positive("points are replaced by lines and arcs within this [m]"),
        "centre_x_m": Key("number", "where the axis is in the file [m]; default: 0"),
        "centre_y_m": Key("number", "the same [m]; default: 0"),
    }


SECTIONS: Final[dict[str, dict[str, Key]]] = {
    "campaign": {
        "name": Key("text", "lower-case letters, digits and hyphens; default: the file's name"),
        "about": Key("text", "one line for the report", ""),
    },
    "mill": {
        "radius_m": _positive("R, at the liner between the lifters [m]", REQUIRED),
        "length_m": _positive("length of the mill along its axis [m]", REQUIRED),
        "gravity_m_s2": _positive("g [m/s^2]", 9.81),
        "speed_rad_s": _positive("speed of rotation [rad/s]"),
        "speed_rpm": _positive("the same in turns per minute"),
        "period_s": _positive("the same as time of a turn [s]"),
        "percent_of_critical": _positive("the same in % of sqrt(g / (R - a))"),
        "froude": _positive("the same as omega^2 R / g"),
        "ends": Key(
            "text",
            "periodic: a piece of a long mill; turning: end walls fixed to the mill; resting: end "
            "walls at rest",
            "periodic", choices=ENDS,
        ),
        "end_static_friction": Key(
            "number", "Coulomb friction of ball and end wall; default: static_friction_pw",
            least=0.0, most=10.0,
        ),
        "end_rolling_friction": Key(
            "number", "rolling friction of ball and end wall; default: rolling_friction_pw",
            least=0.0, most=1.0,
        ),
        "allow_centrifuging": Key("flag", "accept a Froude number of 1 or more", False),
    },
    "liner": {
        "lifters": Key("integer", "number of lifters, 0: a plain drum", 0, least=0, most=1000),
        "lifter_top_radius_m": _positive("r, from the axis to the lifter tops [m]"),
        "lifter_height_m": _positive(
            "the same as height of the lifters, R - r; of a preset also of waves or steps [m]"
        ),
        "lifter_top_width_m": _positive("D1, width of a lifter top [m]"),
        "groove_width_m": _positive("D2, chord of a groove at the liner [m]"),
        "face_angle_deg": Key(
            "number", "angle of a face from the lifter's centre line, instead of D2",
            least=0.0, most=89.0,
        ),
        "reading": Key(
            "text", "shape of a lifter; parallel: D1 is its width down to the liner", "trapezoid",
            choices=READINGS
        ),
        "phase_deg": Key(
            "number", "angle of groove 0 from the bottom at rest", 0.0, least=-360.0, most=360.0
        ),
        "preset": Key("text", "family of liners with few numbers", choices=PRESETS),
        "trailing_angle_deg": Key(
            "number", "angle of the trailing face of preset ship-lap", least=0.0, most=85.0
        ),
        "edge_radius_m": _positive("radius of the lifters' edges, of a preset [m]"),
        "profile": Key("text", "file with the cross-section, .csv or .dxf"),
        "stl": Key("text", "file with a shell of triangles, prismatic along an axis"),
        **_of_a_file(),
    },
    "ball": {
        "radius_m": _positive("a, mean ball radius [m]; or classes, sizes, a top-up size"),
        "sizes": Key("text", "file with a table of the classes, beside the campaign, .csv"),
        "top_up_radius_m": _positive("radius of the balls added to Bond's equilibrium charge [m]"),
        "top_up_classes": Key("integer", "classes of that charge", 4, least=2, most=20),
        "density_kg_m3": _positive("density [kg/m^3]", REQUIRED),
        "radius_std_m": Key(
            "number", "standard deviation of normally distributed radii, multi-ball [m]",
            0.0, least=0.0,
        ),
        "truncation": Key("number", "radii kept, in standard deviations", 2.0, above=0.0, most=6.0),
    },
    "material": {
        "shear_modulus_pa": _positive("G of balls and wall [Pa]"),
        "youngs_modulus_pa": _positive("E = 2 G (1 + nu) of balls and wall [Pa]"),
        "poisson_ratio": Key("number", "nu of balls and wall", REQUIRED, least=0.0, most=0.5),
        # The engine refuses restitutions below 0.05.
        "restitution_pp": _share("restitution, ball-ball", least=0.05),
        "restitution_pw": _share("restitution, ball-wall", least=0.05),
        "static_friction_pp": _friction("Coulomb friction, ball-ball"),
        "static_friction_pw": _friction("Coulomb friction, ball-wall"),
        "rolling_friction_pp": _share("rolling friction, ball-ball"),
        "rolling_friction_pw": _share("rolling friction, ball-wall"),
    },
    "scaling": {
        **_models(),
        "schemes": _schemes(SCHEMES[:2]),
        "policies": _policies(POLICIES[:1]),
        "time_factor": _positive("scaled / physical time, scheme froude"),
        "time_exponent": Key("number", "the same as p in S^p", least=-2.0, most=2.0),
        "friction_exponent": Key(
            "number",
            "k: policy friction-matched divides the friction between balls by S^k",
            1.0,
            above=0.0,
            most=2.0,
        ),
        "stiffness": Key(
            "text",
            "Young's modulus: that of the physical mill, or scaled to keep overlap / ball radius",
            "fixed",
            choices=STIFFNESSES,
        ),
    },
    "wall": {
        "kind": Key(
            "text",
            "the liner as exact arcs and lines, or as triangles",
            "analytic",
            choices=("analytic", "mesh"),
        ),
        "chord_error_m": Key(
            "number",
            "largest gap of arc and panel, physical mill [m]; default: 2.5 % of a",
            least=1e-6,
        ),
        "axial_divisions": Key(
            "integer",
            "panels along the axis; default: the fewest that the engine accepts",
            least=1,
            most=1000,
        ),
    },
    "model": {
        "contacts": Key(
            "text",
            "contact backend of ball-ball contacts: our kernels, or stock LIGGGHTS",
            "fast",
            choices=tuple(SURFACES),
        ),
        "tangential_damping": Key(
            "text",
            "of ball-ball contacts; default: bounded with contacts fast, plain with stock",
            choices=tuple(DAMPINGS),
        ),
        "precision": Key(
            "text",
            "of our kernels; mixed: single precision where no error adds up, faster",
            "double",
            choices=PRECISIONS,
        ),
        "force": Key(
            "text",
            "model terms that the decks keep although the scene does not need them",
            (),
            choices=FORCIBLE,
            many=True,
        ),
    },
    "single_ball": {
        **_study(step=ADVISED, sample=0.005, restart=5.0, ramp=0.0),
        "rest_s": Key(
            "number", "rest before rotation, physical mill [s]; default: 1.57 sqrt(2 a / g)",
            least=0.0,
        ),
    },
    "multi_ball": {
        **_study(step=ADVISED, sample=0.01, restart=1.0, ramp=0.25),
        "settle_s": _positive(
            "settling before rotation, physical mill [s]; default: 1.27 sqrt(R / g)"
        ),
        "count": Key(
            "integer", "balls in the whole length of each scaled mill",
            least=1, most=10**8, many=True,
        ),
        "filling": Key(
            "number", "bed volume / volume inside the liner, the same in every scaled mill",
            above=0.0, most=0.7,
        ),
        "impacts": Key(
            "flag", "spectra of the energy that contacts dissipate, impact_spectra.csv", False
        ),
        "ledger": Key(
            "flag", "energy budget, ledger.csv; contacts then take several times longer",
            False,
        ),
        "liner_loads": Key(
            "flag", "loads of the balls on the liner, liner_loads.csv, for its wear", False
        ),
        "porosity": Key(
            "number", "void fraction of the bed, to count the balls of a filling",
            0.4, above=0.0, most=0.9,
        ),
        "slice_length_m": _positive(
            "length simulated instead of length_m / S, the same at every S [m]"
        ),
        "slice_diameters": _positive("the same in mean ball diameters"),
        "seeds": Key(
            "integer", "of the initial packing, one case each", (1,), least=0, most=10**9, many=True
        ),
        "seeds_from_S": Key(
            "number", "mills of a smaller S, which cost more, use the first seed only", least=1.0
        ),
    },
    "run": {
        "ranks": Key("integer", "MPI ranks of a multi-ball case", least=1, most=4096),
        "jobs": Key("integer", "cases that run at a time", least=1, most=4096),
        "output_gb": Key("number", "disk that a case may take [GB]", 20.0, above=0.0, most=1e6),
    },
}  # fmt: skip

REQUIRED_SECTIONS: Final = ("mill", "ball", "material")
# Sections whose defaults stand where they are left out.
OPTIONAL: Final = ("campaign", "liner", "scaling", "wall", "model", "run")

# Arrays of tables: "ball.class" is [[ball.class]], "speed" is [[speed]]. The checked entries are a
# tuple in the values of their section, or among the sections.
TABLES: Final[dict[str, Table]] = {
    "liner.row": Table(
        "a lifter; rows repeat in this order around the mill, in the direction of rotation",
        {
            "height_m": _positive("height of the top above the liner [m]", REQUIRED),
            "top_width_m": _positive("width of the top [m]", REQUIRED),
            "leading_angle_deg": Key(
                "number",
                "angle of the face that lifts the balls, from the lifter's centre line",
                0.0,
                least=0.0,
                most=85.0,
            ),
            "trailing_angle_deg": Key(
                "number",
                "the same of the other face; default: as the leading face",
                least=0.0,
                most=85.0,
            ),
            "edge_radius_m": Key("number", "radius of the edges of the top [m]", 0.0, least=0.0),
        },
        most=100,
    ),
    "liner.state": Table(
        "the liner at a time of its life; each makes cases of its own",
        {
            "name": Key("text", "in the names of the cases, such as new or worn", REQUIRED),
            "hours": Key("number", "operation since the liner was new", least=0.0),
            "tonnes": Key("number", "ore milled since then", least=0.0),
            "profile": Key("text", "file with the cross-section, .csv or .dxf"),
            "stl": Key("text", "file with a shell of triangles"),
            **_of_a_file(),
        },
        most=20,
    ),
    "ball.class": Table(
        "balls of one size and material",
        {
            "radius_m": _positive("radius of the balls [m]", REQUIRED),
            "mass_share": Key("number", "of the mass of all balls", above=0.0, most=1.0),
            "count_share": Key("number", "or of their number", above=0.0, most=1.0),
            "density_kg_m3": _positive("density; default: that of [ball] [kg/m^3]"),
            "youngs_modulus_pa": _positive("own E; default: that of [material] [Pa]"),
            "poisson_ratio": Key("number", "own nu", least=0.0, most=0.5),
            "restitution_pp": Key("number", "own restitution", least=0.05, most=1.0),
            "restitution_pw": Key("number", "own restitution with walls", least=0.05, most=1.0),
            "static_friction_pp": Key("number", "own friction", least=0.0, most=10.0),
            "static_friction_pw": Key("number", "own friction with walls", least=0.0, most=10.0),
            "rolling_friction_pp": Key("number", "own rolling friction", least=0.0, most=1.0),
            "rolling_friction_pw": Key(
                "number", "own rolling friction with walls", least=0.0, most=1.0
            ),
        },
        most=100,
    ),
    "speed": Table(
        "a change of the speed",
        {
            "from_turns": _positive("turns of the mill after which the speed changes"),
            "from_s": _positive("the same as time of the physical mill since it turns [s]"),
            "speed_rad_s": _positive("speed from then on [rad/s]"),
            "speed_rpm": _positive("the same in turns per minute"),
            "period_s": _positive("the same as time of a turn [s]"),
            "percent_of_critical": _positive("the same in % of sqrt(g / (R - a))"),
            "froude": _positive("the same as omega^2 R / g"),
            "ramp_turns": Key(
                "number", "turns of the mill from the speed before, evenly accelerated; 0: at once",
                0.0, least=0.0, most=100.0,
            ),
        },
    ),
}  # fmt: skip
