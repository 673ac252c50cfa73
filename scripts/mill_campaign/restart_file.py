"""Restart files signed by `fix mill/restart`: whole ones are told from cut or changed ones."""

from __future__ import annotations

import os
import re
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from mill_runs.untrusted import open_regular

_SIGNATURE = re.compile(
    rb"\nmillscale restart step (\d{1,19}) bytes (\d{1,19}) crc32 ([0-9a-f]{8})"
    rb" loop_time_s ([\d.]{1,30}) processor_time_s ([\d.]{1,30})\n\Z"
)
_LONGEST_SIGNATURE = 256
_BLOCK_BYTES = 1 << 20


class NotWholeError(Exception):
    """A file that a run would go on from is not whole; the text says which and why."""


@dataclass(frozen=True)
class RestartFile:
    """A whole restart file.

    Attributes:
        step: time step of the engine it holds.
        written: when it was [s since 1970].
        loop_time, processor_time: cost of the engine that wrote it until then [s]: of its time
            loop, and of all its ranks.
    """

    path: Path
    step: int
    written: float
    loop_time: float
    processor_time: float


def read_restart(path: Path) -> RestartFile:
    """What a restart file says of itself.

    Raises:
        NotWholeError: it is cut, changed or not signed.
        OSError: it cannot be read.
    """
    with open_regular(path) as file:
        size, written = (state := os.fstat(file.fileno())).st_size, state.st_mtime
        file.seek(max(0, size - _LONGEST_SIGNATURE))
        match = _SIGNATURE.search(file.read())
        if not match:
            raise NotWholeError(f"{path.name} is not whole: {size} bytes that end unsigned")
        signed = int(match[2])
        if size != signed + len(match[0]) or _checksum(file, signed) != int(match[3], 16):
            raise NotWholeError(f"{path.name} is not what was written: its signature differs")
    return RestartFile(path, int(match[1]), written, float(match[4]), float(match[5]))


def _checksum(file: BinaryIO, size: int) -> int:
    file.seek(0)
    crc, left = 0, size
    while left > 0 and (block := file.read(min(_BLOCK_BYTES, left))):
        crc, left = zlib.crc32(block, crc), left - len(block)
    return crc
