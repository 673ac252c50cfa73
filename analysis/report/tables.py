"""Rows of the tables of a report that set scaled mills beside the numbers of the paper."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

from markupsafe import Markup

from millscale.analysis.finished_campaign import Campaign
from millscale.analysis.paper import numbers as paper
from millscale.analysis.single_ball.comparison import (
    Regression,
    SingleBallRow,
    by_policy,
)
from millscale.formats import NONE
from millscale.runs.case_file import Mill, Statement

PaperRow = Mapping[str, float | str]

_ROW = re.compile(r"(<tr\b[^>]*>)(.*?)(</tr>)", re.DOTALL)
_CELL = re.compile(r"<(t[hd])\b[^>]*>.*?</\1>", re.DOTALL)
_TAG = re.compile(r"<[^>]*>")
_BLANK = frozenset(f"{NONE} /±()")


def full_columns(table: str) -> Markup:
    """Return an HTML table without the columns that hold no number or word.

    Rows with another number of cells than the first, such as notes across the table, stay.
    """
    rows = [_cells(row[2]) for row in _ROW.finditer(table)]
    width = len(rows[0])
    body = [cells for cells in rows[1:] if len(cells) == width]
    kept = [i for i in range(width) if not body or any(_holds_text(row[i]) for row in body)]

    def with_kept(row: re.Match[str]) -> str:
        cells = _cells(row[2])
        if len(cells) != width:
            return row[0]
        return row[1] + "".join(cells[i] for i in kept) + row[3]

    return Markup(_ROW.sub(with_kept, table))


def _cells(row: str) -> list[str]:
    return [cell[0] for cell in _CELL.finditer(row)]


def _holds_text(cell: str) -> bool:
    return not _BLANK.issuperset(_TAG.sub("", cell).strip())


@dataclass(frozen=True)
class MillLine:
    """A scaled mill, beside the rows of Tables 4, 6 and 7 that belong to it."""

    scheme: str
    policy: str
    S: float
    mill: Mill
    liner: PaperRow | None
    operation: PaperRow | None


@dataclass(frozen=True)
class AngleTable:
    """Detach angles of one scheme and policy; a row for each S."""

    fit: Regression
    rows: list[SingleBallRow]
    reported: paper.ReportedThrow | None


@dataclass(frozen=True)
class EnergyLine:
    """One S of a scheme: a row for each policy, None where a policy lacks it."""

    S: float
    predicted: float
    reported: paper.ReportedEnergy | None
    rows: list[SingleBallRow | None]


@dataclass(frozen=True)
class EnergyTable:
    """Energy ratios of a scheme, as in Tables 8 and 9.

    Attributes:
        reported_worst: worst deviation of the paper's ratios from their prediction.
    """

    scheme: str
    policies: list[str]
    lines: list[EnergyLine]
    fits: list[Regression]
    reported: paper.ReportedThrow | None
    reported_worst: float | None

    @property
    def has_ratios(self) -> bool:
        """Return whether a case at S = 1 makes ratios."""
        return any(row and row.reference for line in self.lines for row in line.rows)


def hardware(campaign: Campaign) -> list[str]:
    """Return the machines that the cases ran on, each once."""
    return list(dict.fromkeys(str(case.timing.hardware) for case in campaign.cases))


def mill_lines(campaign: Campaign) -> list[MillLine]:
    """Return the mills of each scheme and policy."""
    operation = {
        "constant-gravity": paper.table("table6_constant_gravity"),
        "constant-speed": paper.table("table7_constant_speed"),
    }
    liners = paper.table("table4_geometry")
    if not campaign.of_paper:
        operation, liners = {}, ()
    seen = {}
    for case in sorted(campaign.cases, key=lambda case: case.place):
        seen.setdefault(
            (case.scheme, case.variant, case.S),
            MillLine(
                case.scheme,
                case.variant,
                case.S,
                case.case.mill,
                paper.scheme_row(liners, case.S),
                paper.scheme_row(operation.get(case.scheme, ()), case.S),
            ),
        )
    return list(seen.values())


def angle_tables(campaign: Campaign) -> list[AngleTable]:
    """Return the detach angles by scheme and policy."""
    rows = by_policy(campaign.rows)
    return [
        AngleTable(
            fit,
            rows[fit.scheme, fit.policy],
            paper.reported_throw(fit.scheme) if campaign.of_paper else None,
        )
        for fit in campaign.fits
    ]


def energy_tables(campaign: Campaign) -> list[EnergyTable]:
    """Return the energy ratios of each scheme."""
    return [
        _energy_table(campaign, scheme)
        for scheme in dict.fromkeys(row.scheme for row in campaign.rows)
    ]


def _energy_table(campaign: Campaign, scheme: str) -> EnergyTable:
    columns = {
        policy: {row.S: row for row in rows}
        for (of, policy), rows in by_policy(campaign.rows).items()
        if of == scheme
    }
    reported = paper.reported_energies(scheme)
    return EnergyTable(
        scheme=scheme,
        policies=list(columns),
        lines=[
            _energy_line(campaign, scheme, S, [column.get(S) for column in columns.values()])
            for S in sorted(set().union(*columns.values()))
        ],
        fits=[fit for fit in campaign.fits if fit.scheme == scheme],
        reported=paper.reported_throw(scheme) if campaign.of_paper else None,
        reported_worst=max(
            (row.ratio / row.predicted - 1.0 for row in reported), key=abs, default=None
        ),
    )


def _energy_line(
    campaign: Campaign, scheme: str, S: float, rows: list[SingleBallRow | None]
) -> EnergyLine:
    predicted = next(row.predicted_ratio for row in rows if row)
    reported = paper.reported_energy(scheme, S) if campaign.of_paper else None
    return EnergyLine(S, predicted, reported, rows)


def statements(campaign: Campaign) -> dict[str, list[Statement]]:
    """Return what the cases model and what they leave out, each statement once."""
    sides = {"inside": {}, "outside": {}}
    for case in campaign.cases:
        for side, known in sides.items():
            for entry in getattr(case.case.model, side):
                known.setdefault((entry.what, entry.reason), entry)
    return {side: list(known.values()) for side, known in sides.items()}
