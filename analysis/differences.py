"""What differs between runs folders: facts of their mills, and keys of their campaign files."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from millscale.analysis.charge.physical_mill import balls_per_length
from millscale.runs.case_file import Case
from millscale.runs.untrusted import RunFolderError, read_text

CAMPAIGN_COPY = "campaign.toml"
_MOST_CAMPAIGN = 1 << 20
# Numbers that differ by less are one number in two roundings.
SAME = 1e-6
MILL, LINER, SPEED, CHARGE, CONTACT, SETTING = (
    "mill",
    "liner",
    "speed",
    "charge",
    "contacts",
    "settings of the simulation",
)
Value = float | str | None


@dataclass(frozen=True)
class Fact:
    """A fact of a case.

    Attributes:
        about: which part of the case it describes.
        read: returns it from a case; None where the case has no such fact.
    """

    about: str
    label: str
    unit: str
    read: Callable[[Case], Value]

    @property
    def heading(self) -> str:
        return f"{self.label} [{self.unit}]" if self.unit else self.label


@dataclass(frozen=True)
class FactRow:
    """A fact in each of several cases, in their order."""

    fact: Fact
    values: tuple[Value, ...]

    @property
    def differs(self) -> bool:
        first = self.values[0]
        return any(not _is_same(first, value) for value in self.values[1:])

    @property
    def is_numeric(self) -> bool:
        return all(isinstance(value, float | int) for value in self.values)

    def text(self, value: Value) -> str:
        """Return a value as it is shown; a dash without one."""
        if value is None:
            return "–"
        return value if isinstance(value, str) else f"{value:.5g}"


def fact_rows(cases: Sequence[Case]) -> list[FactRow]:
    """Return the facts that at least one of some cases has."""
    rows = [FactRow(fact, tuple(fact.read(case) for case in cases)) for fact in FACTS]
    return [row for row in rows if any(value is not None for value in row.values)]


def _is_same(a: Value, b: Value) -> bool:
    if isinstance(a, float | int) and isinstance(b, float | int):
        return math.isclose(a, b, rel_tol=SAME, abs_tol=1e-12)
    return a == b


def _of_mill(label: str, unit: str, read: Callable[[Case], Value]) -> Fact:
    return Fact(MILL, label, unit, read)


def _material(label: str, name: str, unit: str = "", scale: float = 1.0) -> Fact:
    def read(case: Case) -> float:
        return scale * float(getattr(case.material, name))

    return Fact(CONTACT, label, unit, read)


def _lifter(read: Callable[[Case], float]) -> Callable[[Case], Value]:
    """Return a number of the lifters; none of a plain drum."""
    return lambda case: read(case) if case.physical.lifters else None


def _trapezoid(read: Callable[[Case], float]) -> Callable[[Case], Value]:
    """Return a number of trapezoidal lifters; none of another profile."""
    return lambda case: None if case.mill.profile else _lifter(read)(case)


def _classes(case: Case) -> str | None:
    """Return diameter and share of each class by number."""
    return (
        ", ".join(
            f"{2e3 * x.radius_m:.4g} mm: {100.0 * x.count / case.ball.count:.3g} %"
            for x in case.ball.classes
        )
        or None
    )


def _mass(case: Case) -> float | None:
    """Return the mass of the whole charge of the physical mill [t]."""
    if case.charge is None:
        return None
    return 1e-3 * balls_per_length(case) * case.physical.length_m * case.ball.mass_kg


def _filling(case: Case) -> float | None:
    if case.charge is None or case.charge.filling is None:
        return None
    return 100.0 * case.charge.filling


def _speed_changes(case: Case) -> str | None:
    """Return the ramp and the steps of the speed: share of the speed, mill angles [rad]."""
    return (
        "; ".join(
            f"{100.0 * ratio:.4g} % from {begin:.3g} to {begin + over:.3g} rad"
            for begin, over, ratio in case.time.speed_changes
        )
        or None
    )


def _versions(case: Case) -> str:
    return ", ".join(f"{name} {version}" for name, version in sorted(case.versions.items()))


def _state(case: Case) -> str | None:
    return case.liner_state.name if case.liner_state else None


FACTS = (
    _of_mill("inner diameter", "m", lambda case: 2.0 * case.physical.radius_m),
    _of_mill("length", "m", lambda case: case.physical.length_m),
    _of_mill("gravity", "m/s²", lambda case: case.physical.gravity_m_s2),
    _of_mill("ends", "", lambda case: case.mill.ends),
    Fact(SPEED, "speed", "% of critical", lambda case: case.physical.percent_of_critical),
    Fact(SPEED, "speed", "rpm", lambda case: 30.0 * case.physical.omega_rad_s / math.pi),
    Fact(SPEED, "ramp and changes", "", _speed_changes),
    Fact(LINER, "lifters", "", lambda case: float(case.physical.lifters)),
    Fact(
        LINER,
        "lifter height",
        "mm",
        _lifter(lambda case: 1e3 * (case.physical.radius_m - case.physical.lifter_top_radius_m)),
    ),
    Fact(
        LINER, "lifter top width", "mm", _trapezoid(lambda x: 1e3 * x.physical.lifter_top_width_m)
    ),
    Fact(LINER, "face angle", "deg", _trapezoid(lambda case: case.physical.face_angle_deg)),
    Fact(
        LINER,
        "cross-section inside the liner",
        "m²",
        lambda case: case.mill.area_m2 / case.factors.length**2,
    ),
    Fact(LINER, "state", "", _state),
    Fact(CHARGE, "ball diameter", "mm", lambda case: 2e3 * case.physical.ball_radius_m),
    Fact(CHARGE, "classes of balls", "", _classes),
    Fact(CHARGE, "ball density", "kg/m³", lambda case: case.ball.density_kg_m3),
    Fact(CHARGE, "filling", "%", _filling),
    Fact(CHARGE, "mass of balls", "t", _mass),
    _material("Young's modulus", "youngs_modulus_pa", "MPa", 1e-6),
    _material("Poisson's ratio", "poisson_ratio"),
    _material("restitution, ball and ball", "restitution_pp"),
    _material("restitution, ball and wall", "restitution_pw"),
    _material("sliding friction, ball and ball", "static_friction_pp"),
    _material("sliding friction, ball and wall", "static_friction_pw"),
    _material("rolling friction, ball and ball", "rolling_friction_pp"),
    _material("rolling friction, ball and wall", "rolling_friction_pw"),
    Fact(SETTING, "scheme", "", lambda case: case.scheme),
    Fact(SETTING, "policy", "", lambda case: case.policy),
    Fact(SETTING, "S", "", lambda case: case.S),
    Fact(SETTING, "step", "µs", lambda case: 1e6 * case.time.step_s),
    Fact(SETTING, "rotation", "rad", lambda case: case.time.rotation_angle_rad),
    Fact(SETTING, "simulated length", "mm", lambda case: 1e3 * case.mill.simulated_length_m),
    Fact(SETTING, "balls simulated", "", lambda case: float(case.ball.count)),
    Fact(SETTING, "wall", "", lambda case: case.wall.kind),
    Fact(SETTING, "contacts of balls", "", lambda case: case.deck.surface),
    Fact(SETTING, "precision", "", lambda case: case.deck.precision),
    Fact(SETTING, "rolling model", "", lambda case: case.deck.rolling_model_pp),
    Fact(SETTING, "damping", "", lambda case: case.deck.tangential_damping),
    Fact(SETTING, "versions", "", _versions),
)


@dataclass(frozen=True)
class KeyRow:
    """A key of campaign files that differs, with its value in each; empty where it is absent."""

    key: str
    values: tuple[str, ...]


def key_rows(folders: Sequence[Path]) -> list[KeyRow]:
    """Return the keys in which the campaign files of some runs folders differ; none if a folder
    holds no campaign file that can be read."""
    contents = [_flat_campaign(folder) for folder in folders]
    if any(content is None for content in contents):
        return []
    known = [content for content in contents if content is not None]
    keys = dict.fromkeys(key for content in known for key in content)
    rows = [KeyRow(key, tuple(content.get(key, "") for content in known)) for key in keys]
    return [row for row in rows if len(set(row.values)) > 1]


def _flat_campaign(folder: Path) -> dict[str, str] | None:
    try:
        text = read_text(folder / CAMPAIGN_COPY, _MOST_CAMPAIGN, "")
        return dict(_flat(tomllib.loads(text), ""))
    except (RunFolderError, tomllib.TOMLDecodeError):
        return None


def _flat(content: Any, place: str) -> list[tuple[str, str]]:
    """Return the values of nested tables by their path, `liner.row[0].height_mm`."""
    if isinstance(content, Mapping):
        inner = [(f"{place}.{key}" if place else str(key), x) for key, x in content.items()]
    elif isinstance(content, list) and any(isinstance(x, Mapping) for x in content):
        inner = [(f"{place}[{number}]", x) for number, x in enumerate(content)]
    else:
        return [(place, str(content))]
    return [pair for key, x in inner for pair in _flat(x, key)]
