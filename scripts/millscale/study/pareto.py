"""Time against error: the front, the setting to take for a wanted error, default against stock.

An error below its spread is not known to be smaller than the spread, so `StudyError.resolved`
counts it as the spread. Among settings that chance does not distinguish, time alone decides, and
none is on the front by luck.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from millscale.analysis.measures import STUDIED
from millscale.study.errors import StudyError

WORST = "worst"
WANTED = (0.01, 0.03, 0.10)


@dataclass(frozen=True)
class WorstError(StudyError):
    """The largest of the errors of a setting; `of` is its name."""

    of: str = ""


@dataclass(frozen=True)
class SettingRow:
    """One scaled mill of one setting of a parameter study.

    Attributes:
        label: the setting; with scheme and S if it has several mills.
        reference: label of what it is compared with.
        engine: stock where ball and wall contacts are the engine's own, else millscale.
        wall_time_s, processor_time_s: of a run with settling, mean over the seeds.
        time_is: processor or wall: which of the two `time_s` is.
        time_spread_s: its standard deviation over the seeds.
        errors: by name.
        worst: None of a reference, or if an error is missing.
        on_front_of: errors on whose front the row is.
    """

    setting: str
    label: str
    about: str
    is_reference: bool
    is_default: bool
    reference: str
    scheme: str
    policy: str
    S: float
    stiffness: str
    balls: int
    step_s: float
    engine: str
    contacts: str
    damping: str
    wall: str
    length_m: float
    rotation_angle_rad: float
    seeds: int
    ranks: int
    wall_time_s: float
    processor_time_s: float | None
    time_is: str
    time_s: float
    time_spread_s: float | None
    errors: Mapping[str, StudyError]
    worst: WorstError | None = None
    on_front_of: tuple[str, ...] = ()

    @property
    def on_front(self) -> bool:
        return WORST in self.on_front_of

    @property
    def role(self) -> str:
        return " (reference)" * self.is_reference + " (default)" * self.is_default

    def error(self, name: str) -> StudyError | None:
        """Return an error, or the worst."""
        return self.worst if name == WORST else self.errors[name]

    def resolved(self, name: str) -> float | None:
        """Return `StudyError.resolved` of an error, or of the worst."""
        error = self.error(name)
        return error and error.resolved

    def document(self) -> dict[str, Any]:
        """Return the row of speed-against-error.json."""
        return asdict(self) | {"on_front": self.on_front}


@dataclass(frozen=True)
class Recommendation:
    """The cheapest setting whose error plus spread (`bound`) does not exceed `wanted`.

    Attributes:
        error: name of the error, or WORST for all at once.
        setting: label; None if there is none, then `nearest` is the setting with the least bound.
    """

    wanted: float
    error: str
    setting: str | None
    time_s: float | None
    bound: float | None
    nearest: str | None
    nearest_bound: float | None


@dataclass(frozen=True)
class AgainstStock:
    """The default against the cheapest stock setting whose error is no larger.

    Attributes:
        stock: its label; None if no stock setting is as good.
        ratio: times that it takes longer; `ratio_spread` its standard deviation.
        at_least: without one, time of the best stock setting over that of the default.
    """

    error: str
    default: str
    default_time_s: float
    default_error: float
    stock: str | None
    stock_time_s: float | None
    stock_error: float | None
    ratio: float | None
    ratio_spread: float | None
    best_stock: str
    best_stock_error: float
    at_least: float | None


def known_errors(rows: Sequence[SettingRow]) -> list[str]:
    """Return the names of the errors that any row knows: a plain drum has no curtains."""
    return [name for name in STUDIED if any(row.errors[name].error is not None for row in rows)]


def worst_of(errors: Mapping[str, StudyError], known: Sequence[str]) -> WorstError | None:
    """Return the error whose resolved value is largest; None if one is missing."""
    values = {name: errors[name].resolved for name in known}
    if not values or None in values.values():
        return None
    name = max(values, key=values.__getitem__)
    return WorstError(**asdict(errors[name]), of=name)


def front(rows: Sequence[SettingRow], name: str) -> list[SettingRow]:
    """Return the rows that no other row beats in both time and resolved error, by time. Rows equal
    in both are on the front together. References and rows without the error are not on it."""
    points = [(row, row.time_s, row.resolved(name)) for row in rows if not row.is_reference]
    points = [point for point in points if point[2] is not None]
    best = [
        row
        for row, time, error in points
        if not any(t <= time and e <= error and (t, e) != (time, error) for _, t, e in points)
    ]
    return sorted(best, key=lambda row: row.time_s)


def recommendations(
    rows: Sequence[SettingRow], wanted: Sequence[float] = WANTED
) -> list[Recommendation]:
    """Return what to take for each wanted error, of each kind and of all at once (WORST)."""
    known = known_errors(rows)
    return [_recommended(rows, share, name, known) for share in wanted for name in (*known, WORST)]


def _recommended(
    rows: Sequence[SettingRow], share: float, name: str, known: Sequence[str]
) -> Recommendation:
    bounds = [(row, _bound(row, name, known)) for row in rows if not row.is_reference]
    bounds = [(row, bound) for row, bound in bounds if bound is not None]
    good = [(row, bound) for row, bound in bounds if bound <= share]
    best = min(good, key=lambda point: point[0].time_s, default=None)
    nearest = None if best else min(bounds, key=lambda point: point[1], default=None)
    return Recommendation(
        wanted=share,
        error=name,
        setting=best and best[0].label,
        time_s=best and best[0].time_s,
        bound=best and best[1],
        nearest=nearest and nearest[0].label,
        nearest_bound=nearest and nearest[1],
    )


def _bound(row: SettingRow, name: str, known: Sequence[str]) -> float | None:
    """Return the bound of an error; of the worst the largest of all that are known."""
    if name != WORST:
        return row.errors[name].bound
    bounds = [row.errors[kind].bound for kind in known]
    return None if not bounds or None in bounds else max(bounds)


def time_to_solution(rows: Sequence[SettingRow]) -> list[AgainstStock]:
    """Return each default row against the stock settings, in each error and in all at once.

    A stock setting is as good if its error does not exceed the resolved error of the default; for
    WORST no error may. What chance may have added to the error of a stock setting does not count.
    """
    known = known_errors(rows)
    stock = [row for row in rows if row.engine == "stock" and not row.is_reference]
    stock = [row for row in stock if row.worst is not None]
    result = []
    for row in (row for row in rows if row.is_default and row.worst is not None and stock):
        result += [_against_stock(row, [name], name, stock) for name in known]
        result.append(_against_stock(row, known, WORST, stock))
    return result


def _against_stock(
    default: SettingRow, kinds: Sequence[str], name: str, stock: Sequence[SettingRow]
) -> AgainstStock:
    """Return a default row against stock in some kinds of error, under one name."""
    own = {kind: default.errors[kind].resolved for kind in kinds}

    def excess(row: SettingRow) -> float:
        """Return the largest error over that of the default; 1 where both are 0."""
        errors = [(row.errors[kind].error, own[kind]) for kind in kinds]
        return max(e / o if o > 0.0 else (math.inf if e > 0.0 else 1.0) for e, o in errors)

    good = [row for row in stock if excess(row) <= 1.0]
    best = min(good, key=lambda row: row.time_s, default=None)
    nearest = min(stock, key=lambda row: (excess(row), row.time_s))
    return AgainstStock(
        error=name,
        default=default.label,
        default_time_s=default.time_s,
        default_error=max(own.values()),
        stock=best and best.label,
        stock_time_s=best and best.time_s,
        stock_error=best and _largest(best, kinds),
        ratio=best and best.time_s / default.time_s,
        ratio_spread=best and _ratio_spread(best, default),
        best_stock=nearest.label,
        best_stock_error=_largest(nearest, kinds),
        at_least=None if best else nearest.time_s / default.time_s,
    )


def _largest(row: SettingRow, kinds: Sequence[str]) -> float:
    return max(row.errors[kind].error for kind in kinds)


def _ratio_spread(one: SettingRow, other: SettingRow) -> float | None:
    """Return the standard deviation of a ratio of times, from those over the seeds."""
    if one.time_spread_s is None or other.time_spread_s is None:
        return None
    relative = math.hypot(*(row.time_spread_s / row.time_s for row in (one, other)))
    return one.time_s / other.time_s * relative
