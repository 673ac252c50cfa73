"""Whether what the engine wrote while it ran is all there, up to a step."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import zip_longest
from pathlib import Path

from millscale.engine.restart_file import NotWholeError
from millscale.runs.layout import DUMP_FOLDER
from millscale.runs.untrusted import open_regular

SERIES = ("series.csv", "ledger.csv")
_DUMP = re.compile(r"\.(\d+)\.liggghts$")
_DUMP_HEADER_LINES = 9
_BLOCK_BYTES = 1 << 20


def check_output(part: Path, first: int, step: int) -> None:
    """Look at the series that are there and the dumps of the steps after `first` up to `step`.

    A full disk takes rows and parts of dumps without an error of the engine.

    Raises:
        NotWholeError: a row or a part of a dump is missing.
    """
    for name in SERIES:
        if (part / name).exists():
            series_length(part / name, first, step)
    for path in sorted((part / DUMP_FOLDER).glob("*.liggghts")):
        match = _DUMP.search(path.name)
        if match and int(match[1]) <= step and not _dump_is_whole(path):
            raise NotWholeError(f"{DUMP_FOLDER}/{path.name} is not whole")


def series_length(path: Path, first: int, step: int) -> int:
    """Bytes of a series from its begin to its last row up to `step`.

    Args:
        first: step at which the run began, before the first row.

    Raises:
        NotWholeError: a row is missing or cut on the way.
    """
    rows = list(_rows(path, step))
    if not rows:
        raise NotWholeError(f"{path.name} has no row before step {step}")
    steps = [row for row, _ in rows]
    # The engine writes a row at each multiple of a number of steps; a single row does not tell it.
    every = steps[1] - steps[0] if len(steps) > 1 else 0
    alone = [row for row in steps[:1] if row > first]
    planned = range(first // every * every + every, step + 1, every) if every > 0 else alone
    for row, plan in zip_longest(steps, planned):
        if row != plan:
            raise NotWholeError(f"{path.name} has step {row} where {plan} was to be")
    return rows[-1][1]


def _rows(path: Path, last: int) -> Iterator[tuple[int, int]]:
    """Step of each row up to `last` after the header, and where in the file the row ends."""
    with open_regular(path) as file:
        header = file.readline()
        columns, end, cut = header.count(b","), len(header), False
        for line in file:
            if cut:
                raise NotWholeError(f"{path.name} has a row that is cut")
            end += len(line)
            name = line.split(b",", 1)[0]
            cut = not (line.endswith(b"\n") and line.count(b",") == columns and name.isdigit())
            if cut:
                continue
            if int(name) > last:
                return
            yield int(name), end


def _dump_is_whole(path: Path) -> bool:
    """As many lines as its header says there are balls."""
    with open_regular(path) as file:
        header = [file.readline().strip() for _ in range(4)]
        file.seek(0)
        lines = sum(block.count(b"\n") for block in iter(lambda: file.read(_BLOCK_BYTES), b""))
    return header[3].isdigit() and lines == _DUMP_HEADER_LINES + int(header[3])
