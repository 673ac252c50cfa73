"""Comparison with an earlier result of `millscale bench`: whether a step takes longer now.

Compared are ratios to stock LIGGGHTS of the same rounds, in which the pace of the machine cancels.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import msgspec
import numpy as np
from scipy.special import stdtrit

from millscale.bench.engines import MILLSCALE, MIXED
from millscale.bench.machine_kind import machine_kind
from millscale.engine.machine import hardware
from millscale.formats import counted
from millscale.runs.typed import read_typed
from millscale.runs.untrusted import RunFolderError

REMEDY = "made by: millscale bench --json > FILE"
PRECISIONS = {MILLSCALE.pair: "double", MIXED.pair: "mixed"}
FEWEST_ROUNDS = 3
LEVEL = 0.95  # of the interval
Time = Annotated[float, msgspec.Meta(gt=0.0)]
Verdict = Literal["faster", "slower", "no difference"]


@dataclass(frozen=True)
class Row:
    """Times of one engine [ns per ball, step and core], one for each round."""

    scene: str
    engine: str
    pair: str
    balls: int
    ranks: int
    repeats: tuple[Time, ...]


@dataclass(frozen=True)
class Machine:
    """The machine of a result."""

    cpu: str


@dataclass(frozen=True)
class Provenance:
    """Where a result was measured, and with which code."""

    machine: Machine
    date: str
    commit: str | None = None


@dataclass(frozen=True)
class Result:
    """What is read of a result of `millscale bench`."""

    machine_kind: str
    rows: tuple[Row, ...]
    provenance: Provenance


@dataclass(frozen=True)
class Change:
    """Speed of one scene and precision now, against that of an earlier result.

    Attributes:
        now, before: times stock, medians of the rounds.
        range_now, range_before: least and most of the rounds.
        change: speed now over speed before, less 1; the geometric means of the rounds.
        low, high: its interval.
    """

    scene: str
    precision: str
    balls: int
    ranks: int
    now: float
    range_now: tuple[float, float]
    before: float
    range_before: tuple[float, float]
    change: float
    low: float
    high: float

    @property
    def verdict(self) -> Verdict:
        if self.low > 0.0:
            return "faster"
        return "slower" if self.high < 0.0 else "no difference"

    def __str__(self) -> str:
        return (
            f"{self.scene} {self.precision} {self.verdict}, {100.0 * self.change:+.1f} % "
            f"({100.0 * self.low:+.1f} to {100.0 * self.high:+.1f}), "
            f"{self.now:.2f} x stock, before {self.before:.2f}"
        )


def read_earlier(file: Path, scene: str) -> Result:
    """Return an earlier result of a scene.

    Raises:
        RunFolderError: damaged, of another scene or kind of machine, or of too few rounds.
    """
    found = read_typed(file, Result, REMEDY)
    here = machine_kind()
    if found.machine_kind != here:
        cause = f"measured with {found.machine_kind}, this machine has {here}"
        raise RunFolderError(file, cause, "compare with a result of the same kind of machine")
    scenes = sorted({row.scene for row in found.rows})
    if scene not in scenes:
        cause = f"is of scene {', '.join(scenes) or '(no rows)'}, not of {scene}"
        raise RunFolderError(file, cause, "choose the scene with --scene")
    for row in found.rows:
        if len(row.repeats) < FEWEST_ROUNDS:
            cause = f"{row.engine} {row.pair} has {counted(len(row.repeats), 'round')}"
            raise RunFolderError(file, cause, f"at least {FEWEST_ROUNDS} are needed")
        if len(row.repeats) != len(_stock(row, found.rows, file).repeats):
            raise RunFolderError(file, f"{row.engine} and stock have unequal rounds", REMEDY)
    return found


def changes(rows: Sequence[dict[str, Any]], earlier: Result, file: Path) -> list[Change]:
    """Return the change of each row of our engine.

    Args:
        rows: of `rounds.rows`, now.
        file: of the earlier result, for errors.

    Raises:
        RunFolderError: the earlier result has no such row.
    """
    now = [msgspec.convert(row, Row) for row in rows]
    return [
        _change(row, _stock(row, now, file), *_same(row, earlier, file))
        for row in now
        if row.engine == MILLSCALE.engine
    ]


def compared(rows: Sequence[dict[str, Any]], earlier: Result, file: Path) -> dict[str, Any]:
    """Return the comparison for the JSON of a bench."""
    found = changes(rows, earlier, file)
    return {
        "with": {
            "file": file.name,
            "commit": earlier.provenance.commit,
            "date": earlier.provenance.date,
            "cpu": earlier.provenance.machine.cpu,
        },
        "level": LEVEL,
        "changes": [msgspec.to_builtins(x) | {"verdict": x.verdict} for x in found],
        "summary": summary(found, earlier),
    }


def summary(found: Sequence[Change], earlier: Result) -> str:
    """Return the comparison in one line."""
    source = earlier.provenance
    line = f"bench against {source.commit or 'unknown commit'} of {source.date}: "
    line += "; ".join(map(str, found))
    if source.machine.cpu != hardware()["cpu"]:
        line += f"; measured on another processor, {source.machine.cpu}"
    return line


def _same(row: Row, earlier: Result, file: Path) -> tuple[Row, Row]:
    """Return the earlier row of the same mill and precision, and that of stock."""
    for other in earlier.rows:
        if _case(other) == _case(row) and (other.engine, other.pair) == (row.engine, row.pair):
            return other, _stock(other, earlier.rows, file)
    wanted = f"{row.pair}, {counted(row.balls, 'ball')}, {counted(row.ranks, 'rank')}"
    raise RunFolderError(file, f"has no row of {row.scene}, {wanted}", REMEDY)


def _case(row: Row) -> tuple[str, int, int]:
    return row.scene, row.balls, row.ranks


def _stock(row: Row, rows: Sequence[Row], file: Path) -> Row:
    for other in rows:
        if other.engine == "liggghts" and _case(other) == _case(row):
            return other
    raise RunFolderError(file, f"has no row of stock LIGGGHTS for scene {row.scene}", REMEDY)


def _change(row: Row, stock: Row, before: Row, stock_before: Row) -> Change:
    now, then = _ratios(row, stock), _ratios(before, stock_before)
    change, half = _difference(np.log(now), np.log(then))
    return Change(
        scene=row.scene,
        precision=PRECISIONS[row.pair],
        balls=row.balls,
        ranks=row.ranks,
        now=float(np.median(now)),
        range_now=(float(now.min()), float(now.max())),
        before=float(np.median(then)),
        range_before=(float(then.min()), float(then.max())),
        change=math.expm1(change),
        low=math.expm1(change - half),
        high=math.expm1(change + half),
    )


def _ratios(row: Row, stock: Row) -> np.ndarray:
    return np.array(stock.repeats) / np.array(row.repeats)


def _difference(now: np.ndarray, then: np.ndarray) -> tuple[float, float]:
    """Return the difference of two means and half the width of its interval: Welch, Biometrika 34
    (1947) 28-35, with the degrees of freedom of Satterthwaite."""
    parts = [values.var(ddof=1) / values.size for values in (now, then)]
    variance = sum(parts)
    difference = float(now.mean() - then.mean())
    if variance == 0.0:
        return difference, 0.0
    freedom = variance**2 / sum(
        part**2 / (values.size - 1) for part, values in zip(parts, (now, then), strict=True)
    )
    return difference, float(stdtrit(freedom, 0.5 + 0.5 * LEVEL) * math.sqrt(variance))
