"""Reading of LIGGGHTS custom dumps, dump/charge.<step>.liggghts of a multi-ball case."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mill_analysis.run_folder import RunFolderError

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
    """The dumps of a case folder by step, in order of step."""
    by_step = {}
    for path in (folder / "dump").glob("charge.*.liggghts"):
        step = path.name.split(".")[1]
        if step.isdigit():
            by_step[int(step)] = path
    return dict(sorted(by_step.items()))


def read_dump(path: Path) -> Dump:
    """One dump file.

    Raises:
        RunFolderError: missing, cut short, no dump, or without the columns id, x, y, z, radius.
    """
    try:
        lines = path.read_text().splitlines()
    except FileNotFoundError:
        raise RunFolderError(path, "no such file", _REMEDY) from None
    sections: dict[str, int] = {}
    for number, line in enumerate(lines[:40]):
        if line.startswith("ITEM:"):
            sections.setdefault(line, number)
    try:
        step = int(lines[sections["ITEM: TIMESTEP"] + 1])
        count = int(lines[sections["ITEM: NUMBER OF ATOMS"] + 1])
        header, start = next((k, n) for k, n in sections.items() if k.startswith("ITEM: ATOMS"))
    except (KeyError, IndexError, ValueError, StopIteration):
        raise RunFolderError(path, "not a complete dump header", _REMEDY) from None
    names = header.split()[2:]
    missing = [name for name in ("id", "x", "y", "z", "radius") if name not in names]
    if missing:
        raise RunFolderError(path, f"no column {', '.join(missing)}; got {header!r}", _REMEDY)
    values = _rows(path, lines[start + 1 :], count, len(names))
    values = values[np.argsort(values[:, names.index("id")])]
    return Dump(step, {name: values[:, i] for i, name in enumerate(names)})


def _rows(path: Path, lines: list[str], count: int, columns: int) -> np.ndarray:
    """(count, columns) float."""
    if len(lines) != count:
        raise RunFolderError(
            path, f"{len(lines)} balls, {count} announced: cut short, or two frames", _REMEDY
        )
    try:
        values = np.array([line.split() for line in lines], dtype=float).reshape(count, columns)
    except ValueError as error:
        raise RunFolderError(path, f"a line is cut short or damaged: {error}", _REMEDY) from None
    return values
