"""Reads files that may be damaged, or made to do harm.

A file is read only if it is a regular one and of a bounded size. JSON is UTF-8 in any locale, its
numbers are finite, its nesting is bounded.
"""

from __future__ import annotations

import errno
import json
import os
import re
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from io import BufferedReader
from pathlib import Path
from typing import Any

from millscale.terminal import one_line

# Largest files accepted [bytes]. The physical mill's dumps have 25 MB, its series 1 MB; ten
# thousand dumps take a megabyte of provenance.json.
MOST_JSON, MOST_SERIES, MOST_DUMP, MOST_LOG = 1 << 26, 1 << 30, 1 << 32, 1 << 28
# Nesting of JSON: result.json has 5 levels.
_DEEPEST = 20
# Digits of a whole number: numbers of steps and nanoseconds have 19 at most.
_MOST_DIGITS = 20
# Name of a case and of its folder, such as sb-cg-paper-S1.000.
ID = r"^[A-Za-z0-9][A-Za-z0-9._-]{0,99}\Z"
_NOT_REGULAR = "not a regular file"


class RunFolderError(ValueError):
    """A file of a runs folder that cannot be used: which, what is wrong, what to do next."""

    def __init__(self, path: Path | str, cause: str, remedy: str) -> None:
        self.path, self.cause, self.remedy = Path(path), one_line(cause), remedy
        super().__init__(one_line(f"{path}: {self.cause}; {remedy}"))

    def __reduce__(self) -> tuple[Any, ...]:
        return RunFolderError, (self.path, self.cause, self.remedy)


def open_regular(path: Path, follow: bool = False) -> BufferedReader:
    """Open a regular file for reading, without waiting for a pipe or touching a device.

    Args:
        follow: whether the file may be a link; for paths that a person typed.

    Raises:
        OSError: missing, not a regular file, a link, or not readable.
    """
    flags = os.O_RDONLY | os.O_NONBLOCK | os.O_NOCTTY | os.O_CLOEXEC
    try:
        descriptor = os.open(path, flags if follow else flags | os.O_NOFOLLOW)
    except OSError as error:
        # ENXIO: a socket, or a device without driver.
        words = {errno.ELOOP: "is a link", errno.ENXIO: _NOT_REGULAR}
        if error.errno in words:
            raise OSError(error.errno, words[error.errno], str(path)) from None
        raise
    if not stat.S_ISREG(os.fstat(descriptor).st_mode):
        os.close(descriptor)
        raise OSError(errno.EINVAL, _NOT_REGULAR, str(path))
    return os.fdopen(descriptor, "rb")


@contextmanager
def _opened(path: Path, remedy: str, follow: bool) -> Iterator[BufferedReader]:
    try:
        with open_regular(path, follow) as file:
            yield file
    except FileNotFoundError:
        raise RunFolderError(path, "no such file", remedy) from None
    except OSError as error:
        raise RunFolderError(path, f"cannot be read: {error.strerror}", remedy) from None
    except ValueError:
        raise RunFolderError(path, "cannot be read: a zero byte in its name", remedy) from None


def check_regular(path: Path, remedy: str) -> None:
    """Refuse a file that a library, which opens it by its name, would wait for.

    Raises:
        RunFolderError: missing, or no regular file.
    """
    with _opened(path, remedy, follow=False):
        pass


def read_bytes(path: Path, most: int, remedy: str, follow: bool = False) -> bytes:
    """Return the content of a regular file of at most `most` bytes.

    Raises:
        RunFolderError: missing, no regular file, or larger.
    """
    with _opened(path, remedy, follow) as file:
        content = file.read(most + 1)
    if len(content) > most:
        raise RunFolderError(path, f"larger than {most} bytes", remedy)
    return content


def read_text(path: Path, most: int, remedy: str, follow: bool = False) -> str:
    """Return the text of a regular file of at most `most` bytes.

    Raises:
        RunFolderError: missing, no regular file, larger, or not UTF-8.
    """
    content = read_bytes(path, most, remedy, follow)
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError as error:
        where = f"byte {error.start}"
        raise RunFolderError(path, f"not UTF-8 text, damaged at {where}", remedy) from None


def read_json(path: Path, remedy: str, most: int = MOST_JSON, follow: bool = False) -> Any:
    """Return the content of a JSON file whose numbers are finite and whose nesting is bounded.

    Raises:
        RunFolderError: as `read_text`, or not such JSON.
    """
    text = read_text(path, most, remedy, follow)
    try:
        content = json.loads(
            text, parse_float=_finite, parse_int=_whole, parse_constant=_no_constant
        )
    except RecursionError:
        raise RunFolderError(path, "not valid JSON (nested too deep)", remedy) from None
    except ValueError as error:
        raise RunFolderError(path, f"not valid JSON ({error}), cut short?", remedy) from None
    if _depth(content) > _DEEPEST:
        raise RunFolderError(path, "not valid JSON (nested too deep)", remedy)
    return content


def read_object(path: Path, remedy: str, most: int = MOST_JSON) -> dict[str, Any]:
    """Return the content of a JSON file that holds an object; `read_json` otherwise."""
    content = read_json(path, remedy, most)
    if not isinstance(content, dict):
        raise RunFolderError(path, "not a JSON object", remedy)
    return content


def read_tail(path: Path, most: int) -> str:
    """Return the last `most` bytes of a text file that may be growing; empty if unreadable."""
    try:
        with open_regular(path) as file:
            file.seek(max(0, os.fstat(file.fileno()).st_size - most))
            return file.read(most).decode("utf-8", errors="replace")
    except OSError:
        return ""


def read_head(path: Path, most: int) -> str:
    """Return the first `most` bytes of a text file that may be growing; empty if unreadable."""
    try:
        with open_regular(path) as file:
            return file.read(most).decode("utf-8", errors="replace")
    except OSError:
        return ""


def _finite(text: str) -> float:
    value = float(text)
    if value in (float("inf"), float("-inf")):
        raise ValueError(f"{text[:20]} is not finite")
    return value


def _whole(text: str) -> int:
    if len(text) > _MOST_DIGITS:
        raise ValueError(f"a whole number of {len(text)} digits")
    return int(text)


def _no_constant(text: str) -> float:
    raise ValueError(f"{text} is not a finite number")


def _depth(content: Any) -> int:
    """Return the levels of lists and objects in a JSON value, at most `_DEEPEST` + 1."""
    level, depth = [content], 0
    while depth <= _DEEPEST:
        level = [x for x in level if isinstance(x, dict | list)]
        if not level:
            break
        depth += 1
        level = [y for x in level for y in (x.values() if isinstance(x, dict) else x)]
    return depth


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
    """Return whether a value is a name that stays in its folder."""
    return isinstance(value, str) and re.match(ID, value) is not None
