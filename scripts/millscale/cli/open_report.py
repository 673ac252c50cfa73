"""`millscale open`: show a report in the browser."""

from __future__ import annotations

import os
import sys
import webbrowser
from pathlib import Path
from typing import Annotated

import typer

from millscale.runs.untrusted import RunFolderError

# Where pages lie in a runs folder, or in the folder of a study, a comparison or an answer.
_PAGES = ("report/index.html", "index.html")
_RUNS = Path("runs")


def open_report(
    runs: Annotated[
        Path | None,
        typer.Argument(
            metavar="[DIR]",
            help="Runs folder, comparison or page. Default: the newest report in runs/.",
        ),
    ] = None,
) -> None:
    """Open a report in the browser; without a display print its path.

    Examples: `millscale open runs/quick`, `millscale open`
    """
    page = page_of(runs) if runs else newest_page(_RUNS)
    typer.echo(page)
    if has_display():
        webbrowser.open(page.resolve().as_uri())


def page_of(folder: Path) -> Path:
    """Return the page of a runs folder, of another folder with an index.html, or the file itself.

    Raises:
        RunFolderError: there is none.
    """
    if folder.is_file():
        return folder
    for name in _PAGES:
        if (folder / name).is_file():
            return folder / name
    raise RunFolderError(folder, "no report in it", f"make it with: millscale report {folder}")


def newest_page(folder: Path) -> Path:
    """Return the page that was written last, of the runs folders in a folder.

    Raises:
        RunFolderError: there is none.
    """
    pages = list(folder.glob("*/report/index.html"))
    if not pages:
        raise RunFolderError(folder, "no report in it", "name the runs folder: millscale open DIR")
    return max(pages, key=lambda page: page.stat().st_mtime_ns)


def has_display() -> bool:
    """Return whether a browser window can appear."""
    if sys.platform in ("darwin", "win32"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
