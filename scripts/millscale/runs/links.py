"""Refuses runs folders with links that lead out of them, and with pipes and devices.

In a folder from elsewhere, a link could make a stage or the engine overwrite any file. A folder is
therefore checked as a whole before anything is written into it.
"""

from __future__ import annotations

import os
from pathlib import Path

from millscale.runs.layout import CASES_FOLDER
from millscale.runs.untrusted import RunFolderError

_HOLDERS = (CASES_FOLDER, "settled")
# Folders within folders: settings/NAME/cases/ID/rotate.part/dump of a study has 6.
_DEEPEST = 12
_REMEDY = "a runs folder holds files, folders, and links that stay in it"


def check_folder(folder: Path) -> None:
    """Refuse a runs, case or bed folder with a link that leads out of the runs folder at any depth.

    Takes 0.2 s for 10,000 cases.

    Raises:
        RunFolderError: names the first such link, a pipe, socket or device, or a folder that is
            nested too deep to be one of ours.
    """
    place = os.path.abspath(folder)  # noqa: PTH100, as it is named, links not followed
    root = os.path.realpath(folder)
    runs, holder = os.path.split(os.path.dirname(place))  # noqa: PTH120
    if holder in _HOLDERS:
        root = os.path.realpath(runs)
        if not _is_inside(os.path.realpath(place), root):
            raise _refused(folder, f"is a link to {os.path.realpath(place)}")
    waiting = [(os.fspath(folder), 1)]
    while waiting:
        path, depth = waiting.pop()
        if depth > _DEEPEST:
            raise _refused(path, f"is nested deeper than {_DEEPEST} folders")
        try:
            with os.scandir(path) as entries:
                found = list(entries)
        except (FileNotFoundError, NotADirectoryError):
            # Gone since its folder was listed.
            continue
        for entry in found:
            if entry.is_symlink():
                target = os.path.realpath(entry.path)
                if not _is_inside(target, root):
                    raise _refused(entry.path, f"is a link to {target}")
            elif entry.is_dir(follow_symlinks=False):
                waiting.append((entry.path, depth + 1))
            elif not entry.is_file(follow_symlinks=False):
                raise _refused(entry.path, "is a pipe, socket or device")


def _is_inside(path: str, root: str) -> bool:
    return path == root or path.startswith(root.rstrip("/") + "/")


def _refused(path: Path | str, cause: str) -> RunFolderError:
    return RunFolderError(path, cause, f"{_REMEDY}: remove it, or copy what it leads to")
