"""Writes files that appear complete or not at all.

A file is written under the name `NAME.part` and then renamed. A link of either name is replaced,
never followed.
"""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

from millscale.runs.untrusted import open_regular


@contextmanager
def writing(path: Path) -> Iterator[BinaryIO]:
    """A file to write to, which gets its name at the end; nothing stays of one that fails."""
    part = path.with_name(f"{path.name}.part")
    part.unlink(missing_ok=True)
    try:
        # x: a file or link that is there now is an error.
        with part.open("xb") as file:
            yield file
        part.replace(path)
    except BaseException:
        part.unlink(missing_ok=True)
        raise


def write_text(path: Path, text: str) -> None:
    """Write a text file in UTF-8."""
    with writing(path) as file:
        file.write(text.encode("utf-8", errors="surrogateescape"))


def write_json(path: Path, content: Any) -> None:
    """Write a JSON file. NaN is refused."""
    write_text(path, json.dumps(content, indent=1, allow_nan=False) + "\n")


def write_copy(source: Path, path: Path, length: int | None = None) -> None:
    """Copy a regular file, or its first `length` bytes."""
    with open_regular(source) as file, writing(path) as copy:
        shutil.copyfileobj(file, copy)
        if length is not None:
            copy.truncate(length)


def new_folder(folder: Path) -> None:
    """Make an empty folder in place of whatever has the name; what a link leads to stays."""
    if folder.is_symlink() or folder.is_file():
        folder.unlink()
    elif folder.is_dir():
        shutil.rmtree(folder)
    folder.mkdir()


def replace_folder(part: Path, folder: Path) -> None:
    """Rename a folder to the name of another, which goes; what a link leads to stays."""
    if folder.is_symlink() or folder.is_file():
        folder.unlink()
    else:
        shutil.rmtree(folder, ignore_errors=True)
    part.rename(folder)


def write_over(path: Path, text: str) -> None:
    """Write a text into a file that exists: a full disk takes it if it fits into its blocks."""
    descriptor = os.open(path, os.O_WRONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
    with os.fdopen(descriptor, "wb") as file:
        file.write(text.encode("utf-8"))
        file.truncate()
