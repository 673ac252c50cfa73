"""Campaigns and engine runs of the bench."""

from __future__ import annotations

import shlex
from pathlib import Path

from rich.console import Console

from millscale.engine.deck_run import engine_text
from millscale.engine.machine import CoreWish
from millscale.errors import CampaignError, EngineError
from millscale.workflow.run_command import request, run_campaign


def finish_campaign(campaign: Path, folder: Path, only: list[str], console: Console) -> None:
    """Run the cases of a campaign that are not finished.

    Raises:
        CampaignError: a case failed.
    """
    if not run_campaign(request(campaign, folder, only, CoreWish()), console):
        look = "see " + shlex.join(["millscale", "status", str(folder)])
        raise CampaignError("millscale bench", campaign.name, "a case failed", look)


def engine_output(line: list, folder: Path) -> str:
    """Run an engine and return what it printed.

    Raises:
        EngineError: the engine did not finish.
    """
    text, cause = engine_text(line, folder)
    if cause:
        raise EngineError(f"{line[0]} in {folder}: {cause}")
    return text
