"""Temporary folder of a run, for files that the engine, MPI and Snakemake leave when killed.

The name of the folder contains the process it belongs to. Later runs delete the folders of
processes that no longer exist.
"""

from __future__ import annotations

import os
import re
import shutil
import socket
import stat
import tempfile
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

from millscale.engine.process_start import process_start

_PREFIX = "millscale"
# Number and start of the process. An earlier version wrote a date without the `t`, and deletes
# folders whose number is another date.
_NAME = re.compile(rf"{_PREFIX}-([0-9a-f]{{8}})-([0-9]{{1,9}})-t([0-9]{{1,15}})-\w+")
# Open MPI keeps shared memory of its ranks here, whatever the temporary folder is.
SHARED_MEMORY = Path("/dev/shm")
MPI_VARIABLES = ("OMPI_MCA_btl_vader_backing_directory", "OMPI_MCA_btl_sm_backing_directory")


@contextmanager
def own_folder() -> Iterator[None]:
    """Give this process and its children a temporary folder that is deleted at the end.

    A process whose parent has one shares it. Folders of processes that have ended are deleted.
    """
    sweep()
    if _is_ours(Path(tempfile.gettempdir()).name):
        try:
            yield
        finally:
            # The run of the folder may have been killed meanwhile.
            sweep()
        return
    folders = [_make(Path(tempfile.gettempdir()))]
    changed = {"TMPDIR": str(folders[0])}
    with suppress(OSError):
        folders.append(_make(SHARED_MEMORY))
        changed |= dict.fromkeys(MPI_VARIABLES, str(folders[1]))
    before = {name: os.environ.get(name) for name in changed}
    _set(changed)
    try:
        yield
    finally:
        _set(before)
        for folder in folders:
            shutil.rmtree(folder, ignore_errors=True)


def without_own_folder(environment: Mapping[str, str]) -> dict[str, str]:
    """Return an environment for processes on other nodes, where this folder does not exist."""
    kept = {name: value for name, value in environment.items() if name not in MPI_VARIABLES}
    folder = Path(kept.get("TMPDIR", ""))
    if _NAME.fullmatch(folder.name):
        kept["TMPDIR"] = str(folder.parent)
    return kept


def run_has_ended() -> bool:
    """Return whether the run whose folder this process uses ended before it could watch its
    parent."""
    return _has_ended(Path(os.environ.get("TMPDIR", "")).name)


def sweep() -> None:
    """Delete the folders of ended processes of this user and machine."""
    here = Path(tempfile.gettempdir())
    places = {here.parent if _NAME.fullmatch(here.name) else here, SHARED_MEMORY}
    for place in places:
        with suppress(OSError), os.scandir(place) as entries:
            left = [x for x in entries if _NAME.fullmatch(x.name)]
            for entry in left:
                found = entry.stat(follow_symlinks=False)
                mine = stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid()
                if mine and _has_ended(entry.name):
                    shutil.rmtree(entry.path, ignore_errors=True)


def _make(place: Path) -> Path:
    number = os.getpid()
    prefix = f"{_PREFIX}-{_host()}-{number}-t{process_start(number)}-"
    return Path(tempfile.mkdtemp(prefix=prefix, dir=place))


def _is_ours(name: str) -> bool:
    """Return whether a folder belongs to a run on this machine that still exists."""
    match = _NAME.fullmatch(name)
    return match is not None and match[1] == _host() and not _has_ended(name)


def _has_ended(name: str) -> bool:
    match = _NAME.fullmatch(name)
    if not match or match[1] != _host():
        return False
    return process_start(int(match[2])) != int(match[3])


def _host() -> str:
    return f"{zlib.crc32(socket.gethostname().encode()):08x}"


def _set(variables: Mapping[str, str | None]) -> None:
    for name, value in variables.items():
        if value is None:
            os.environ.pop(name, None)
        else:
            os.environ[name] = value
    # The module remembers the folder; look it up again.
    tempfile.tempdir = None
