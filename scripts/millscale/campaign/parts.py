"""The parts of a campaign: which mills, how long, with which charge."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from millscale import _core
from millscale.campaign.campaign import CampaignPart, Charge, Mill
from millscale.campaign.keys import ADVISED, FRICTION_MATCHED, KINDS
from millscale.campaign.speed import speed_changes
from millscale.campaign.units import AGREEMENT, resolve
from millscale.errors import CampaignError
from millscale.runs.case_file import SpeedChange

Section = Mapping[str, Any]
# Mill rotation between dumps where the file says nothing [rad]; curtains repeat every pitch.
DUMP_ANGLE = 0.5
# Default settling over sqrt(R / g). A packing of 0.55 becomes a bed of 0.60, so the surface of a
# bed of depth h falls by h / 12, in 0.4 sqrt(h / g); after three times that the bed of the mill of
# R = 3.9 m is at rest (docs/guide/plan.md, "Settling"). h follows R, and the law scales both times
# alike.
SETTLING = 1.27
# Default rest of a single ball over sqrt(2 a / g): it falls by a thousandth of its radius.
REST = 1.57


def build_part(path: Path, name: str, sections: Mapping[str, Any], mill: Mill) -> CampaignPart:
    """Return the campaign part of section `name`; keys it lacks are taken from [scaling].

    Raises:
        CampaignError: contradictory or missing keys.
    """
    section, scaling = sections[name], sections["scaling"]
    ratios = _ratios(path, name, section, mill) or _ratios(path, "scaling", scaling, mill)
    if ratios is None:
        raise CampaignError(path, "scaling.S", "missing", "S or scaled_radius_m, a list of numbers")
    ball_radius = sections["ball"]["radius_m"]
    _check_radii(path, ratios, mill, ball_radius)
    single = name == "single_ball"
    changes = speed_changes(path, section["ramp_turns"], sections["speed"], mill, ball_radius)
    rotation = _rotation_angle(path, name, section, mill, changes)
    _check_intervals(path, name, section, rotation)
    return CampaignPart(
        kind=KINDS[name],
        ratios=ratios,
        schemes=section["schemes"] or scaling["schemes"],
        policies=_part_policies(path, name, section["policies"], scaling["policies"]),
        step=None if section["step_s"] == ADVISED else section["step_s"],
        wait=_wait(name, section, mill, ball_radius),
        rotation_angle=rotation,
        sample_angle=section["sample_angle_rad"],
        dump_angle=section["dump_angle_rad"] or min(DUMP_ANGLE, rotation),
        restart_angle=section["restart_angle_rad"],
        charge=None if single else _charge(path, sections, ratios, mill),
        ledger=not single and _recorded(path, sections, "ledger", "keeps no account of energy"),
        impacts=not single and _recorded(path, sections, "impacts", "records no impacts"),
        liner_loads=not single and _liner_loads(path, sections),
        speed_changes=changes,
    )


def _part_policies(
    path: Path, name: str, own: tuple[str, ...] | None, common: tuple[str, ...]
) -> tuple[str, ...]:
    """Return the policies of a campaign part; of a single ball, those that can change it."""
    policies = own or common
    if name != "single_ball" or FRICTION_MATCHED not in policies:
        return policies
    left = tuple(policy for policy in policies if policy != FRICTION_MATCHED)
    if own or not left:
        raise CampaignError(
            path,
            f"{name}.policies",
            f"got {FRICTION_MATCHED}: a single ball has no contact between balls",
            "other policies",
        )
    return left


def _recorded(path: Path, sections: Mapping[str, Section], flag: str, lacks: str) -> bool:
    """Return a flag of [multi_ball] that only our contacts and wall can obey.

    Args:
        lacks: what other contacts and walls do, for the error.
    """
    wanted = bool(sections["multi_ball"][flag])
    for section, key, ours in (("model", "contacts", "fast"), ("wall", "kind", "analytic")):
        got = sections[section][key]
        if wanted and got != ours:
            raise CampaignError(
                path,
                f"multi_ball.{flag}",
                f'got true with {section}.{key} = "{got}", which {lacks}',
                f'{section}.{key} = "{ours}", or {flag} = false',
            )
    return wanted


def _liner_loads(path: Path, sections: Mapping[str, Section]) -> bool:
    """Return whether the loads on the liner are wanted; only our wall records them."""
    wanted, got = bool(sections["multi_ball"]["liner_loads"]), sections["wall"]["kind"]
    if wanted and got != "analytic":
        raise CampaignError(
            path,
            "multi_ball.liner_loads",
            f'got true with wall.kind = "{got}", which records no loads',
            'wall.kind = "analytic", or liner_loads = false',
        )
    return wanted


def _ratios(path: Path, name: str, section: Section, mill: Mill) -> tuple[float, ...] | None:
    """Return S of the scaled mills of a section, from S or the scaled radii, which must agree."""
    ratios: tuple[float, ...] | None = section["S"]
    radii: tuple[float, ...] | None = section["scaled_radius_m"]
    if radii is None:
        return ratios
    key = f"{name}.scaled_radius_m"
    from_radii = tuple(mill.radius / radius for radius in radii)
    for ratio, radius in zip(from_radii, radii, strict=True):
        if ratio < 1.0:
            raise CampaignError(
                path,
                key,
                f"{radius:g} makes S = {ratio:.4g}",
                f"<= mill.radius_m = {mill.radius:g}",
            )
    if ratios is None:
        return from_radii
    if len(ratios) != len(radii):
        raise CampaignError(
            path, key, f"{len(radii)} radii, but {len(ratios)} S", "one radius for each S"
        )
    for ratio, other, radius in zip(ratios, from_radii, radii, strict=True):
        if abs(ratio - other) > AGREEMENT * ratio:
            raise CampaignError(
                path,
                key,
                f"contradicts S: {radius:g} is S = {other:.6g}, S has {ratio:.6g}",
                f"one of the two, or values that agree within {AGREEMENT:.1%}",
            )
    return ratios


def _check_radii(path: Path, ratios: tuple[float, ...], mill: Mill, ball_radius: float) -> None:
    for ratio in ratios:
        if mill.radius / ratio <= ball_radius:
            raise CampaignError(
                path,
                "scaling.S",
                f"got {ratio:g}: the scaled mill radius {mill.radius / ratio:.4g} m is not above "
                f"ball.radius_m = {ball_radius:g}",
                f"S < {mill.radius / ball_radius:g}",
            )


def _wait(name: str, section: Section, mill: Mill, ball_radius: float) -> float:
    """Return the rest of a single ball, or settling of a charge, before the mill turns [s]."""
    if name == "single_ball":
        given, default = section["rest_s"], REST * math.sqrt(2.0 * ball_radius / mill.gravity)
    else:
        given, default = section["settle_s"], settling_time(mill)
    return float(f"{default:.2g}") if given is None else given


def settling_time(mill: Mill) -> float:
    """Return the time in which the charge of a physical mill settles [s]."""
    return SETTLING * math.sqrt(mill.radius / mill.gravity)


def _check_intervals(path: Path, name: str, section: Section, rotation: float) -> None:
    """Refuse intervals of rows and dumps that are longer than the rotation."""
    for key in ("sample_angle_rad", "dump_angle_rad"):
        if section[key] is not None and section[key] > rotation:
            raise CampaignError(
                path,
                f"{name}.{key}",
                f"got {section[key]:g}, longer than the rotation of {rotation:g} rad",
                f"<= {rotation:g}, or a longer rotation",
            )


def _rotation_angle(
    path: Path, name: str, section: Section, mill: Mill, changes: tuple[SpeedChange, ...]
) -> float:
    schedule = _core.SpeedSchedule(list(changes))
    forms = {
        "rotation_angle_rad": lambda value: value,
        "revolutions": lambda value: value * math.tau,
        "rotation_s": lambda value: schedule.angle(value * mill.omega),
    }
    angle = resolve(section, forms, "rad", (path, name))
    if angle is None:
        raise CampaignError(
            path, name, "the mill rotation is missing", "one of " + ", ".join(forms)
        )
    return angle


def _charge(
    path: Path, sections: Mapping[str, Section], ratios: tuple[float, ...], mill: Mill
) -> Charge:
    section = sections["multi_ball"]
    counts, filling = section["count"], section["filling"]
    if (counts is None) == (filling is None):
        what = "both given" if counts else "missing"
        raise CampaignError(path, "multi_ball.count", f"and filling {what}", "one of the two")
    if counts is not None and len(counts) != len(ratios):
        raise CampaignError(
            path, "multi_ball.count", f"{len(counts)} counts for {len(ratios)} S", "one for each S"
        )
    slice_length, key = _slice_length(path, section, 2.0 * sections["ball"]["radius_m"])
    shortest = mill.length / max(ratios)
    # A length typed from the scaled mill is rounded: 385 mm for 384.6 mm.
    if slice_length is not None and slice_length > shortest * (1.0 + AGREEMENT):
        raise CampaignError(
            path,
            f"multi_ball.{key}",
            f"makes {slice_length:g} m, longer than the shortest scaled mill",
            f"<= {shortest:.6g} m",
        )
    return Charge(
        counts,
        filling,
        section["porosity"],
        slice_length,
        section["seeds"],
        _seeds_from(path, section, ratios),
    )


def _slice_length(path: Path, section: Section, diameter: float) -> tuple[float | None, str]:
    """Return the length of the slice [m], None for the whole mill, and the key that gives it."""
    length, diameters = section["slice_length_m"], section["slice_diameters"]
    if length is not None and diameters is not None:
        raise CampaignError(
            path, "multi_ball.slice_length_m", "and slice_diameters both given", "one of the two"
        )
    if diameters is None:
        return length, "slice_length_m"
    return diameters * diameter, "slice_diameters"


def _seeds_from(path: Path, section: Section, ratios: tuple[float, ...]) -> float:
    """Return the smallest S that takes every seed."""
    given = section["seeds_from_S"]
    if given is None:
        return 1.0
    if len(section["seeds"]) == 1 or given > max(ratios):
        raise CampaignError(
            path,
            "multi_ball.seeds_from_S",
            f"got {given:g}, with {len(section['seeds'])} seeds and S up to {max(ratios):g}",
            "several seeds, and at most the largest S",
        )
    return float(given)
