"""Lock of a folder, one run at a time. The kernel drops it when the last holder ends."""

from __future__ import annotations

import fcntl
import os
import re
import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from millscale.errors import CampaignError
from millscale.runs.links import check_folder

LOCK_FILE = ".millscale.lock"
_HOLDER = re.compile(r"process (\d{1,9}) on (\S+) since")
_HOLDER_BYTES = 512
_ENDING_S = 20.0


@contextmanager
def hold(folder: Path, wait: bool = False, patience_s: float = 0.0) -> Iterator[int]:
    """Hold the lock of a folder, made if it does not exist; yields the file descriptor.

    If the lock is held, raise an error, or wait. Children of a holder that was killed get some
    seconds to end, and a holder that still runs gets `patience_s` [s]. Taking the lock also checks
    that no link leaves the runs folder.

    A child that inherits the descriptor keeps the lock until it ends too: so an engine that
    outlives its stage, or a workflow that outlives its command, still keeps others out.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        cause = f"cannot be made: {error.strerror}"
        raise CampaignError(folder, "", cause, "a folder you may write to") from None
    check_folder(folder)
    descriptor = os.open(folder / LOCK_FILE, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o644)
    try:
        _take(descriptor, folder, wait, patience_s)
        try:
            yield descriptor
        finally:
            # Emptied, not removed: otherwise two later holders could lock two different files.
            os.ftruncate(descriptor, 0)
    finally:
        os.close(descriptor)


def _take(descriptor: int, folder: Path, wait: bool, patience_s: float) -> None:
    begin = time.monotonic()
    while not _free(descriptor, wait):
        holder = os.pread(descriptor, _HOLDER_BYTES, 0).decode("utf-8", errors="replace")
        holder = holder or "another process"
        if time.monotonic() < begin + (_ENDING_S if is_gone(holder) else patience_s):
            time.sleep(0.1)
            continue
        raise CampaignError(
            folder,
            "",
            f"in use by {holder}, or by what it left running",
            "one run at a time; wait for it, or end those processes",
        )
    since = time.strftime("%Y-%m-%d %H:%M:%S")
    holder = f"process {os.getpid()} on {socket.gethostname()} since {since}"
    os.ftruncate(descriptor, 0)
    os.pwrite(descriptor, holder.encode(), 0)


def _free(descriptor: int, wait: bool) -> bool:
    """Return whether the lock could be taken."""
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
        return True
    except BlockingIOError:
        return False


def is_gone(holder: str) -> bool:
    """Return whether the process that took the lock has ended; its children may still hold it."""
    match = _HOLDER.match(holder)
    if not match or match[2] != socket.gethostname():
        return False
    try:
        os.kill(int(match[1]), 0)
    except ProcessLookupError:
        return True
    except PermissionError:
        return False
    return False
