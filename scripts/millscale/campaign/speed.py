"""The mill's speed against its angle: the ramp at the start and the changes of `[[speed]]`."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from millscale import _core
from millscale.campaign.campaign import Mill
from millscale.campaign.units import resolve, speed_forms
from millscale.errors import CampaignError
from millscale.runs.case_file import SpeedChange

Section = Mapping[str, Any]


def speed_changes(
    path: Path, ramp_turns: float, entries: Sequence[Section], mill: Mill, ball_radius: float
) -> tuple[SpeedChange, ...]:
    """Return the changes of the speed of a campaign part, in mill angle and over the mill's speed.

    Args:
        ramp_turns: turns from rest to the mill's speed; 0: at that speed from the start.
        entries: of [[speed]].

    Raises:
        CampaignError: an entry without begin or speed, before the end of the one above it, or of a
            mill that centrifuges.
    """
    changes: list[SpeedChange] = []
    if ramp_turns > 0.0:
        changes.append((0.0, math.tau * ramp_turns, 1.0))
    for number, entry in enumerate(entries, 1):
        where = f"speed[{number}]"
        begin = _begin(path, where, entry, _core.SpeedSchedule(changes), mill)
        omega = _speed(path, where, entry, mill, ball_radius)
        changes.append((begin, math.tau * entry["ramp_turns"], omega / mill.omega))
        try:
            _core.SpeedSchedule(changes)
        except ValueError as cause:
            accepted = "a begin after the end of the change above it, or after the ramp"
            raise CampaignError(path, where, str(cause), accepted) from None
    return tuple(changes)


def _begin(
    path: Path, where: str, entry: Section, before: _core.SpeedSchedule, mill: Mill
) -> float:
    """Return the mill angle at which a change begins [rad].

    Args:
        before: the speed up to this change.
    """
    forms = {
        "from_turns": lambda value: value * math.tau,
        "from_s": lambda value: before.angle(value * mill.omega),
    }
    begin = resolve(entry, forms, "rad of mill angle", (path, where))
    if begin is None:
        raise CampaignError(path, where, "its begin is missing", "one of " + ", ".join(forms))
    return begin


def _speed(path: Path, where: str, entry: Section, mill: Mill, ball_radius: float) -> float:
    """Return the speed after a change [rad/s]."""
    forms = speed_forms(mill.radius, ball_radius, mill.gravity)
    omega = resolve(entry, forms, "rad/s", (path, where))
    if omega is None:
        raise CampaignError(path, where, "its speed is missing", "one of " + ", ".join(forms))
    froude = _core.froude_number(mill.radius, mill.gravity, omega)
    if froude >= 1.0 and not mill.allow_centrifuging:
        raise CampaignError(
            path,
            where,
            f"Froude number omega^2 R / g = {froude:.3g}: the mill centrifuges",
            "Fr < 1, or mill.allow_centrifuging = true",
        )
    return omega
