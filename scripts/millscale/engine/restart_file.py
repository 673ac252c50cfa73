"""Restart files with the signature of `fix mill/restart`, which shows whether a file is whole."""

from __future__ import annotations

import os
import re
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

from millscale.runs.untrusted import open_regular

if TYPE_CHECKING:
    import numpy as np

SIGNATURE = re.compile(
    rb"\nmillscale restart step (\d{1,19}) bytes (\d{1,19}) crc32 ([0-9a-f]{8})"
    rb" loop_time_s ([\d.]{1,30}) processor_time_s ([\d.]{1,30})\n\Z"
)
_LONGEST_SIGNATURE = 256
_BLOCK_BYTES = 1 << 20


class NotWholeError(Exception):
    """A file that a run would continue from is not whole; the text states which and why."""


@dataclass(frozen=True)
class RestartFile:
    """A whole restart file.

    Attributes:
        step: step of the engine.
        written: time of writing [s since 1970].
        loop_time, processor_time: cost of the run until then [s]: wall time of its time loop, and
            processor time of all its ranks.
    """

    path: Path
    step: int
    written: float
    loop_time: float
    processor_time: float


def read_restart(path: Path) -> RestartFile:
    """Return step, time and cost of a restart file.

    Raises:
        NotWholeError: it is cut, changed or not signed.
        OSError: it cannot be read.
    """
    with open_regular(path) as file:
        size, written = (state := os.fstat(file.fileno())).st_size, state.st_mtime
        file.seek(max(0, size - _LONGEST_SIGNATURE))
        match = SIGNATURE.search(file.read())
        if not match:
            raise NotWholeError(f"{path.name} is not whole: {size} bytes that end unsigned")
        signed = int(match[2])
        if size != signed + len(match[0]) or _checksum(file, signed) != int(match[3], 16):
            raise NotWholeError(f"{path.name} is not what was written: its signature differs")
    return RestartFile(path, int(match[1]), written, float(match[4]), float(match[5]))


def holds(path: Path, positions: np.ndarray) -> bool:
    """Return whether a restart file holds balls at these positions.

    The engine writes a ball as doubles, with its position in sequence. y is not compared, because
    the box is periodic in it.

    Args:
        positions: (n, 3) float [m], of a few balls, known to 9 digits.
    """
    import numpy as np

    with open_regular(path) as file:
        content = file.read()
    found = np.zeros(len(positions), bool)
    for offset in range(np.dtype(float).itemsize):
        count = (len(content) - offset) // np.dtype(float).itemsize
        values = np.frombuffer(content, float, count, offset)
        for ball, (x, _, z) in enumerate(positions):
            near = np.flatnonzero(np.isclose(values[:-2], x, rtol=1e-8, atol=1e-12))
            found[ball] |= bool(np.isclose(values[near + 2], z, rtol=1e-8, atol=1e-12).any())
    return bool(found.all())


def _checksum(file: BinaryIO, size: int) -> int:
    file.seek(0)
    crc, left = 0, size
    while left > 0 and (block := file.read(min(_BLOCK_BYTES, left))):
        crc, left = zlib.crc32(block, crc), left - len(block)
    return crc
