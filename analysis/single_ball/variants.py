"""One model in several campaigns, such as other lifter readings or start phases, side by side."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from millscale.analysis.finished_campaign import load_campaign

COLUMNS = (
    ("campaign", "campaign", "{}"),
    ("scheme", "scheme", "{}"),
    ("S", "S", "{:.3f}"),
    ("face_angle_deg", "face angle [deg]", "{:.2f}"),
    ("phase_deg", "phase [deg]", "{:.2f}"),
    ("liner_off_angle_deg", "liner left [deg]", "{:.2f}"),
    ("detach_angle_deg", "free flight [deg]", "{:.2f}"),
    ("from_throw_energy_change_J", "change from the throw [J]", "{:.3f}"),
    ("paper_angles_energy_change_J", "change at the paper's angles [J]", "{:.3f}"),
)


def variant_rows(runs: Sequence[Path], S: float, policy: str) -> list[dict[str, Any]]:
    """A row for each campaign and scheme: angles and energy changes of the model of S.

    Args:
        runs: runs folders.
        policy: the policy to look at.
    """
    rows = []
    for folder in runs:
        campaign = load_campaign(folder)
        for case, row in zip(campaign.single, campaign.rows, strict=True):
            if abs(case.case["S"] - S) < 1e-3 and case.case["policy"] == policy:
                mill = case.case["mill"]
                rows.append(
                    {
                        **row,
                        "campaign": campaign.name,
                        "face_angle_deg": mill["face_angle_deg"],
                        "phase_deg": math.degrees(mill["phase_rad"]),
                    }
                )
    return rows


def markdown(rows: Sequence[dict[str, Any]]) -> str:
    """The rows as a Markdown table; a star: not in flight at both of the paper's angles."""
    lines = [
        "| " + " | ".join(title for _, title, _ in COLUMNS) + " |",
        "|---" * len(COLUMNS) + "|",
    ]
    for row in rows:
        cells = ["–" if row[key] is None else form.format(row[key]) for key, _, form in COLUMNS]
        if row["paper_angles_in_flight"] is False:
            cells[-1] += "*"
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)
