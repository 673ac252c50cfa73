"""Speed against error: one row for each scaled mill, over its seeds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from millscale.analysis.charge.rows import ChargeRow
from millscale.analysis.charge.scaled_mills import MillName
from millscale.analysis.means import deviation, mean_known
from millscale.analysis.measures import ERRORS, Column, ErrorColumn
from millscale.formats import NONE

# Errors that tables and figures of speed against error show.
SHOWN = tuple(error for error in ERRORS if error.in_tables)
TIMES = (
    Column("wall_time_s", "wall time", "s", digits=0),
    Column("processor_time_s", "processor time", "s", digits=0),
    Column("speed_up", "speed-up", digits=1),
)


@dataclass(frozen=True)
class OverSeeds:
    """An error of a scaled mill: mean and standard deviation over its seeds, and the same error
    between two seeds."""

    mean: float | None
    deviation: float | None
    between_seeds: float | None

    def text(self, error: ErrorColumn) -> str:
        """Return mean ± deviation."""
        if self.mean is None or self.deviation is None:
            return error.text(self.mean)
        return f"{error.text(self.mean)} ± {error.text(self.deviation, signed=False)}"

    def between_text(self, error: ErrorColumn) -> str:
        """Return the error between two seeds; empty if it is not known."""
        return "" if self.between_seeds is None else error.text(self.between_seeds, signed=False)


@dataclass(frozen=True)
class MillRow:
    """Speed and errors of a scaled mill, means over its seeds.

    Errors of contours and curtains are those of the steady part of the rotation, not of one moment.

    Attributes:
        reference: id of the charge that it is compared with.
        errors: by the name of the error; of a reference without means.
    """

    name: MillName
    reference: str
    is_reference: bool
    seeds: int
    balls: int
    ranks: int
    wall_time_s: float
    processor_time_s: float | None
    speed_up: float | None
    errors: dict[str, OverSeeds]

    @property
    def time_s(self) -> float:
        """Return the processor time, which a shared machine lengthens less, or the wall time."""
        return self.processor_time_s or self.wall_time_s


def mill_rows(rows: Sequence[ChargeRow]) -> list[MillRow]:
    """Return a row for each scaled mill.

    Args:
        rows: of `comparison.compare_charges`.
    """
    groups: dict[MillName, list[ChargeRow]] = {}
    for row in rows:
        groups.setdefault(row.mill.name, []).append(row)
    return [_mill_row(name, group) for name, group in groups.items()]


def _mill_row(name: MillName, seeds: Sequence[ChargeRow]) -> MillRow:
    first = seeds[0]
    return MillRow(
        name=name,
        reference=first.reference.id,
        is_reference=any(row.is_reference for row in seeds),
        seeds=len(seeds),
        balls=first.charge.balls,
        ranks=first.charge.timing.ranks,
        wall_time_s=mean_known(row.charge.timing.wall_time_s for row in seeds),
        processor_time_s=mean_known(row.charge.timing.processor_time_s for row in seeds),
        speed_up=mean_known(row.speed_up for row in seeds),
        errors={error.name: _over_seeds(error.name, seeds) for error in SHOWN},
    )


def _over_seeds(name: str, seeds: Sequence[ChargeRow]) -> OverSeeds:
    values = [row.errors.steady(name) for row in seeds]
    between = seeds[0].between_seeds
    return OverSeeds(mean_known(values), deviation(values), between and between.steady(name))


def markdown(mills: Sequence[MillRow]) -> str:
    """Return scaled mills as a Markdown table: mean over seeds, ± their standard deviation, and in
    brackets the same error between two seeds."""
    titles = ["campaign", "scheme", "policy", "E", "S", "balls", "seeds"]
    titles += [column.heading for column in (*TIMES, *SHOWN)]
    lines = [f"| {' | '.join(titles)} |", "|---" * len(titles) + "|"]
    lines += [f"| {' | '.join(_cells(mill))} |" for mill in mills]
    return "\n".join(lines)


def _cells(mill: MillRow) -> list[str]:
    name = mill.name
    cells = [*name[:4], f"{name.S:.3f}", f"{mill.balls:,}"]
    cells += [str(mill.seeds), *(column.text(getattr(mill, column.name)) for column in TIMES)]
    for error in SHOWN:
        found = mill.errors[error.name]
        between = found.between_text(error)
        shown = found.text(error)
        cells.append(f"{shown} ({between})" if between and shown != NONE else shown)
    return cells
