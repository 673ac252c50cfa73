"""The decks of a case folder: copies of the templates, which the user may edit and run by hand."""

from __future__ import annotations

import re
from pathlib import Path

from millscale.runs.untrusted import read_text
from millscale.runs.writing import write_copy

_INCLUDE = re.compile(r"^\s*include\s+(\S+\.in)\b", re.M)
_VARIABLE = re.compile(r"\$\{\w+\}")
PARAMETERS_FILE = "parameters.in"
MOST_DECK_BYTES = 1 << 20


def template_folder() -> Path:
    """Return where the decks are: in the package when installed, at the top of the sources
    otherwise."""
    installed = Path(__file__).parents[1] / "templates"
    return installed if installed.is_dir() else Path(__file__).parents[3] / "templates"


def deck_text(path: Path) -> str:
    """Return the text of a deck.

    Raises:
        RunFolderError: not a text of a few pages.
    """
    return read_text(
        path, MOST_DECK_BYTES, "a deck: millscale run copies it anew if it is not there"
    )


def with_included(decks: tuple[str, ...], folder: Path) -> list[str]:
    """Return the decks and every file they include, themselves or through others; no parameters.in.

    A name with a variable, liner_${wall}.in, stands for every file it can become.
    """
    found: list[str] = []
    waiting = list(decks)
    while waiting:
        name = waiting.pop(0)
        if name in found or name == PARAMETERS_FILE:
            continue
        found.append(name)
        for included in _INCLUDE.findall(deck_text(folder / name)):
            pattern = _VARIABLE.sub("*", included)
            waiting += (
                [included] if pattern == included else sorted(p.name for p in folder.glob(pattern))
            )
    return found


def copy_decks(decks: tuple[str, ...], destination: Path) -> None:
    """Copy the decks and what they include; the copies are new files with a new date."""
    templates = template_folder()
    for name in with_included(decks, templates):
        write_copy(templates / name, destination / name)
