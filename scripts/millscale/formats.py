"""Numbers and durations as text for people; a dash where there is none."""

from __future__ import annotations

import math

NONE = "–"


def counted(count: int, noun: str) -> str:
    """Return a count with its noun, whose plural ends in s: 1 case, 2 cases, no cases."""
    return f"{count or 'no'} {noun}{'' if count == 1 else 's'}"


def number(value: float | None, digits: int = 3) -> str:
    """Return a number with fixed decimals, or with three digits if those would show none."""
    if value is None:
        return NONE
    hidden = value != 0.0 and abs(value) < 10.0**-digits
    return f"{value:.3g}" if hidden else f"{value:.{digits}f}"


def percent(value: float | None, digits: int = 2) -> str:
    """Return a share as a signed percentage."""
    return NONE if value is None else f"{100.0 * value:+.{digits}f} %"


def hundredths(value: float | None, digits: int = 2, signed: bool = False) -> str:
    """Return a share in hundredths, for a column headed %."""
    return NONE if value is None else f"{100.0 * value:{'+' if signed else ''}.{digits}f}"


def degrees(angle: float | None) -> str:
    """Return an angle [rad] in degrees."""
    return NONE if angle is None else f"{math.degrees(angle):.1f}"


def duration(seconds: float | None) -> str:
    """Return a duration: 3.1 s, 42 s, 3 min 5 s, 2 h 10 min."""
    if seconds is None:
        return NONE
    if round(seconds, 1) < 10.0:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    if minutes == 0:
        return f"{rest} s"
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes:02d} min" if hours else f"{minutes} min {rest} s"


def clock(seconds: float | None) -> str:
    """Return a duration for a column headed [h:min:s]: 0:00:42, with tenths below ten seconds."""
    if seconds is None:
        return NONE
    if round(seconds, 1) < 10.0:
        return f"0:00:{seconds:04.1f}"
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes // 60}:{minutes % 60:02d}:{rest:02d}"


def rounded_up(value: float) -> float:
    """Return a positive number to two digits, not below it."""
    power = 10.0 ** (math.floor(math.log10(value)) - 1)
    return math.ceil(value / power - 1e-9) * power
