"""The multi-ball results of several campaigns as one file to commit."""

from __future__ import annotations

import datetime
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from millscale.analysis.charge.comparison import ChargeComparison, compare_charges
from millscale.analysis.finished import Charge
from millscale.analysis.finished_campaign import load_campaign
from millscale.engine.code_version import described_commit
from millscale.runs.untrusted import RunFolderError


def load_charges(runs: Sequence[Path]) -> tuple[list[Charge], dict[str, str]]:
    """Return the finished multi-ball cases of some runs folders, and why others are not among them.

    Raises:
        RunFolderError: two campaigns of the same name, or no finished multi-ball case.
    """
    charges: list[Charge] = []
    missing: dict[str, str] = {}
    for folder in runs:
        campaign = load_campaign(folder)
        if campaign.name in {charge.campaign for charge in charges}:
            raise RunFolderError(
                folder,
                f"a second campaign named {campaign.name!r}",
                "give each its own name in [campaign]",
            )
        charges += campaign.charges
        missing |= {f"{campaign.name}/{case}": why for case, why in campaign.missing.items()}
    if not charges:
        raise RunFolderError(
            Path(runs[0]), "no finished multi-ball case", "millscale run FILE --runs DIR"
        )
    return charges, missing


def compare_campaigns(runs: Sequence[Path]) -> tuple[ChargeComparison, dict[str, Any]]:
    """Return the charges of all runs folders compared with one another, and the content of a file
    with the result. The charges of a campaign without the physical mill are compared with that of
    another."""
    charges, missing = load_charges(runs)
    comparison = compare_charges(charges)
    return comparison, {
        "rows": [row.document() for row in comparison.rows],
        "schemes": [row.document() for row in comparison.schemes],
        "missing": missing,
    }


def origin(runs: Sequence[Path], machine: str, commit: str) -> dict[str, Any]:
    """Return where the numbers come from: command, commit, machine, date.

    Args:
        machine: a note on the machine, added to what the runs recorded.
        commit: of the code; empty for that of the code that runs.
    """
    charges, _ = load_charges(runs)
    known = dict.fromkeys(str(charge.timing.hardware) for charge in charges)
    files = {folder: load_campaign(folder).about.get("file") or "FILE" for folder in runs}
    ranks = sorted({charge.timing.ranks for charge in charges})
    return {
        "command": [
            *(
                shlex.join(["millscale", "run", Path(file).name, "--runs", str(run)])
                for run, file in files.items()
            ),
            shlex.join(["millscale", "analyse", "campaigns", *map(str, runs)]),
        ],
        "commit": commit or described_commit() or "unknown",
        "machine": "; ".join([*known, *([machine] if machine else [])]),
        "ranks": ranks,
        "date": datetime.date.today().isoformat(),
    }
