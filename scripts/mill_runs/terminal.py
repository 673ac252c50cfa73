"""Text for people, whatever the locale and whatever it was read from."""

from __future__ import annotations

import io
import sys


def one_line(text: str) -> str:
    """Text in one line, without the characters that a terminal obeys.

    Bytes of file names that the locale could not decode are taken for UTF-8.
    """
    text = text.encode("utf-8", "surrogateescape").decode("utf-8", "backslashreplace")
    return " ".join("".join(x if x.isprintable() else " " for x in text).split())


def escape_unencodable() -> None:
    """Let output show characters that the locale's encoding lacks as escapes, not as an error."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
