"""From the values of a campaign file to a `Campaign`: alternatives resolved and cross-checked."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

from millscale import _core
from millscale.campaign.ball_classes import with_classes, with_materials
from millscale.campaign.campaign import (
    Ball,
    Campaign,
    Liner,
    LinerShape,
    LinerState,
    Material,
    Mill,
    Wall,
)
from millscale.campaign.contacts import ContactOptions
from millscale.campaign.keys import FRICTION_MATCHED, KINDS
from millscale.campaign.liner_part import build_liner, build_states
from millscale.campaign.lines import Places
from millscale.campaign.parts import build_part
from millscale.campaign.reader import checked_sections, parse_text, read_text
from millscale.campaign.units import resolve, speed_forms
from millscale.errors import CampaignError, Mistakes

Built = TypeVar("Built")
Section = Mapping[str, Any]
Forms = Mapping[str, Callable[[float], float]]
# Radius in ball radii: a slice of such a mill, one ball thick, holds over half a million balls.
LARGEST_MILL = 2000.0
NAME = re.compile(r"[a-z0-9]+(-[a-z0-9]+)*")


def load_campaign(path: str | Path) -> Campaign:
    """Return the campaign a TOML file describes.

    Raises:
        CampaignError: the file, keys or combinations of keys are not accepted; holds all mistakes.
    """
    path = Path(path)
    return campaign_of_text(path, read_text(path))


def campaign_of_text(path: Path, text: str) -> Campaign:
    """Return the campaign that the text of a TOML file describes.

    Args:
        path: of the file, for its default name and the messages.

    Raises:
        CampaignError: the text, keys or combinations of keys are not accepted; holds all mistakes.
    """
    places = Places(text)
    try:
        campaign = campaign_of(path, parse_text(path, text))
    except CampaignError as error:
        raise places.located(error) from None
    return replace(campaign, places=places)


def campaign_of(path: Path, tree: Section) -> Campaign:
    """Return the campaign that the content of a TOML file describes.

    Args:
        path: of the file, for its default name and the messages.

    Raises:
        CampaignError: keys or combinations of keys are not accepted; holds all mistakes.
    """
    mistakes = Mistakes()
    sections = checked_sections(path, tree, mistakes)
    if "ball" in sections:
        stated = sections.pop("ball")
        with mistakes.collected():
            sections["ball"] = with_classes(path, stated)

    def built(make: Callable[..., Built], *names: str) -> Built | None:
        """Return what sections make; None after a mistake in them, which is kept."""
        if all(name in sections for name in names):
            with mistakes.collected():
                return make(path, *(sections[name] for name in names))
        return None

    name = built(_name, "campaign")
    mill = built(_mill, "mill", "ball")
    liner_and_states = built(_liner, "liner", "mill")
    ball = built(_ball, "ball")
    material = built(_material, "material")
    wall = built(_wall, "wall", "ball", "mill")
    contacts = built(_contacts, "model")
    if ball and material and sections["ball"]["class"]:
        with mistakes.collected():
            ball = with_materials(ball, sections["ball"]["class"], material, path)
    parts = []
    for kind in KINDS:
        if mill and sections.keys() >= {kind, "ball", "scaling", "wall", "model", "speed"}:
            with mistakes.collected():
                parts.append(build_part(path, kind, sections, mill))
    if not any(kind in tree for kind in KINDS):
        accepted = "[single_ball], [multi_ball] or both"
        mistakes.found.append(CampaignError(path, "", "nothing to simulate", accepted))
    elif not mistakes.found:
        scaling = sections["scaling"]
        schemes = {scheme for part in parts for scheme in part.schemes}
        policies = {policy for part in parts for policy in part.policies}
        with mistakes.collected():
            _check_time_factor(path, scaling, schemes)
        with mistakes.collected():
            _check_friction_exponent(path, scaling, policies)
    mistakes.raise_all()
    assert (
        name and mill and liner_and_states and ball and material and wall and contacts
    )  # or a mistake
    liner, states = liner_and_states
    return Campaign(
        file=path,
        name=name,
        about=sections["campaign"]["about"],
        mill=mill,
        liner=liner,
        states=states,
        ball=ball,
        material=material,
        wall=wall,
        stiffness=sections["scaling"]["stiffness"],
        contacts=contacts,
        force=sections["model"]["force"],
        time_factor=sections["scaling"]["time_factor"],
        time_exponent=sections["scaling"]["time_exponent"],
        friction_exponent=sections["scaling"]["friction_exponent"],
        parts=tuple(parts),
        ranks=sections["run"]["ranks"],
        jobs=sections["run"]["jobs"],
        output_budget=1e9 * sections["run"]["output_gb"],
        warnings=(
            *_unused(sections["liner"]),
            *_slow(sections["mill"], mill, sections["ball"]),
            *_light(ball),
        ),
    )


def _name(path: Path, campaign: Section) -> str:
    return campaign_name(path, "campaign.name", campaign["name"])


def _wall(path: Path, wall: Section, ball: Section, mill: Section) -> Wall:
    ends = mill["ends"]
    if ends != "periodic" and wall["kind"] == "mesh":
        raise CampaignError(
            path,
            "mill.ends",
            f'got "{ends}" with wall.kind = "mesh", which has no end walls',
            'wall.kind = "analytic", or ends = "periodic"',
        )
    error, ball_radius = wall["chord_error_m"], ball["radius_m"]
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
    _check_ends(path, mill)
    return Mill(
        radius,
        mill["length_m"],
        gravity,
        omega,
        mill["allow_centrifuging"],
        mill["ends"],
        mill["end_static_friction"],
        mill["end_rolling_friction"],
    )


def _check_ends(path: Path, mill: Section) -> None:
    """Refuse the friction of ends that are not there."""
    if mill["ends"] != "periodic":
        return
    for key in ("end_static_friction", "end_rolling_friction"):
        if mill[key] is not None:
            cause = f'got {mill[key]:g} with ends = "periodic", which has no end walls'
            raise CampaignError(path, f"mill.{key}", cause, 'ends = "turning" or "resting"')


# Keys of a speed that are taken for one another.
MISTAKEN = {
    "speed_rpm": ("speed_rad_s", "rad/s typed as rpm"),
    "speed_rad_s": ("speed_rpm", "rpm typed as rad/s"),
}
# A percentage below this is more likely a share: mills run at 0.5 to 1.2 of the critical speed.
LARGEST_SHARE = 1.5
# Lighter balls [kg/m^3] are more likely a density in g/cm^3: 7.8 for steel.
LIGHT_KG_M3 = 500.0
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


def _light(ball: Ball) -> tuple[str, ...]:
    """Warn of balls lighter than those of any mill."""
    if ball.density >= LIGHT_KG_M3:
        return ()
    text = f"balls of {ball.density:g} kg/m^3 are lighter than those of any mill"
    if 1000.0 * ball.density >= LIGHT_KG_M3:
        text += f"; g/cm^3 typed as kg/m^3? density_g_cm3 = {ball.density:g} would be "
        text += f"{1000.0 * ball.density:g} kg/m^3"
    return (text,)


def _meant(mill: Section, key: str, forms: Forms) -> str:
    """Ask whether the number of a speed was meant as another that makes an ordinary mill."""
    critical = forms["percent_of_critical"](100.0)
    if key == "percent_of_critical" and mill[key] < LARGEST_SHARE:
        return f"; a share typed as percent? {100.0 * mill[key]:g} would be that"
    if key in MISTAKEN:
        other, question = MISTAKEN[key]
        share = 100.0 * forms[other](mill[key]) / critical
        if SLOW_PERCENT <= share < 100.0:
            return f"; {question}? {other} = {mill[key]:g} would be {share:.3g} %"
    return ""


def _liner(path: Path, liner: Section, mill: Section) -> tuple[Liner, tuple[LinerState, ...]]:
    """Return the liner, of the first state if there are several, and the states."""
    states = build_states(path, liner, mill)
    shape = build_liner(path, liner, mill)
    if states:
        if shape is not None:
            cause = "given beside [[liner.state]]"
            raise CampaignError(path, "liner.profile", cause, "a profile in each state instead")
        return states[0].liner, states
    return shape or _trapezoids(path, liner, mill), ()


def _trapezoids(path: Path, liner: Section, mill: Section) -> LinerShape:
    lifters = liner["lifters"]
    shape = (
        *("lifter_top_radius_m", "lifter_height_m", "lifter_top_width_m", "groove_width_m"),
        "face_angle_deg",
    )
    if lifters == 0:
        for key in shape:
            if liner[key] is not None:
                raise CampaignError(
                    path, f"liner.{key}", "given for a plain drum", "no such key with lifters = 0"
                )
        return LinerShape(0, 0.0, 0.0, 0.0, None, math.radians(liner["phase_deg"]))
    mistakes = Mistakes()
    top_radius, foot = None, None
    with mistakes.collected():
        top_radius = _top_radius(path, liner, mill["radius_m"])
    with mistakes.collected():
        if liner["lifter_top_width_m"] is None:
            accepted = f"needed with lifters = {lifters}"
            raise CampaignError(path, "liner.lifter_top_width_m", "missing", accepted)
    with mistakes.collected():
        foot = _foot(path, liner)
    mistakes.raise_all()
    assert top_radius and foot  # or a mistake
    phase = math.radians(liner["phase_deg"])
    return LinerShape(lifters, top_radius, liner["lifter_top_width_m"], *foot, phase)


def _top_radius(path: Path, liner: Section, radius: float) -> float:
    """Return r of the lifter tops [m], from itself or from the height R - r, which must agree."""
    forms = {
        "lifter_top_radius_m": lambda value: radius - value,
        "lifter_height_m": lambda value: value,
    }
    height = resolve(liner, forms, "m of lifter height", (path, "liner"))
    if height is None:
        accepted = f"it or lifter_height_m, needed with lifters = {liner['lifters']}"
        raise CampaignError(path, "liner.lifter_top_radius_m", "missing", accepted)
    given: float | None = liner["lifter_top_radius_m"]
    if given is not None:
        return given
    if height >= radius:
        cause = f"got {height:g} in a mill of mill.radius_m = {radius:g}"
        raise CampaignError(path, "liner.lifter_height_m", cause, f"< {radius:g}")
    return radius - height


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
    return Ball(
        ball["radius_m"],
        ball["density_kg_m3"],
        ball["radius_std_m"],
        ball["truncation"],
        ball["classes"],
    )


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
