"""Text for people, whatever the locale and whatever it was read from."""

from __future__ import annotations

import io
import sys

MOST_SHOWN = 4000


def one_line(text: str) -> str:
    """Text in one line, without the characters that a terminal obeys; of a very long one the ends.

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
