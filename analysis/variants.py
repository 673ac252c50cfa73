"""One single ball in several campaigns, such as other start phases, side by side."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from millscale.analysis.finished_campaign import load_campaign
from millscale.analysis.measures import (
    FROM_THROW,
    PAPER_ANGLES,
    SINGLE_BALL_ANGLES,
    Column,
)
from millscale.analysis.single_ball.comparison import SingleBallRow

SAME_S = 1e-3
GEOMETRY = (
    Column("face_angle_deg", "face angle", "deg", digits=2),
    Column("phase_deg", "phase", "deg", digits=2),
)
CHANGES = tuple(
    (window, Column("change_J", f"change, {window.label}", "J"))
    for window in (FROM_THROW, PAPER_ANGLES)
)


@dataclass(frozen=True)
class VariantRow:
    """A single-ball case of a campaign, and what its liner differs in."""

    campaign: str
    row: SingleBallRow

    @property
    def face_angle_deg(self) -> float:
        return self.row.ball.case.mill.face_angle_deg

    @property
    def phase_deg(self) -> float:
        return math.degrees(self.row.ball.case.mill.phase_rad)


def variant_rows(runs: Sequence[Path], S: float, policy: str) -> list[VariantRow]:
    """Return a row for each campaign and scheme, of the scaled mill of one S and policy.

    Args:
        runs: runs folders.
    """
    campaigns = [load_campaign(folder) for folder in runs]
    return [
        VariantRow(campaign.name, row)
        for campaign in campaigns
        for row in campaign.rows
        if abs(row.S - S) < SAME_S and row.policy == policy
    ]


def markdown(rows: Sequence[VariantRow]) -> str:
    """Return the rows as a Markdown table; a star: the ball does not fly at both of the paper's
    mill angles."""
    columns = [*GEOMETRY, *SINGLE_BALL_ANGLES, *(column for _, column in CHANGES)]
    titles = ["campaign", "scheme", "S", *(column.heading for column in columns)]
    lines = [f"| {' | '.join(titles)} |", "|---" * len(titles) + "|"]
    return "\n".join([*lines, *(f"| {' | '.join(_cells(row))} |" for row in rows)])


def _cells(variant: VariantRow) -> list[str]:
    row = variant.row
    cells = [variant.campaign, row.scheme, f"{row.S:.3f}"]
    cells += [column.text(getattr(variant, column.name)) for column in GEOMETRY]
    cells += [column.text(row.angle(column.name)) for column in SINGLE_BALL_ANGLES]
    cells += [column.text(row.energies[window].change_J) for window, column in CHANGES]
    star = "*" if row.in_flight_at_paper_angles is False else ""
    return [*cells[:-1], cells[-1] + star]
