"""The liner of a campaign: trapezoidal lifters, a file, rows of lifters or a preset; its states."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from millscale.campaign.campaign import Liner, LinerState
from millscale.errors import CampaignError
from millscale.liner.given import (
    ANGLES,
    Given,
    Preset,
    Source,
    liner_from_file,
    liner_of_preset,
    liner_of_rows,
)
from millscale.liner.lifter_rows import LifterRow

Section = Mapping[str, Any]
# Ways to state a liner, and the keys that each takes beside those of every liner.
FILE_KEYS = ("unit", "layer", "turns", "tolerance_m", "centre_x_m", "centre_y_m")
TRAPEZOID = ("lifter_top_radius_m", "lifter_top_width_m", "groove_width_m", "face_angle_deg")
OF_PRESETS = {
    "plain": (),
    "wave": ("lifter_height_m",),
    "step": ("lifter_height_m", "face_angle_deg", "edge_radius_m"),
    "rail": ("lifter_height_m", "lifter_top_width_m", "face_angle_deg", "edge_radius_m"),
    "ship-lap": (
        *("lifter_height_m", "lifter_top_width_m", "face_angle_deg", "trailing_angle_deg"),
        "edge_radius_m",
    ),
}
NAME = re.compile(r"(?=.{1,20}\Z)[a-z][a-z0-9]*(-[a-z0-9]+)*")
WAYS = ("profile", "stl", "preset", "row")


def build_liner(path: Path, liner: Section, mill: Section) -> Liner | None:
    """Return the liner that a file, rows or a preset state; None: trapezoidal lifters or a drum.

    Raises:
        CampaignError: contradictory keys, or a file that is no liner of the mill.
    """
    given = [way for way in WAYS if liner.get(way)]
    if len(given) > 1:
        cause = f"the liner is stated by {' and by '.join(given)}"
        raise CampaignError(path, f"liner.{given[1]}", cause, "one of them")
    way = given[0] if given else ""
    _refuse_others(path, liner, way)
    if not way:
        return None
    radius, phase = mill["radius_m"], math.radians(liner["phase_deg"])
    if way == "row":
        return _of_rows(path, liner, radius, phase)
    if way == "preset":
        return _of_preset(path, liner, radius, phase)
    return liner_from_file(_source(path, liner, liner[way], liner), radius, phase)


def build_states(path: Path, liner: Section, mill: Section) -> tuple[LinerState, ...]:
    """Return the states of the liner over its life, such as new and worn; empty if there is one.

    Raises:
        CampaignError: two states of one name, or a file that is no liner of the mill.
    """
    states: list[LinerState] = []
    radius, phase = mill["radius_m"], math.radians(liner["phase_deg"])
    for number, state in enumerate(liner.get("state", ()), 1):
        where = f"liner.state[{number}]"
        name = state["name"]
        if not NAME.fullmatch(name):
            accepted = "up to 20 lower-case letters, digits and single hyphens, such as worn"
            raise CampaignError(path, f"{where}.name", f'got "{name}"', accepted)
        if any(name == other.name for other in states):
            raise CampaignError(path, f"{where}.name", f'got "{name}" twice', "different names")
        shape = _of_state(path, where, state, liner, radius, phase)
        states.append(LinerState(name, state["hours"], state["tonnes"], shape))
    return tuple(states)


def _of_state(
    path: Path, where: str, state: Section, liner: Section, radius: float, phase: float
) -> Liner:
    files = [key for key in ("profile", "stl") if state[key]]
    if len(files) != 1:
        what = "both given" if files else "missing"
        raise CampaignError(path, f"{where}.profile", f"and stl {what}", "one of the two")
    return liner_from_file(_source(path, state, state[files[0]], liner), radius, phase)


def _source(path: Path, own: Section, file: str, common: Section) -> Source:
    """Return a file with its keys; those that a state lacks are taken from [liner]."""

    def value(key: str) -> Any:
        return own[key] if own.get(key) is not None else common.get(key)

    return Source(
        path=path.parent / file,
        unit=value("unit"),
        layer=value("layer"),
        centre=(value("centre_x_m") or 0.0, value("centre_y_m") or 0.0),
        tolerance=value("tolerance_m"),
        turns=value("turns"),
        lifters=common["lifters"] or None,
    )


def _refuse_others(path: Path, liner: Section, way: str) -> None:
    """Refuse keys that the way in which the liner is stated does not take."""
    of_preset = OF_PRESETS.get(liner["preset"] or "", ())
    taken = {
        "": (*TRAPEZOID, "lifter_height_m"),
        "profile": FILE_KEYS,
        "stl": FILE_KEYS,
        "preset": of_preset,
        "row": (),
    }[way]
    if liner.get("state"):
        taken = (*taken, *FILE_KEYS)
    every = {*TRAPEZOID, *FILE_KEYS, *(key for keys in OF_PRESETS.values() for key in keys)}
    for key in sorted(every - set(taken)):
        if liner.get(key) is not None:
            said = f"liner.{way}" if way else "trapezoidal lifters"
            if way == "preset":
                said = f'preset = "{liner["preset"]}"'
            accepted = f"no such key with {said}"
            if taken:
                accepted += f", which takes {', '.join(taken)}"
            raise CampaignError(path, f"liner.{key}", f"given with {said}", accepted)


def _needed(path: Path, liner: Section, keys: tuple[str, ...], what: str) -> None:
    for key in keys:
        if not liner[key]:
            raise CampaignError(path, f"liner.{key}", "missing", f"needed with {what}")


def _of_rows(path: Path, liner: Section, radius: float, phase: float) -> Given:
    _needed(path, liner, ("lifters",), "[[liner.row]]")
    rows = tuple(
        LifterRow(
            height=row["height_m"],
            top_width=row["top_width_m"],
            leading_angle=math.radians(row["leading_angle_deg"]),
            trailing_angle=math.radians(
                row["leading_angle_deg"]
                if row["trailing_angle_deg"] is None
                else row["trailing_angle_deg"]
            ),
            edge_radius=row["edge_radius_m"],
        )
        for row in liner["row"]
    )
    return liner_of_rows(path, radius, rows, liner["lifters"], phase)


def _of_preset(path: Path, liner: Section, radius: float, phase: float) -> Given:
    family = liner["preset"]
    said = f'preset = "{family}"'
    if family == "plain":
        if liner["lifters"]:
            cause = f"got {liner['lifters']} with {said}"
            raise CampaignError(path, "liner.lifters", cause, "no such key")
        return liner_of_preset(path, radius, Preset(family, 0), phase)
    needed = ("lifters", "lifter_height_m", "lifter_top_width_m")
    _needed(path, liner, tuple(k for k in needed if k in ("lifters", *OF_PRESETS[family])), said)
    leading, trailing = ANGLES.get(family, (0.0, 0.0))
    if liner["face_angle_deg"] is not None:
        leading = math.radians(liner["face_angle_deg"])
        trailing = trailing or leading
    if liner["trailing_angle_deg"] is not None:
        trailing = math.radians(liner["trailing_angle_deg"])
    preset = Preset(
        family=family,
        lifters=liner["lifters"],
        height=liner["lifter_height_m"],
        top_width=liner["lifter_top_width_m"] or 0.0,
        leading_angle=leading,
        trailing_angle=trailing,
        edge_radius=liner["edge_radius_m"] or 0.0,
    )
    return liner_of_preset(path, radius, preset, phase)
