"""Two multi-ball cases against each other, such as one on 1 and on 2 ranks."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from millscale.analysis.charge.errors import shape_errors
from millscale.analysis.charge.rows import all_errors
from millscale.analysis.charge.scaled_mills import Charge
from millscale.analysis.shapes.shape import shape_of, snapshots_at, wanted_angles
from millscale.runs.case_folder import CASE, RunFolderError, load_finished
from millscale.runs.dumps import read_dump


def compare_two(first: Charge, second: Charge) -> dict[str, Any]:
    """Return what the two charges are, and the errors of the first against the second.

    Keys: docs/reference/files.md.

    Raises:
        RunFolderError: no dumps, or a damaged one.
    """
    both = (first, second)
    end = min(charge.result["rotation_angle_rad"] for charge in both)
    found = [snapshots_at(charge.finished, wanted_angles(end)) for charge in both]
    by_angle = {}
    for angle in sorted(found[0].keys() & found[1].keys()):
        shapes = [
            shape_of(read_dump(dumps[angle].path), dumps[angle], charge.case)
            for dumps, charge in zip(found, both, strict=True)
        ]
        by_angle[angle] = shape_errors(*shapes)
    about = [
        {"id": c.id, "S": c.S, "seed": c.case["seed"], "ranks": c.timing["ranks"]}
        | {"dimensionless": c.result["dimensionless"]}
        for c in both
    ]
    return {"cases": about, **all_errors(first, second, by_angle)}


def load_charge(folder: Path) -> Charge:
    """Return a finished multi-ball case.

    Raises:
        RunFolderError: not finished, or not a multi-ball case.
    """
    case = load_finished(folder)
    if case.case["kind"] != "multi-ball":
        raise RunFolderError(folder / CASE, "not a multi-ball case", "give multi-ball cases")
    return Charge("", case)
