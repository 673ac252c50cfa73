"""One run at a time in a folder: the kernel drops the lock when the last process with it ends."""

from __future__ import annotations

import fcntl
import os
import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from mill_campaign.errors import CampaignError
from mill_campaign.folder_check import check_folder

LOCK_FILE = ".millscale.lock"


@contextmanager
def hold(folder: Path, wait: bool = False) -> Iterator[int]:
    """Hold the lock of a folder, made if it does not exist; yields the file descriptor.

    Who finds it held gets an error, or waits. A folder that leads outside is refused.

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
        _take(descriptor, folder, wait)
        try:
            yield descriptor
        finally:
            # Emptied, not removed: otherwise two later holders could lock two different files.
            os.ftruncate(descriptor, 0)
    finally:
        os.close(descriptor)


def _take(descriptor: int, folder: Path, wait: bool) -> None:
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    except BlockingIOError:
        holder = (folder / LOCK_FILE).read_text(errors="replace") or "another process"
        raise CampaignError(
            folder,
            "",
            f"in use by {holder}, or by what it left running",
            "one run at a time; wait for it, or end those processes",
        ) from None
    since = time.strftime("%Y-%m-%d %H:%M:%S")
    holder = f"process {os.getpid()} on {socket.gethostname()} since {since}"
    os.ftruncate(descriptor, 0)
    os.pwrite(descriptor, holder.encode(), 0)
