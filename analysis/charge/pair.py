"""Two multi-ball cases against each other, such as one case on 1 and on 2 ranks."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from millscale.analysis.charge.measured import Measured, measure
from millscale.analysis.finished import Charge
from millscale.runs.case_folder import CASE, load_finished
from millscale.runs.untrusted import RunFolderError


def compare_two(first: Charge, second: Charge) -> dict[str, Any]:
    """Return what the two charges are, and the errors of the first against the second.

    Keys: docs/reference/files.md.

    Raises:
        RunFolderError: no dumps, or a damaged one.
    """
    measured = measure([first, second], [(first, second)])
    check_whole(measured)
    about = [
        {"id": charge.id, "S": charge.S, "seed": charge.seed, "ranks": charge.timing.ranks}
        | {"dimensionless": charge.result.dimensionless}
        for charge in (first, second)
    ]
    return {"cases": about, **measured.errors[first, second].document()}


def check_whole(measured: Measured) -> None:
    """Refuse charges of which a dump is missing or damaged.

    Raises:
        RunFolderError: names the first such dump.
    """
    for problems in measured.problems.values():
        if problems:
            raise problems[0]


def load_charge(folder: Path) -> Charge:
    """Return a finished multi-ball case.

    Raises:
        RunFolderError: not finished, or not a multi-ball case.
    """
    case = load_finished(folder)
    if case.case.kind != "multi-ball":
        raise RunFolderError(folder / CASE, "not a multi-ball case", "give multi-ball cases")
    return Charge(case, "")
