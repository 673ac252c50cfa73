"""Mixing of the balls that started on the rising side with the others, by Lacey's index."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from millscale.analysis.shapes.shape import unit_length
from millscale.analysis.shapes.snapshots import mill_angle_at, starts_on_rising_side
from millscale.runs.case_file import Case
from millscale.runs.case_folder import SERIES
from millscale.runs.dumps import Dump, read_dump, required_dumps
from millscale.runs.series import read_series
from millscale.runs.untrusted import understood

# Of the sample cells of reports, over R - a: 30 balls a cell at the paper's S = 2.6.
SIDE = 0.1


@dataclass(frozen=True)
class Mixing:
    """Mixing index of a charge against revolutions of the mill.

    Attributes:
        side: of the sample cells, over R - a.
        revolutions: (n,) float, of the dumps.
        index: (n,) float, of `mixing_index`.
        balls_per_cell: of the cells that hold a ball, in the mean over the dumps.
    """

    side: float
    revolutions: np.ndarray
    index: np.ndarray
    balls_per_cell: float

    def mean(self, begin: float, end: float) -> float | None:
        """Return the mean index between two numbers of revolutions, by trapezoids; None beyond the
        dumps."""
        known = self.revolutions
        # 1e-6: the angle of the first dump is extrapolated.
        if not known[0] - 1e-6 <= begin < end <= known[-1]:
            return None
        inside = known[(known > begin) & (known < end)]
        at = np.concatenate([[begin], inside, [end]])
        index = np.interp(at, known, self.index)
        return float(np.sum(0.5 * (index[1:] + index[:-1]) * np.diff(at)) / (end - begin))

    def time_to(self, level: float) -> float | None:
        """Return the revolutions after which the index first reaches a level; None if it does
        not."""
        above = np.flatnonzero(self.index >= level)
        if not above.size:
            return None
        after = above[0]
        if after == 0:
            return float(self.revolutions[0])
        ends = slice(after - 1, after + 1)
        return float(np.interp(level, self.index[ends], self.revolutions[ends]))


def mixing_index(cells: np.ndarray, marked: np.ndarray) -> float:
    """Return Lacey's mixing index: 0 if every cell holds balls of one kind, 1 in the mean of all
    random arrangements.

    M = (s_0^2 - s^2) / (s_0^2 - s_r^2). The variance of the marked share x_c between cells of n_c
    balls is s^2 = sum n_c (x_c - p)^2 / N. It is s_0^2 = p (1 - p) without mixing, and in the mean
    of all permutations of N balls in K cells s_r^2 = s_0^2 (K - 1) / (N - 1). So M is the variance
    within cells over that of the charge, both free of bias, for any number of balls in a cell:
    M = [sum n_c x_c (1 - x_c) / (N - K)] / [N p (1 - p) / (N - 1)]. A cell of one ball has no
    variance and no weight.

    P. M. C. Lacey, J. Appl. Chem. 4 (1954) 257, doi 10.1002/jctb.5010040504; s_r^2 for cells of
    unequal n_c is derived here.

    Args:
        cells: (N,) int, the cell of each ball.
        marked: (N,) bool.

    Raises:
        ValueError: no two balls in one cell, or balls of one kind only.
    """
    _, cell, balls = np.unique(cells, return_inverse=True, return_counts=True)
    count, chosen = len(cells), int(np.count_nonzero(marked))
    if len(balls) == count or chosen in (0, count):
        raise ValueError(
            f"{count} balls in {len(balls)} cells, {chosen} of them marked: no mixing index"
        )
    of_cell = np.bincount(cell, marked)
    within = np.sum(of_cell * (balls - of_cell) / balls) / (count - len(balls))
    return float(within / (chosen * (count - chosen) / count / (count - 1)))


def cells_of(points: np.ndarray, side: float) -> np.ndarray:
    """Return the square cell of each point (n, 2), (n,) int; four cells meet in the origin."""
    column, row = np.floor(points / side).astype(int).T
    return row * (np.ptp(column) + 1) + column


def mixing(folder: Path, case: Case, sides: Sequence[float]) -> list[Mixing]:
    """Return the mixing of a case for sample cells of some sides over R - a.

    A cell is as long as the mill, so similar mills have similar cells.

    Raises:
        RunFolderError: no dumps, no series, or a dump without a mixing index.
    """
    files, revolutions = _revolutions(folder)
    index = np.empty((len(sides), len(files)))
    per_cell = np.empty_like(index)
    first = read_dump(files[0])
    for at_dump, path in enumerate(files):
        dump = read_dump(path)
        with understood(path, "compare it with the first dump"):
            for i, side in enumerate(sides):
                cells = _cells(dump, case, side)
                index[i, at_dump] = mixing_index(cells, starts_on_rising_side(dump, first))
                per_cell[i, at_dump] = len(dump) / len(np.unique(cells))
    return [
        Mixing(side, revolutions, index[i], float(per_cell[i].mean()))
        for i, side in enumerate(sides)
    ]


def index_after(folder: Path, case: Case, wanted: float = 1.0, side: float = SIDE) -> float | None:
    """Return the mixing index after some revolutions, interpolated between two dumps; None beyond
    the last dump, or where no cell holds two balls.

    Raises:
        RunFolderError: no dumps, no series, or a ball that is not in the first dump.
    """
    files, revolutions = _revolutions(folder)
    after = int(np.searchsorted(revolutions, wanted))
    if not 0 < after < len(files):
        return None
    first, found = read_dump(files[0]), []
    for path in files[after - 1 : after + 1]:
        dump = read_dump(path)
        with understood(path, "compare it with the first dump"):
            rising = starts_on_rising_side(dump, first)
        try:
            found.append(mixing_index(_cells(dump, case, side), rising))
        except ValueError:
            return None
    return float(np.interp(wanted, revolutions[after - 1 : after + 1], found))


def _revolutions(folder: Path) -> tuple[list[Path], np.ndarray]:
    """Return the dumps of a case and the revolutions of the mill at each, (n,) float."""
    files = required_dumps(folder)
    series = read_series(folder / SERIES, "multi-ball")
    angles = mill_angle_at(np.array(list(files), float), series)
    return list(files.values()), angles / (2.0 * math.pi)


def _cells(dump: Dump, case: Case, side: float) -> np.ndarray:
    return cells_of(dump.positions[:, [0, 2]] / unit_length(case), side)
