"""Campaigns and engine runs of the bench, each to its end or to an error that says why not."""

from __future__ import annotations

import subprocess
from pathlib import Path

from rich.console import Console

from mill_campaign.engine_log import error_line
from mill_campaign.engine_run import engine_environment
from mill_campaign.errors import CampaignError
from mill_campaign.machine import CoreWish
from mill_campaign.run_command import request, run_campaign


def finish_campaign(campaign: Path, folder: Path, only: list[str], console: Console) -> None:
    """Bring the cases of a campaign to their results; what is there already is not run again.

    Raises:
        CampaignError: a case failed.
    """
    if not run_campaign(request(campaign, folder, only, CoreWish()), console):
        raise CampaignError(
            "millscale bench", campaign.name, "a case failed", f"see millscale status {folder}"
        )


def engine_output(line: list, folder: Path) -> str:
    """What an engine printed.

    Raises:
        RuntimeError: it did not come to the end.
    """
    done = subprocess.run(
        line,
        cwd=folder,
        env=engine_environment(),
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        errors="replace",
    )
    text = done.stdout + done.stderr
    cause = error_line(text)
    if done.returncode or cause:
        raise RuntimeError(f"{line[0]} in {folder}: {cause or f'exit code {done.returncode}'}")
    return text
