"""Writes files and folders that appear complete or not at all.

A file is written under the name `NAME.part` and then renamed. A link of either name is replaced,
and its target is not touched.
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
    """Open a file for writing, which gets its name at the end. If that fails, nothing is left."""
    part = path.with_name(f"{path.name}.part")
    with _renamed(part, path), part.open("xb") as file:
        yield file


@contextmanager
def writing_by_name(path: Path) -> Iterator[Path]:
    """Yield a name to write to, for libraries that open files themselves.

    The name has the same ending, by which a library may choose the format.
    """
    part = path.with_name(f"part-{path.name}")
    with _renamed(part, path):
        yield part


@contextmanager
def _renamed(part: Path, path: Path) -> Iterator[None]:
    part.unlink(missing_ok=True)
    try:
        yield
        part.replace(path)
    except BaseException:
        part.unlink(missing_ok=True)
        raise


@contextmanager
def writing_folder(folder: Path) -> Iterator[Path]:
    """Yield an empty folder to write into, which replaces the folder of that name at the end."""
    part = folder.with_name(f"{folder.name}.part")
    new_folder(part)
    yield part
    if folder.is_symlink() or folder.is_file():
        folder.unlink()
    else:
        shutil.rmtree(folder, ignore_errors=True)
    part.rename(folder)


def new_folder(folder: Path) -> None:
    """Make an empty folder in place of whatever has the name; the target of a link is kept."""
    if folder.is_symlink() or folder.is_file():
        folder.unlink()
    elif folder.is_dir():
        shutil.rmtree(folder)
    folder.mkdir()


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


def write_over(path: Path, text: str) -> None:
    """Write a text into an existing file: this works on a full disk if the file is as large."""
    descriptor = os.open(path, os.O_WRONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
    with os.fdopen(descriptor, "wb") as file:
        file.write(text.encode("utf-8"))
        file.truncate()
