"""Quantities that people state in several ways, turned into SI and checked against each other."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

from millscale import _core
from millscale.errors import CampaignError

# Alternatives may differ by their rounding, not by more: 1 rad/s and 9.55 rpm agree to 0.006 %.
AGREEMENT = 1e-3


@dataclass(frozen=True)
class Unit:
    """A unit at the end of a key: a number in it times `numerator` / `denominator` is in SI.

    Two whole numbers keep a length in mm the double that its number in metres would be.
    """

    dimension: str
    numerator: float = 1
    denominator: float = 1


UNITS: Final[dict[str, Unit]] = {
    "_m": Unit("length"),
    "_mm": Unit("length", 1, 1000),
    "_cm": Unit("length", 1, 100),
    "_um": Unit("length", 1, 10**6),
    "_km": Unit("length", 1000),
    "_in": Unit("length", 254, 10**4),
    "_ft": Unit("length", 3048, 10**4),
    "_kg": Unit("mass"),
    "_g": Unit("mass", 1, 1000),
    "_t": Unit("mass", 1000),
    "_kg_m3": Unit("density"),
    "_g_cm3": Unit("density", 1000),
    "_t_m3": Unit("density", 1000),
    "_pa": Unit("pressure"),
    "_kpa": Unit("pressure", 1000),
    "_mpa": Unit("pressure", 10**6),
    "_gpa": Unit("pressure", 10**9),
    "_s": Unit("time"),
    "_ms": Unit("time", 1, 1000),
    "_us": Unit("time", 1, 10**6),
    "_min": Unit("time", 60),
    "_h": Unit("time", 3600),
    "_rad": Unit("angle"),
    "_deg": Unit("angle", math.pi, 180),
    "_rad_s": Unit("rotation"),
    "_rpm": Unit("rotation", math.tau, 60),
    "_hz": Unit("rotation", math.tau),
    "_deg_s": Unit("rotation", math.pi, 180),
    "_m_s": Unit("velocity"),
    "_m_s2": Unit("acceleration"),
    "_percent": Unit("share", 1, 100),
}
# The longest first: no unit may be taken for part of a longer one.
_BY_LENGTH: Final = sorted(UNITS, key=len, reverse=True)


def split_unit(key: str) -> tuple[str, str]:
    """Return the quantity and unit suffix of a key: `radius_mm` is `radius` in `_mm`."""
    lower = key.lower()
    for suffix in _BY_LENGTH:
        if lower.endswith(suffix) and len(key) > len(suffix):
            return key[: -len(suffix)], suffix
    return key, ""


def speed_forms(
    radius: float, ball_radius: float, gravity: float
) -> dict[str, Callable[[float], float]]:
    """Return how each key of the mill speed becomes rad/s.

    The critical speed sqrt(g / (R - a)) is that of a ball's centre, the Froude number
    omega^2 R / g that of the liner.

    Args:
        radius: R, mill radius at the liner [m].
        ball_radius: a [m].
        gravity: g [m/s^2].
    """
    standing = _core.OperatingPoint(radius, ball_radius, gravity, 0.0)
    critical = _core.critical_speed(standing)
    return {
        "speed_rad_s": lambda value: value,
        "speed_rpm": lambda value: value * math.tau / 60.0,
        "period_s": lambda value: math.tau / value,
        "percent_of_critical": lambda value: value / 100.0 * critical,
        "froude": lambda value: math.sqrt(value * gravity / radius),
    }


def resolve(
    values: Mapping[str, float | None],
    forms: Mapping[str, Callable[[float], float]],
    unit: str,
    where: tuple[object, str],
) -> float | None:
    """Return the quantity in SI from whichever of its alternative keys are given; None if none is.

    Args:
        values: key -> value as written, None if absent.
        forms: key -> conversion to SI. The first given, in this order, is the value used.
        unit: the SI unit, for the message.
        where: campaign file and section, for the message.

    Raises:
        CampaignError: two alternatives disagree by more than `AGREEMENT`.
    """
    given = {key: form(value) for key, form in forms.items() if (value := values[key]) is not None}
    if not given:
        return None
    first, value = next(iter(given.items()))
    for key, other in given.items():
        if abs(other - value) > AGREEMENT * abs(value):
            file, section = where
            raise CampaignError(
                file,
                f"{section}.{key}",
                f"contradicts {first}: {values[key]:g} is {other:.6g} {unit}, "
                f"{first} = {values[first]:g} is {value:.6g} {unit}",
                f"one of the two, or values that agree within {AGREEMENT:.1%}",
            )
    return value
