"""What was measured, where, when and with which code."""

from __future__ import annotations

import datetime
import subprocess
import sys
from pathlib import Path

from millscale.engine.machine import hardware
from millscale.engine.provenance import installed_version


def provenance() -> dict:
    """Command (without --runs: where the mills are kept says nothing), commit (None outside a
    repository), version, machine, date."""
    words = sys.argv[1:]
    if "--runs" in words:
        place = words.index("--runs")
        words = words[:place] + words[place + 2 :]
    return {
        "command": " ".join(["millscale", *words]),
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
            encoding="utf-8",
            check=True,
        )
    except (OSError, subprocess.CalledProcessError):
        return None
    return done.stdout.strip()
