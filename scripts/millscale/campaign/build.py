"""From the values of a campaign file to a `Campaign`: alternatives resolved and cross-checked."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from millscale import _core
from millscale.campaign.campaign import Ball, Campaign, LinerShape, Material, Mill, Wall
from millscale.campaign.contacts import ContactOptions
from millscale.campaign.keys import FRICTION_MATCHED, KINDS
from millscale.campaign.parts import build_part
from millscale.campaign.reader import checked_sections, parse_toml
from millscale.campaign.units import resolve, speed_forms
from millscale.errors import CampaignError

Section = Mapping[str, Any]
Forms = Mapping[str, Callable[[float], float]]
# Radius in ball radii: a slice of such a mill, one ball thick, holds over half a million balls.
LARGEST_MILL = 2000.0
NAME = re.compile(r"[a-z0-9]+(-[a-z0-9]+)*")


def load_campaign(path: str | Path) -> Campaign:
    """Return the campaign a TOML file describes.

    Raises:
        CampaignError: the file, a key or a combination of keys is not accepted.
    """
    path = Path(path)
    return campaign_of(path, parse_toml(path))


def campaign_of(path: Path, tree: Section) -> Campaign:
    """Return the campaign that the content of a TOML file describes.

    Args:
        path: of the file, for its default name and the messages.

    Raises:
        CampaignError: a key or a combination of keys is not accepted.
    """
    sections = checked_sections(path, tree)
    mill = _mill(path, sections["mill"], sections["ball"])
    scaling = sections["scaling"]
    parts = tuple(build_part(path, name, sections, mill) for name in KINDS if name in sections)
    if not parts:
        raise CampaignError(path, "", "nothing to simulate", "[single_ball], [multi_ball] or both")
    _check_time_factor(path, scaling, {scheme for part in parts for scheme in part.schemes})
    _check_friction_exponent(path, scaling, {policy for part in parts for policy in part.policies})
    return Campaign(
        file=path,
        name=campaign_name(path, "campaign.name", sections["campaign"]["name"]),
        about=sections["campaign"]["about"],
        mill=mill,
        liner=_liner(path, sections["liner"]),
        ball=_ball(path, sections["ball"]),
        material=_material(path, sections["material"]),
        wall=_wall(path, sections["wall"], sections["ball"]["radius_m"]),
        stiffness=scaling["stiffness"],
        contacts=_contacts(path, sections["model"]),
        force=sections["model"]["force"],
        time_factor=scaling["time_factor"],
        time_exponent=scaling["time_exponent"],
        friction_exponent=scaling["friction_exponent"],
        parts=parts,
        ranks=sections["run"]["ranks"],
        jobs=sections["run"]["jobs"],
        output_budget=1e9 * sections["run"]["output_gb"],
        warnings=(*_unused(sections["liner"]), *_slow(sections["mill"], mill, sections["ball"])),
    )


def _wall(path: Path, wall: Section, ball_radius: float) -> Wall:
    error = wall["chord_error_m"]
    if error is not None and error >= ball_radius:
        raise CampaignError(
            path, "wall.chord_error_m", f"got {error:g}, as large as a ball", f"< {ball_radius:g}"
        )
    return Wall(wall["kind"], error, wall["axial_divisions"])


def _contacts(path: Path, model: Section) -> ContactOptions:
    backend, damping = model["contacts"], model["tangential_damping"]
    if backend == "fast":
        return ContactOptions(backend, damping or "bounded", model["precision"])
    # Both options are of our kernels.
    for key, got, accepted in (("tangential_damping", damping, "plain"),
                               ("precision", model["precision"], "double")):  # fmt: skip
        if got not in (None, accepted):
            cause = f'got "{got}" with contacts = "stock"'
            raise CampaignError(path, f"model.{key}", cause, f'"{accepted}", or contacts = "fast"')
    return ContactOptions(backend, "plain")


def campaign_name(path: Path, key: str, name: str | None) -> str:
    """Return the name given under a key, or that of the file.

    Raises:
        CampaignError: not a name for folders and files.
    """
    if name is None:
        name = re.sub(r"[^a-z0-9]+", "-", path.stem.lower()).strip("-") or "campaign"
    if not NAME.fullmatch(name) or len(name) > 64:
        raise CampaignError(
            path,
            key,
            f'got "{name}"',
            "up to 64 lower-case letters, digits and single hyphens, such as paper-single-ball",
        )
    return name


def _mill(path: Path, mill: Section, ball: Section) -> Mill:
    radius, gravity = mill["radius_m"], mill["gravity_m_s2"]
    if not radius / LARGEST_MILL <= ball["radius_m"] < radius:
        raise CampaignError(
            path,
            "ball.radius_m",
            f"got {ball['radius_m']:g} in a mill of {radius:g} m",
            f">= {radius / LARGEST_MILL:g} and < {radius:g}",
        )
    forms = speed_forms(radius, ball["radius_m"], gravity)
    omega = resolve(mill, forms, "rad/s", (path, "mill"))
    if omega is None:
        raise CampaignError(path, "mill", "the speed is missing", "one of " + ", ".join(forms))
    froude = _core.froude_number(radius, gravity, omega)
    if froude >= 1.0 and not mill["allow_centrifuging"]:
        given = next(key for key in forms if mill[key] is not None)
        raise CampaignError(
            path,
            f"mill.{given}",
            f"got {mill[given]:g}, Froude number omega^2 R / g = {froude:.3g}: the mill "
            "centrifuges and no ball detaches" + _meant(mill, given, forms),
            "Fr < 1, or allow_centrifuging = true",
        )
    return Mill(radius, mill["length_m"], gravity, omega, mill["allow_centrifuging"])


# Keys of a speed that are taken for one another.
MISTAKEN = {
    "speed_rpm": ("speed_rad_s", "rad/s typed as rpm"),
    "speed_rad_s": ("speed_rpm", "rpm typed as rad/s"),
}
# Below this share of the critical speed [%] hardly any mill is run: a slip is more likely.
SLOW_PERCENT = 10.0


def _slow(mill: Section, built: Mill, ball: Section) -> tuple[str, ...]:
    """Warn of a mill that hardly turns."""
    forms = speed_forms(built.radius, ball["radius_m"], built.gravity)
    share = 100.0 * built.omega / forms["percent_of_critical"](100.0)
    if share >= SLOW_PERCENT:
        return ()
    key = next(key for key in forms if mill[key] is not None)
    meant = _meant(mill, key, forms)
    return (f"mill.{key} = {mill[key]:g} is {share:.2g} % of the critical speed{meant}",)


def _meant(mill: Section, key: str, forms: Forms) -> str:
    """Ask whether the number of a speed was meant as another that makes an ordinary mill."""
    critical = forms["percent_of_critical"](100.0)
    if key == "percent_of_critical" and mill[key] <= 1.0:
        return f"; a share typed as percent? {100.0 * mill[key]:g} would be that"
    if key in MISTAKEN:
        other, question = MISTAKEN[key]
        share = 100.0 * forms[other](mill[key]) / critical
        if SLOW_PERCENT <= share < 100.0:
            return f"; {question}? {other} = {mill[key]:g} would be {share:.3g} %"
    return ""


def _liner(path: Path, liner: Section) -> LinerShape:
    lifters = liner["lifters"]
    shape = ("lifter_top_radius_m", "lifter_top_width_m", "groove_width_m", "face_angle_deg")
    if lifters == 0:
        for key in shape:
            if liner[key] is not None:
                raise CampaignError(
                    path, f"liner.{key}", "given for a plain drum", "no such key with lifters = 0"
                )
        return LinerShape(0, 0.0, 0.0, 0.0, None, math.radians(liner["phase_deg"]))
    for key in shape[:2]:
        if liner[key] is None:
            raise CampaignError(path, f"liner.{key}", "missing", f"needed with lifters = {lifters}")
    return LinerShape(
        lifters,
        liner["lifter_top_radius_m"],
        liner["lifter_top_width_m"],
        *_foot(path, liner),
        math.radians(liner["phase_deg"]),
    )


def _foot(path: Path, liner: Section) -> tuple[float | None, float | None]:
    """Return groove width [m] or face angle [rad], whichever defines the foot of the lifters."""
    width, angle = liner["groove_width_m"], liner["face_angle_deg"]
    if liner["reading"] == "parallel":
        if angle:
            raise CampaignError(
                path,
                "liner.face_angle_deg",
                f'{angle:g} contradicts reading = "parallel", in which the faces are parallel',
                'no such key, or reading = "trapezoid"',
            )
        return None, 0.0
    if (width is None) == (angle is None):
        what = "missing" if width is None else "both given"
        raise CampaignError(
            path, "liner.groove_width_m", f"and face_angle_deg {what}", "one of the two"
        )
    return width, None if angle is None else math.radians(angle)


def _unused(liner: Section) -> tuple[str, ...]:
    """Warn that `groove_width_m` is not used if the faces are parallel."""
    if liner["reading"] == "parallel" and liner["groove_width_m"] is not None:
        return ("reading parallel: groove_width_m is not used, it follows from lifter_top_width_m",)
    return ()


def _ball(path: Path, ball: Section) -> Ball:
    if ball["radius_std_m"] * ball["truncation"] >= 0.8 * ball["radius_m"]:
        raise CampaignError(
            path,
            "ball.radius_std_m",
            f"got {ball['radius_std_m']:g}: the smallest ball would be under a fifth of the mean",
            f"less than {0.8 * ball['radius_m'] / ball['truncation']:g}, or a smaller truncation",
        )
    return Ball(ball["radius_m"], ball["density_kg_m3"], ball["radius_std_m"], ball["truncation"])


def _material(path: Path, material: Section) -> Material:
    poisson = material["poisson_ratio"]
    forms = {
        "shear_modulus_pa": lambda value: 2.0 * value * (1.0 + poisson),
        "youngs_modulus_pa": lambda value: value,
    }
    youngs_modulus = resolve(material, forms, "Pa of Young's modulus", (path, "material"))
    if youngs_modulus is None:
        raise CampaignError(path, "material", "stiffness is missing", "one of " + ", ".join(forms))
    rest = {key: value for key, value in material.items() if key not in forms}
    return Material(youngs_modulus=youngs_modulus, **rest)


def _check_time_factor(path: Path, scaling: Section, schemes: set[str]) -> None:
    given = [key for key in ("time_factor", "time_exponent") if scaling[key] is not None]
    if "froude" in schemes and len(given) != 1:
        what = "both given" if given else "missing"
        raise CampaignError(
            path,
            "scaling.time_factor",
            f"and time_exponent {what} for scheme froude",
            "one of the two",
        )
    if "froude" not in schemes and given:
        raise CampaignError(
            path, f"scaling.{given[0]}", "only scheme froude takes one", 'schemes = ["froude"]'
        )


def _check_friction_exponent(path: Path, scaling: Section, policies: set[str]) -> None:
    exponent = scaling["friction_exponent"]
    if exponent != 1.0 and FRICTION_MATCHED not in policies:
        cause = f"got {exponent:g}: only policy {FRICTION_MATCHED} takes one"
        accepted = f'policies = ["{FRICTION_MATCHED}"]'
        raise CampaignError(path, "scaling.friction_exponent", cause, accepted)
