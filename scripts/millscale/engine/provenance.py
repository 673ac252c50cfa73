"""Record of a finished stage in provenance.json: code, machine, command, digests of its files.

`millscale.runs.current` finds by these digests which stages are done. The stages that read a
product, and `millscale verify`, compare them with the files.
"""

from __future__ import annotations

import os
import platform
import shlex
import socket
import sys
import time
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

from millscale.engine.code_version import code
from millscale.engine.environment import COMMAND_VARIABLE
from millscale.engine.log import engine_version
from millscale.engine.machine import hardware
from millscale.runs.case_file import Case
from millscale.runs.digests import digest_of, files_of
from millscale.runs.provenance import read_provenance


class DamagedFileError(RuntimeError):
    """A file is not the one that a stage made."""


def stage_provenance(
    folder: Path,
    case: Case,
    inputs: Iterable[str],
    made: Mapping[str, Path],
    log: Path,
    ranks: int,
) -> dict[str, Any]:
    """Return the record of a stage that is about to publish its products.

    Args:
        folder: case folder, with the inputs.
        made: files and folders of files the stage publishes, by name.
        log: of the engine; need not exist.
    """
    engine = {}
    if log.exists():
        engine = {"engine": _engine() | {"version": engine_version(log)}, "ranks": ranks}
    return {
        **code(),
        **engine,
        "hardware": hardware(),
        "host": socket.gethostname(),
        "system": platform.platform(),
        "command": os.environ.get(COMMAND_VARIABLE, ""),
        "stage_command": shlex.join(sys.argv),
        "ended": time.time(),
        "case": case.digest,
        "inputs": {name: digest_of(folder / name) for name in files_of(folder, inputs)},
        "products": {
            name: digest_of(path.parent / name)
            for path in made.values()
            for name in files_of(path.parent, [path.name])
        },
    }


@cache
def _engine() -> dict[str, str]:
    from millscale.engine.deck_run import find_engine

    path = find_engine()
    return {"path": str(path), "sha256": digest_of(path, follow=True)}


def check_inputs(folder: Path, inputs: Iterable[str]) -> None:
    """Refuse inputs that are not what an earlier stage made; decks may be edited by hand.

    Raises:
        DamagedFileError: an input does not match its recorded digest.
    """
    for stage, made in read_provenance(folder).items():
        for name in files_of(folder, made["products"].keys() & set(inputs)):
            if not name.endswith(".in") and digest_of(folder / name) != made["products"][name]:
                raise DamagedFileError(
                    f"{name} does not match its digest: it is not the file that stage {stage} made"
                )
