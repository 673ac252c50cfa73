"""provenance.json of a case folder: for each finished stage, with what it was made, and digests.

Digests are SHA-256 of whole files, taken when a stage ends. A stage has a record once its products
are published; who made it and on what machine stands beside the digests.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from millscale.runs.digests import rested_state
from millscale.runs.untrusted import RunFolderError, read_object, understood
from millscale.runs.writing import write_json

PROVENANCE_FILE = "provenance.json"
SCHEMA = 1


# Of the folder that was asked for last: several questions are asked of a case.
_LAST: dict[str, tuple[Any, dict[str, Any]]] = {}


def read_provenance(folder: Path) -> dict[str, Any]:
    """Return Stage name -> what provenance.json says of it; empty if there is none that can be
    read. To be read, not changed."""
    path = folder / PROVENANCE_FILE
    place, state = os.path.abspath(path), rested_state(path)  # noqa: PTH100
    if place not in _LAST or state is None or _LAST[place][0] != state:
        _LAST.clear()
        _LAST[place] = state, _read(path)
    return _LAST[place][1]


def _read(path: Path) -> dict[str, Any]:
    try:
        content = read_object(path, "")
        with understood(path, ""):
            stages = content["stages"]
            fits = content["schema"] == SCHEMA and all(_fits(x) for x in stages.values())
    except RunFolderError:
        return {}
    return stages if fits else {}


def _fits(stage: Any) -> bool:
    """Return whether digests of files inside the folder are there."""
    parts = [stage["inputs"], stage["products"]]
    return all(
        isinstance(digest, str)
        and name.isprintable()
        and not {"", ".", ".."}.intersection(name.split("/"))
        for part in parts
        for name, digest in part.items()
    )


def write_provenance(folder: Path, stages: Mapping[str, Any]) -> None:
    """Write provenance.json."""
    write_json(folder / PROVENANCE_FILE, {"schema": SCHEMA, "stages": stages})
