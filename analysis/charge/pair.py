"""Two multi-ball cases against each other, such as one on 1 and on 2 ranks.

python -m millscale.analysis.charge.pair CASE CASE prints the errors of the first against the
second.
"""

from __future__ import annotations

import argparse
import json
import sys
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


def main(arguments: list[str] | None = None) -> int:
    """Command line; returns the exit code."""
    parser = argparse.ArgumentParser(
        prog="python -m millscale.analysis.charge.pair", description=__doc__
    )
    parser.add_argument("folders", type=Path, nargs=2, help="case folders")
    try:
        cases = [load_finished(folder) for folder in parser.parse_args(arguments).folders]
        for case in cases:
            if case.case["kind"] != "multi-ball":
                raise RunFolderError(
                    case.folder / CASE, "not a multi-ball case", "give two multi-ball cases"
                )
        print(json.dumps(compare_two(*(Charge("", case) for case in cases)), indent=1))
    except RunFolderError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
