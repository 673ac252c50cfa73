"""Reading of LIGGGHTS custom dumps, dump/charge.<step>.liggghts of a multi-ball case."""

from __future__ import annotations

import re
import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from millscale.runs.current import is_as_made
from millscale.runs.untrusted import MOST_DUMP, RunFolderError, read_text

_NAME = re.compile(r"charge\.([0-9]{1,19})\.liggghts")
_REMEDY = "delete it, or run the case again: millscale run FILE --runs DIR --only ID"


@dataclass(frozen=True)
class Dump:
    """The balls at one step, in order of their id.

    Attributes:
        columns: each (n,) float, by the name in the dump (id, x, y, z, vx, ...), SI units.
    """

    step: int
    columns: dict[str, np.ndarray]

    def __getitem__(self, name: str) -> np.ndarray:
        return self.columns[name]

    def __len__(self) -> int:
        return self.columns["id"].size

    @property
    def positions(self) -> np.ndarray:
        """(n, 3) float [m]."""
        return np.column_stack([self.columns[axis] for axis in "xyz"])


def dump_files(folder: Path) -> dict[int, Path]:
    """Return the dumps of a case folder by step, in order of step."""
    by_step = {}
    for path in (folder / "dump").glob("charge.*.liggghts"):
        if step := _NAME.fullmatch(path.name):
            by_step[int(step[1])] = path
    return dict(sorted(by_step.items()))


def required_dumps(folder: Path) -> dict[int, Path]:
    """Return `dump_files` of a folder that must have some.

    Raises:
        RunFolderError: no dumps.
    """
    files = dump_files(folder)
    if not files:
        raise RunFolderError(
            folder / "dump",
            "no dumps charge.<step>.liggghts",
            "run the case again: millscale run FILE --runs DIR --only ID",
        )
    return files


def read_dump(path: Path) -> Dump:
    """Return the balls of one dump file.

    Raises:
        RunFolderError: missing, cut short, not as it was made, no dump, or without the columns id,
            x, y, z, radius; of another step than its name's, an id that is no whole number or there
            twice, or a radius that is not above 0.
    """
    if not is_as_made(path.parent.parent, f"{path.parent.name}/{path.name}"):
        raise RunFolderError(path, "not the dump that stage rotate made", _REMEDY)
    text = read_text(path, MOST_DUMP, _REMEDY)
    head, marker, body = text.partition("ITEM: ATOMS ")
    lines = head.splitlines()
    names_line, _, body = body.partition("\n")
    try:
        step = int(lines[lines.index("ITEM: TIMESTEP") + 1])
        count = int(lines[lines.index("ITEM: NUMBER OF ATOMS") + 1])
    except (IndexError, ValueError):
        raise RunFolderError(path, "not a complete dump header", _REMEDY) from None
    if not marker:
        raise RunFolderError(path, "not a complete dump header", _REMEDY)
    names = names_line.split()
    missing = [name for name in ("id", "x", "y", "z", "radius") if name not in names]
    if missing:
        got = (marker + names_line).rstrip()
        raise RunFolderError(path, f"no column {', '.join(missing)}; got {got!r}", _REMEDY)
    if len(set(names)) < len(names):
        raise RunFolderError(path, "two columns have the same name", _REMEDY)
    values = _rows(path, body, count, len(names))
    if not np.isfinite(values).all():
        raise RunFolderError(path, "a number is not finite", _REMEDY)
    values = values[np.argsort(values[:, names.index("id")])]
    dump = Dump(step, {name: values[:, i] for i, name in enumerate(names)})
    _check(path, dump)
    return dump


def _check(path: Path, dump: Dump) -> None:
    named = _NAME.fullmatch(path.name)
    if named and int(named[1]) != dump.step:
        raise RunFolderError(path, f"holds step {dump.step}: another dump of this name", _REMEDY)
    ids, radii = dump["id"], dump["radius"]
    wrong = ids[(ids < 1.0) | (ids != np.floor(ids))]
    if wrong.size:
        raise RunFolderError(path, f"id {wrong[0]:g}, accepted: whole numbers from 1", _REMEDY)
    twice = ids[1:][np.diff(ids) == 0.0]
    if twice.size:
        raise RunFolderError(path, f"id {twice[0]:.0f} is there twice", _REMEDY)
    if not (radii > 0.0).all():
        smallest = int(np.argmin(radii))
        cause = f"radius {radii[smallest]:g} of id {ids[smallest]:.0f}, accepted: above 0"
        raise RunFolderError(path, cause, _REMEDY)


def _rows(path: Path, body: str, count: int, columns: int) -> np.ndarray:
    """Return the columns of the balls, (count, columns) float.

    All numbers are parsed in one call, in half the time of splitting the lines or less: the
    physical mill has 231,461 balls a dump, about a second.
    """
    found = body.count("\n") + (not body.endswith("\n") and bool(body))
    if found != count:
        raise RunFolderError(
            path, f"{found} balls, {count} announced: cut short, or two frames", _REMEDY
        )
    try:
        # Both ways in which numpy tells of a damaged text, by version.
        with warnings.catch_warnings():
            warnings.simplefilter("error", DeprecationWarning)
            values = np.fromstring(body, dtype=float, sep=" ")
    except (ValueError, DeprecationWarning) as error:
        raise RunFolderError(path, f"a line is cut short or damaged: {error}", _REMEDY) from None
    if values.size != count * columns:
        cause = f"a line is cut short: {values.size} numbers in {count} lines of {columns} columns"
        raise RunFolderError(path, cause, _REMEDY)
    return values.reshape(count, columns)
