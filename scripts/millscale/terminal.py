"""Text for a terminal, independent of the locale and without control characters."""

from __future__ import annotations

import io
import sys

MOST_SHOWN = 4000


def one_line(text: str) -> str:
    """Return text in one line, without control characters; of a long one, both ends.

    Bytes of file names that the locale could not decode are taken for UTF-8.
    """
    text = text.encode("utf-8", "surrogateescape").decode("utf-8", "backslashreplace")
    line = " ".join("".join(x if x.isprintable() else " " for x in text).split())
    return line if len(line) <= MOST_SHOWN else f"{line[: MOST_SHOWN // 2]} ... {line[-200:]}"


def escape_unencodable() -> None:
    """Let output show characters that the locale's encoding lacks as escapes, not as an error."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
