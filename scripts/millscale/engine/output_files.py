"""Check that series and dumps of a run are complete up to a step."""

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
    """Check the existing series, and the dumps up to a step.

    On a full disk, rows and parts of dumps are lost without an error of the engine.

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
    """Return the bytes of a series from its begin to its last row up to `step`.

    Args:
        first: step at which the run began, before the first row.

    Raises:
        NotWholeError: a row before is missing or cut.
    """
    rows = list(_rows(path, step))
    if not rows:
        raise NotWholeError(f"{path.name} has no row before step {step}")
    steps = [row for row, _ in rows]
    # The engine writes a row at each multiple of a number of steps, unknown from a single row.
    every = steps[1] - steps[0] if len(steps) > 1 else 0
    alone = [row for row in steps[:1] if row > first]
    planned = range(first // every * every + every, step + 1, every) if every > 0 else alone
    for row, plan in zip_longest(steps, planned):
        if row != plan:
            raise NotWholeError(f"{path.name} has step {row}, expected {plan}")
    return rows[-1][1]


def _rows(path: Path, last: int) -> Iterator[tuple[int, int]]:
    """Yield the step of each row up to `last`, and the offset at which the row ends."""
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
    """Return whether a dump has as many lines as its header announces balls."""
    with open_regular(path) as file:
        header = [file.readline().strip() for _ in range(4)]
        file.seek(0)
        lines = sum(block.count(b"\n") for block in iter(lambda: file.read(_BLOCK_BYTES), b""))
    return header[3].isdigit() and lines == _DUMP_HEADER_LINES + int(header[3])
