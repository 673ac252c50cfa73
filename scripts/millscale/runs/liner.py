"""The liner's cross-section in a case.json: how it is written and how it is read."""

from __future__ import annotations

import math
from typing import Any

from millscale import _core
from millscale.runs.case_file import Mill


def liner_keys(liner: _core.Profile) -> dict[str, Any]:
    """Return the keys of a cross-section, which `physical` and `mill` share.

    A shape that is not of trapezoidal lifters has its sectors as `lifters`, its smallest radius as
    `lifter_top_radius_m` and its narrowest width as `groove_width_m`.
    """
    if isinstance(liner, _core.Lifters):
        return {
            "lifter_top_radius_m": liner.lifter_top_radius,
            "lifter_top_width_m": liner.lifter_top_width,
            "groove_width_m": liner.groove_width,
            "lifters": liner.lifters,
            "face_angle_deg": math.degrees(liner.face_angle),
        }
    return {
        "lifter_top_radius_m": liner.clear_radius,
        "lifter_top_width_m": 0.0,
        "groove_width_m": liner.narrowest_width,
        "lifters": liner.sectors,
        "face_angle_deg": 0.0,
    }


def profile_rows(liner: _core.Profile) -> tuple[tuple[float, float, float, int, int], ...] | None:
    """Return the nodes of a shape that the keys do not describe; None for lifters."""
    return None if isinstance(liner, _core.Lifters) else tuple(liner.nodes)


def liner_of(mill: Mill) -> _core.Profile:
    """Return the liner that the part `mill` of a case.json describes."""
    if mill.profile:
        return _core.Profile(list(mill.profile), mill.lifters, mill.phase_rad)
    # Of a drum the widths have no meaning.
    drum = mill.lifters == 0
    return _core.Lifters(
        mill.radius_m,
        0.0 if drum else mill.lifter_top_radius_m,
        0.0 if drum else mill.lifter_top_width_m,
        0.0 if drum else mill.groove_width_m,
        mill.lifters,
        mill.phase_rad,
    )
