"""Dumps of a multi-ball case by mill angle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from millscale.runs.case_folder import SERIES
from millscale.runs.dumps import Dump, read_dump, required_dumps
from millscale.runs.series import Series, read_series


@dataclass(frozen=True)
class Snapshot:
    """A dump and its mill angle.

    Attributes:
        mill_angle: at the dump [rad].
    """

    path: Path
    mill_angle: float


def snapshots_near(folder: Path, mill_angles: Sequence[float]) -> list[Snapshot]:
    """Return the dump nearest to each mill angle [rad], each dump once, in order.

    Raises:
        RunFolderError: no dumps, or no series.
    """
    every = snapshots_of(folder)
    angles = np.array([snapshot.mill_angle for snapshot in every])
    nearest = sorted({int(np.argmin(np.abs(angles - angle))) for angle in mill_angles})
    return [every[i] for i in nearest]


def snapshots_of(folder: Path) -> list[Snapshot]:
    """Return every dump of a case folder, in order.

    The angle of a dump follows from its step and the series.

    Raises:
        RunFolderError: no dumps, or no series.
    """
    files = required_dumps(folder)
    series = read_series(folder / SERIES, "multi-ball")
    angles = mill_angle_at(np.array(list(files), float), series)
    return [Snapshot(path, float(x)) for path, x in zip(files.values(), angles, strict=True)]


def mill_angle_at(steps: np.ndarray, series: Series) -> np.ndarray:
    """Return the mill angle [rad] at steps of a multi-ball series, (n,) float.

    Between two rows the mill turns evenly; before the first row, where the first dump lies, and
    after the last it is extrapolated.
    """
    step, angle = series["step"], series["mill_angle_rad"]
    row = np.clip(np.searchsorted(step, steps) - 1, 0, len(step) - 2)
    slope = (angle[row + 1] - angle[row]) / (step[row + 1] - step[row])
    return np.maximum(0.0, angle[row] + slope * (steps - step[row]))


def starts_on_rising_side(dump: Dump, first: Dump) -> np.ndarray:
    """Return whether the balls of `dump` were at x < 0 in the first dump, (n,) bool.

    Raises:
        ValueError: a ball is not in the first dump.
    """
    row = np.searchsorted(first["id"], dump["id"])
    known = row < len(first)
    known[known] = first["id"][row[known]] == dump["id"][known]
    if not known.all():
        strange = dump["id"][~known][0]
        raise ValueError(f"ball {strange:.0f} of step {dump.step} is not in step {first.step}")
    return first["x"][row] < 0.0


def class_of_each(dump: Dump, classes: int) -> np.ndarray:
    """Return the class of each ball from 0 on, in the order of case.json, (n,) int.

    Raises:
        ValueError: a ball is of none of so many classes.
    """
    kinds = dump.columns.get("type", np.zeros(len(dump))).astype(int) - 1
    if not ((kinds >= 0) & (kinds < classes)).all():
        raise ValueError(f"a ball of step {dump.step} is of none of the {classes} classes")
    return kinds


def first_dump(folder: Path) -> Dump:
    """Return the dump before the rotation, whose positions give the balls their colours."""
    return read_dump(next(iter(required_dumps(folder).values())))
