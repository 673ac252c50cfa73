"""The plan of a campaign, and its file from a dictionary."""

from __future__ import annotations

import io
from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any

import pandas as pd
from rich.console import Console

from millscale.api.frames import frame
from millscale.campaign.build import campaign_of, load_campaign
from millscale.campaign.campaign import Campaign
from millscale.formats import counted, duration
from millscale.prediction.text import html_table
from millscale.workflow.plan import plan_rows
from millscale.workflow.plan_display import COLUMNS, render_plan

# A campaign file, or its content: sections by name, each with its keys.
CampaignSource = str | PathLike[str] | Mapping[str, Mapping[str, Any]]
# Stands in messages for the file that a dictionary has not.
DICTIONARY = Path("campaign")
_WIDEST = 100_000
_NESTED = ("groups", "model", "power_models", "warnings")


class Plan:
    """The cases of a campaign and their cost, before anything is run.

    Attributes:
        campaign: what the file says, checked, in SI units.
        rows: of each case, as `millscale plan --json` prints them.
    """

    def __init__(self, campaign: Campaign) -> None:
        self.campaign, self.rows = campaign, plan_rows(campaign)

    @property
    def cases(self) -> pd.DataFrame:
        """A row for each case, with the keys of `millscale plan --json`; units in `attrs`."""
        rows = ({key: x for key, x in row.items() if key not in _NESTED} for row in self.rows)
        units = {"output_bytes": "bytes", "predicted_memory_mb": "MB"}
        return frame(rows, "id", units)

    @property
    def power_models(self) -> pd.DataFrame:
        """Power of the physical mill by published models, and the limits it lies outside of."""
        charged = [row for row in self.rows if row["power_models"]]
        largest = min(charged, key=lambda row: row["S"])["power_models"] if charged else ()
        return frame(largest, "name" if charged else None, {"power_w": "W"})

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings of all cases, each once."""
        return tuple(dict.fromkeys(text for row in self.rows for text in row["warnings"]))

    @property
    def wall_time_s(self) -> float:
        """Predicted time of all cases one after the other [s]."""
        return sum(row["predicted_wall_time_s"] for row in self.rows)

    def __repr__(self) -> str:
        return f"<{self._title()}>"

    def __str__(self) -> str:
        """Return what `millscale plan` prints."""
        made = render_plan(self.campaign, self.rows)
        console = Console(file=io.StringIO(), width=_WIDEST, color_system=None)
        console.width = console.measure(made).maximum
        with console.capture() as text:
            console.print(made)
        return text.get().rstrip("\n")

    def _repr_html_(self) -> str:
        rows = [[text(row) for _, text in COLUMNS] for row in self.rows]
        notes = [f"warning: {text}" for text in self.warnings]
        return html_table(self._title(), [heading for heading, _ in COLUMNS], rows, notes)

    def _title(self) -> str:
        cases = counted(len(self.rows), "case")
        return (
            f"plan of {self.campaign.name}: {cases}, {duration(self.wall_time_s)} "
            "one after the other"
        )


def plan(campaign: CampaignSource) -> Plan:
    """Return the plan of a campaign; writes no file.

    Args:
        campaign: a campaign file, or its content as a dictionary of sections
            (docs/reference/campaign-file.md).

    >>> import millscale as ms
    >>> mill = {"radius_m": 0.9, "length_m": 0.5, "percent_of_critical": 70}
    >>> ball = {"radius_m": 0.025, "density_kg_m3": 7800}
    >>> steel = {"youngs_modulus_pa": 1e8, "poisson_ratio": 0.3}
    >>> steel |= {f"restitution_{x}": 0.5 for x in ("pp", "pw")}
    >>> steel |= {f"static_friction_{x}": 0.4 for x in ("pp", "pw")}
    >>> steel |= {f"rolling_friction_{x}": 0.01 for x in ("pp", "pw")}
    >>> charge = {"S": [1.0, 2.0], "filling": 0.3, "rotation_angle_rad": 10.0}
    >>> content = {"mill": mill, "ball": ball, "material": steel, "multi_ball": charge}
    >>> ms.plan(content).cases["balls"].tolist()
    [3499, 437, 3499, 437]

    Raises:
        CampaignError: the campaign is not accepted; the message names the key.
    """
    if isinstance(campaign, Mapping):
        return Plan(campaign_of(DICTIONARY, campaign))
    return Plan(load_campaign(Path(campaign)))
