"""Start of a process, which with its number identifies it. Linux only."""

from __future__ import annotations

from pathlib import Path

# Fields of /proc/NUMBER/stat between the name of the program and the start.
_BEFORE_START = 19


def process_start(number: int) -> int | None:
    """Return the start of a process [clock ticks since the machine started]; None if it is gone.

    A date would not identify it: the date of the start of the machine moves when its clock is set.
    """
    try:
        text = Path(f"/proc/{number}/stat").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return None
    # The name is in brackets and may contain spaces and brackets.
    return int(text.rpartition(")")[2].split()[_BEFORE_START])
