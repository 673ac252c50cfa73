"""SHA-256 of the files of a folder, computed again only if a file may have changed.

A digest is known by size, times and inode of its file. Whoever replaces or edits a file changes one
of them, and a copy has another inode, so what is known is never used for another content: the inode
change time cannot be set. Times are compared for equality only, so no clock decides anything.
"""

from __future__ import annotations

import errno
import hashlib
import json
import os
import stat
import time
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

from millscale.runs.untrusted import RunFolderError, open_regular, read_object, understood
from millscale.runs.writing import write_json

CACHE_FILE = ".digests"
# No file of ours is as large, and a larger one would take minutes: one of holes can have any size.
MOST_BYTES = 1 << 33
# A file that is written again within one tick of the file system's clock has the same times. No
# digest is remembered before its file has rested for so long.
RESTED_NS = 2 * 10**9

_State = tuple[int, int, int, int]
# Of every folder that this process has looked at: name -> state of the file, digest.
_KNOWN: dict[str, dict[str, tuple[_State, str]]] = {}


def digest_of(path: Path, follow: bool = False) -> str:
    """Return the SHA-256 of a regular file, in hexadecimal; `follow` as in `open_regular`."""
    with open_regular(path, follow) as file:
        if os.fstat(file.fileno()).st_size > MOST_BYTES:
            raise OSError(errno.EFBIG, f"larger than {MOST_BYTES} bytes", str(path))
        return hashlib.file_digest(file, "sha256").hexdigest()


def text_digest(text: str) -> str:
    """Return the SHA-256 of a text in UTF-8, in hexadecimal."""
    return hashlib.sha256(text.encode()).hexdigest()


def json_digest(content: Any) -> str:
    """Return the SHA-256 of JSON content, whatever the order of the keys."""
    return text_digest(json.dumps(content, sort_keys=True))


def files_of(folder: Path, names: Iterable[str]) -> Iterator[str]:
    """Yield the names that are files, and the files in folders of the other names; no links."""
    for name in sorted(names):
        path = folder / name
        if path.is_symlink():
            continue
        if path.is_dir():
            yield from files_of(folder, (f"{name}/{x.name}" for x in path.iterdir()))
        elif path.is_file():
            yield name


class Digests:
    """Digests of the files of one folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        place = os.path.abspath(folder)  # noqa: PTH100, links need not be followed
        if place not in _KNOWN:
            _KNOWN[place] = _read_cache(folder)
        self._known = _KNOWN[place]

    def of(self, name: str) -> str | None:
        """Return the SHA-256 of a regular file of the folder; None if there is none."""
        path = self.folder / name
        try:
            before = path.lstat()
            if before.st_size > MOST_BYTES:
                return None
            known = self._known.get(name)
            if known and known[0] == _state(before) and stat.S_ISREG(before.st_mode):
                return known[1]
            with open_regular(path) as file:
                digest = hashlib.file_digest(file, "sha256").hexdigest()
                after = os.fstat(file.fileno())
        except (OSError, ValueError):
            return None
        if _state(before) == _state(after) and time.time_ns() - after.st_ctime_ns > RESTED_NS:
            self._known[name] = (_state(after), digest)
        else:
            self._known.pop(name, None)
        return digest


def keep(folder: Path) -> None:
    """Keep what is known of a folder for the next command, if the folder can be written to."""
    known = _KNOWN.get(os.path.abspath(folder), {})  # noqa: PTH100
    if not known or known == _read_cache(folder):
        return
    rows = {name: [*state, digest] for name, (state, digest) in sorted(known.items())}
    with suppress(OSError):
        write_json(folder / CACHE_FILE, {"schema": 1, "digests": rows})


def rested_state(path: Path) -> _State | None:
    """Return a state that a regular file has with its present content only; None if there is no
    such file, or if it was written too lately to be sure."""
    try:
        found = path.lstat()
    except (OSError, ValueError):
        return None
    rested = time.time_ns() - found.st_ctime_ns > RESTED_NS
    return _state(found) if rested and stat.S_ISREG(found.st_mode) else None


def _state(found: os.stat_result) -> _State:
    return found.st_size, found.st_mtime_ns, found.st_ctime_ns, found.st_ino


def _read_cache(folder: Path) -> dict[str, tuple[_State, str]]:
    """Return the digests that an earlier command kept; none if they cannot be read."""
    path = folder / CACHE_FILE
    try:
        rows = read_object(path, "")
        with understood(path, ""):
            return {
                name: ((int(size), int(modified), int(changed), int(inode)), str(digest))
                for name, (size, modified, changed, inode, digest) in rows["digests"].items()
            }
    except RunFolderError:
        return {}
