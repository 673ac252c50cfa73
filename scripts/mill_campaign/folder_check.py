"""Nothing in a runs folder leads out of it: links to elsewhere and pipes are refused before work.

A link in a folder that came from somewhere else would let a stage overwrite any file.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from mill_campaign.errors import CampaignError
from mill_runs.layout import CASES_FOLDER

_HOLDERS = (CASES_FOLDER, "settled")
# Files of a folder and of the folders in it: cases/ID, dump/STEP. Each case is looked at by itself.
_DEPTH = 2
_ACCEPTED = "files, folders, and links that stay in the runs folder: copy what it leads to"


def check_folder(folder: Path) -> None:
    """Refuse a runs, case or bed folder that leads outside, or holds a pipe or device.

    Raises:
        CampaignError: names the first such entry.
    """
    root = folder.resolve()
    place = Path(os.path.abspath(folder))  # noqa: PTH100, as it is named, links not followed
    if place.parent.name in _HOLDERS:
        root = place.parent.parent.resolve()
        if not place.resolve().is_relative_to(root):
            raise CampaignError(folder, "", f"is a link to {place.resolve()}", _ACCEPTED)
    for entry in _entries(folder, _DEPTH):
        if entry.is_symlink():
            target = Path(entry.path).resolve()
            if not target.is_relative_to(root):
                raise CampaignError(entry.path, "", f"is a link to {target}", _ACCEPTED)
        elif not entry.is_file(follow_symlinks=False) and not entry.is_dir(follow_symlinks=False):
            raise CampaignError(entry.path, "", "is a pipe, socket or device", _ACCEPTED)


def _entries(folder: Path | str, depth: int) -> Iterator[os.DirEntry]:
    try:
        with os.scandir(folder) as entries:
            found = list(entries)
    except (FileNotFoundError, NotADirectoryError):
        return
    for entry in found:
        yield entry
        if depth > 1 and entry.is_dir(follow_symlinks=False):
            yield from _entries(entry.path, depth - 1)
