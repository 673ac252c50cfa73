"""The multi-ball results of several campaigns as one file to commit."""

from __future__ import annotations

import datetime
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from millscale.analysis.charge.comparison import compare_charges
from millscale.analysis.charge.scaled_mills import Charge
from millscale.analysis.finished_campaign import load_campaign
from millscale.engine.code_version import described_commit
from millscale.runs.case_folder import RunFolderError


def load_charges(runs: Sequence[Path]) -> tuple[list[Charge], dict[str, str]]:
    """The finished multi-ball cases of some runs folders, and why others are not among them.

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
        charges += [Charge(campaign.name, case) for case in campaign.charges]
        missing |= {f"{campaign.name}/{case}": why for case, why in campaign.missing.items()}
    if not charges:
        raise RunFolderError(
            Path(runs[0]), "no finished multi-ball case", "millscale run FILE --runs DIR"
        )
    return charges, missing


def paper_results(runs: Sequence[Path]) -> dict[str, Any]:
    """Rows of `compare_charges` over all runs folders; a campaign without the physical mill is
    compared with that of another."""
    charges, missing = load_charges(runs)
    comparison = compare_charges(charges)
    return {"rows": comparison.rows, "schemes": comparison.schemes, "missing": missing}


def origin(runs: Sequence[Path], machine: str, commit: str) -> dict[str, Any]:
    """Where the numbers come from: command, commit, machine, date.

    Args:
        machine: a note on the machine, added to what the runs recorded.
        commit: of the code; empty for that of the code that runs.
    """
    charges, _ = load_charges(runs)
    hardware = [charge.timing["hardware"] for charge in charges]
    known = dict.fromkeys(f"{h['cpu']}, {h['available_cores']} cores" for h in hardware)
    files = {folder: load_campaign(folder).about.get("file") or "FILE" for folder in runs}
    ranks = sorted({charge.timing["ranks"] for charge in charges})
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
