"""Tables of points of a liner: `x_mm,y_mm`, `r_in,angle_deg` and the like, one point a row."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np

from millscale.errors import CampaignError
from millscale.liner.lengths import ACCEPTED, LENGTHS
from millscale.liner.outline import Outline
from millscale.runs.untrusted import RunFolderError, read_bytes

LARGEST_FILE_BYTES = 1 << 24
MOST_ROWS = 100_000
HEADERS = "a header x_UNIT,y_UNIT or r_UNIT,angle_deg, with UNIT one of " + ACCEPTED
_COLUMN = re.compile(r"(x|y|z|r|radius|angle|theta)_([a-z]+)")
# Degrees or radians.
_ANGLES = {"deg": math.pi / 180.0, "rad": 1.0}


def read_csv(path: Path) -> Outline:
    """Return the points of a table as an open outline of lines.

    The columns are separated by commas, semicolons, tabs or spaces. Lines that begin with # are
    comments.

    Raises:
        CampaignError: states the row.
    """
    rows = _rows(path)
    if not rows:
        raise CampaignError(path, "", "empty: no header and no row", HEADERS)
    number, words = rows[0]
    polar, unit, angle = _header(path, number, words)
    values = np.empty((len(rows) - 1, 2))
    for i, (number, words) in enumerate(rows[1:]):
        values[i] = _point(path, number, words)
    if len(values) > MOST_ROWS:
        raise CampaignError(path, "", f"{len(values):,} rows", f"<= {MOST_ROWS:,} rows")
    if len(values) < 3:
        raise CampaignError(path, "", f"{len(values)} points", "3 or more, a row each")
    if polar:
        r, theta = unit * values[:, 0], angle * values[:, 1]
        points = np.column_stack([r * np.cos(theta), r * np.sin(theta)])
    else:
        points = unit * values
    return Outline(
        file=path,
        points=points,
        bulges=np.zeros(len(points)),
        names=tuple(f"row {number}" for number, _ in rows[1:]),
        closed=False,
        unit=unit,
    )


def _rows(path: Path) -> list[tuple[int, list[str]]]:
    """Return number and words of each line that is neither empty nor a comment."""
    try:
        content = read_bytes(path, LARGEST_FILE_BYTES, "a table of points", follow=True)
    except RunFolderError as error:
        raise CampaignError(path, "", error.cause, "a table of points: " + HEADERS) from None
    if b"\0" in content:
        raise CampaignError(path, "", "not a text file: it holds bytes of 0", HEADERS)
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = content.decode("latin-1")
    lines = [line.strip() for line in re.split(r"\r\n|\r|\n", text)]
    kept = [(i, line) for i, line in enumerate(lines, 1) if line and not line.startswith("#")]
    if len(kept) > MOST_ROWS + 1:
        raise CampaignError(path, "", f"{len(kept) - 1:,} rows", f"<= {MOST_ROWS:,} rows")
    if not kept:
        return []
    separator = next((s for s in (";", ",", "\t") if s in kept[0][1]), None)
    return [(i, [word.strip() for word in line.split(separator)]) for i, line in kept]


def _header(path: Path, number: int, words: list[str]) -> tuple[bool, float, float]:
    """Return whether the columns are polar, metres of the unit and radians of the angle's unit."""
    row = f"row {number}"
    shown = ",".join(words)[:60]
    found = [_COLUMN.fullmatch(word.strip('"').lower()) for word in words]
    if len(words) != 2 or None in found:
        if words and all(_number(word) is not None for word in words):
            cause = f"no header: the first row is {shown}, so the unit is not stated"
        else:
            cause = f'got the header "{shown}"'
        raise CampaignError(path, row, cause, HEADERS)
    (first, unit), (second, other) = (match.groups() for match in found if match)
    polar = first in ("r", "radius")
    units = _ANGLES if polar else LENGTHS
    fits = second in (("angle", "theta") if polar else ("y", "z")) and (polar or first == "x")
    if unit not in LENGTHS or other not in units or not fits or (not polar and unit != other):
        raise CampaignError(path, row, f'got the header "{shown}"', HEADERS)
    return polar, LENGTHS[unit], _ANGLES.get(other, 1.0)


def _point(path: Path, number: int, words: list[str]) -> tuple[float, float]:
    values = [_number(word) for word in words]
    if len(values) == 2 and values[0] is not None and values[1] is not None:
        return values[0], values[1]
    shown = " | ".join(words)[:60]
    cause = f"got {len(words)} columns: {shown}" if len(words) != 2 else f"got {shown}"
    if len(words) == 4:
        cause += "; decimal commas?"
    raise CampaignError(
        path,
        f"row {number}",
        f"{cause}; the file may be cut short or damaged here",
        "two finite numbers with a decimal point",
    )


def _number(word: str) -> float | None:
    try:
        value = float(word)
    except ValueError:
        return None
    # 1_000 is a number to Python only.
    return value if math.isfinite(value) and abs(value) < 1e12 and "_" not in word else None
