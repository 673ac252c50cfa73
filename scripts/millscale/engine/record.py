"""Provenance of a measurement: command, code, machine, date."""

from __future__ import annotations

import datetime
import sys

from millscale.engine.code_version import described_commit, installed_version
from millscale.engine.machine import hardware


def provenance() -> dict:
    """Return command, commit (None if unknown), version, machine and date.

    The command is that of this process, without the runs folder.
    """
    words = sys.argv[1:]
    if "--runs" in words:
        place = words.index("--runs")
        words = words[:place] + words[place + 2 :]
    return {
        "command": " ".join(["millscale", *words]),
        "commit": described_commit(),
        "version": installed_version(),
        "machine": hardware(),
        "date": datetime.date.today().isoformat(),
    }
