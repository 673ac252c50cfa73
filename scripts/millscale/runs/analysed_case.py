"""What every analysis reads of case.json, checked before anything is computed."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from millscale.runs.untrusted import RunFolderError, is_id

_SHOWN = 60
_ABSENT = object()


def _positive(value: Any) -> bool:
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return number and value > 0 and value < 1e300 and math.isfinite(value)


def _count(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 0 < value <= 10**9


def _lifters(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value <= 10**4


_Rule = tuple[Callable[[Any], bool], str]
_NAME: _Rule = (is_id, "a name of letters, digits, points and hyphens")
_ABOVE_0: _Rule = (_positive, "a finite number > 0")
_CASE: dict[str, _Rule] = {
    **dict.fromkeys(("id", "kind", "scheme", "policy"), _NAME),
    **dict.fromkeys(
        (
            *("S", "mill.radius_m", "mill.gravity_m_s2", "mill.omega_rad_s"),
            *("ball.radius_m", "ball.mass_kg"),
        ),
        _ABOVE_0,
    ),
    "ball.count": (_count, "a whole number from 1 to 1e9"),
    "mill.lifters": (_lifters, "a whole number from 0 to 10,000"),
}


def check_case(path: Path, case: Mapping[str, Any], remedy: str) -> None:
    """Refuse a case.json in which what every analysis reads is no such thing.

    Raises:
        RunFolderError: names the first such key.
    """
    for name, (accepts, accepted) in _CASE.items():
        value: Any = case
        for key in name.split("."):
            value = value.get(key, _ABSENT) if isinstance(value, Mapping) else _ABSENT
        if value is _ABSENT:
            raise RunFolderError(path, f"{name} is missing", remedy)
        if not accepts(value):
            shown = repr(value)[:_SHOWN]
            raise RunFolderError(path, f"{name}: got {shown}, accepted: {accepted}", remedy)
