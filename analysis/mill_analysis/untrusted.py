"""Files of a run folder may be damaged, or made to do harm: reading within bounds, checking."""

from __future__ import annotations

import math
import re
import stat
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

# What a file may hold of text [bytes]. The physical mill's dumps have 25 MB, its series 1 MB.
MOST_JSON, MOST_SERIES, MOST_DUMP = 1 << 26, 1 << 30, 1 << 32
_ID = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,99}")
_SHOWN = 60
_ABSENT = object()


class RunFolderError(ValueError):
    """A product of a run that cannot be used: which file, what is wrong, what to do next."""

    def __init__(self, path: Path, cause: str, remedy: str) -> None:
        self.path, self.cause, self.remedy = Path(path), " ".join(cause.split()), remedy
        super().__init__(f"{path}: {self.cause}; {remedy}")


def read_text(path: Path, most: int, remedy: str) -> str:
    """Text of a regular file of at most `most` bytes.

    Raises:
        RunFolderError: missing, no regular file, larger, or not UTF-8.
    """
    try:
        # Before it is opened: a pipe would be waited for.
        if not stat.S_ISREG(path.stat().st_mode):
            raise RunFolderError(path, "not a regular file", remedy)
        with path.open("rb") as file:
            content = file.read(most + 1)
    except FileNotFoundError:
        raise RunFolderError(path, "no such file", remedy) from None
    except OSError as error:
        raise RunFolderError(path, f"cannot be read: {error.strerror}", remedy) from None
    if len(content) > most:
        raise RunFolderError(path, f"larger than {most} bytes", remedy)
    try:
        return content.decode()
    except UnicodeDecodeError as error:
        where = f"byte {error.start}"
        raise RunFolderError(path, f"not text, damaged at {where}", remedy) from None


@contextmanager
def understood(path: Path, remedy: str) -> Iterator[None]:
    """Turn what damaged content does to the arithmetic into an error that names the file."""
    try:
        yield
    except RunFolderError:
        raise
    except KeyError as error:
        raise RunFolderError(path, f"{error} is missing", remedy) from None
    except (ValueError, TypeError, IndexError, AttributeError, ArithmeticError) as error:
        cause = f"not understood: {type(error).__name__}: {str(error)[:200]}"
        raise RunFolderError(path, cause, remedy) from None
    except (RecursionError, MemoryError) as error:
        raise RunFolderError(path, f"too large: {type(error).__name__}", remedy) from None


def is_id(value: Any) -> bool:
    """Whether a value is a name that stays in its folder."""
    return isinstance(value, str) and _ID.fullmatch(value) is not None


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
# What every analysis reads of case.json.
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
