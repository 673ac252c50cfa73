"""What was measured, where, when and with which code."""

from __future__ import annotations

import datetime
import subprocess
import sys
from pathlib import Path

from mill_campaign.case import installed_version
from mill_campaign.machine import hardware


def provenance() -> dict:
    """Command, commit (None outside a repository), version, machine, date."""
    return {
        "command": " ".join(["millscale", *sys.argv[1:]]),
        "commit": _commit(),
        "version": installed_version(),
        "machine": hardware(),
        "date": datetime.date.today().isoformat(),
    }


def _commit() -> str | None:
    try:
        done = subprocess.run(
            ["git", "describe", "--always", "--dirty", "--abbrev=12"],
            cwd=Path(__file__).parent,
            capture_output=True,
            text=True,
            check=True,
        )
    except (OSError, subprocess.CalledProcessError):
        return None
    return done.stdout.strip()
