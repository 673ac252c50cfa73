"""What provenance.json says of a stage that ends: with what it was made, and digests of its files.

`millscale.runs.current` asks by these digests what is done; the stages that read a product and
`millscale verify` compare them.
"""

from __future__ import annotations

import os
import platform
import shlex
import socket
import sys
import time
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from millscale.engine.log import engine_version
from millscale.engine.machine import hardware
from millscale.runs.case_digest import case_digest
from millscale.runs.digests import digest_of, files_of
from millscale.runs.provenance import read_provenance
from millscale.runs.untrusted import RunFolderError, read_object

BUILD_FILE = "build.json"
# The command line that a person typed; `millscale run` hands it down to the stages.
COMMAND_VARIABLE = "MILLSCALE_COMMAND"
LIBRARIES = ("numpy", "scipy", "gmsh", "psutil", "snakemake")
_GIT_HEAD_BYTES = 4096


class DamagedFileError(RuntimeError):
    """A file is not what a stage made."""


def stage_provenance(
    folder: Path,
    case: Mapping[str, Any],
    inputs: Iterable[str],
    made: Mapping[str, Path],
    log: Path,
    ranks: int,
) -> dict[str, Any]:
    """What provenance.json says of a stage that is about to publish its products.

    Args:
        folder: case folder, with the inputs.
        case: content of its case.json.
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
        "case": case_digest(case),
        "inputs": {name: digest_of(folder / name) for name in files_of(folder, inputs)},
        "products": {
            name: digest_of(path.parent / name)
            for path in made.values()
            for name in files_of(path.parent, [path.name])
        },
    }


@cache
def code() -> dict[str, Any]:
    """Version and commit of the Python code, the build of the compiled parts, the libraries."""
    return {
        "millscale": installed_version(),
        "commit": source_commit() or (build_record() or {}).get("commit"),
        "build": build_record(),
        "python": platform.python_version(),
        "libraries": dict(sorted(_libraries())),
    }


@cache
def installed_version() -> str:
    """Version of the installed package; "source" when run from the source tree."""
    try:
        return version("millscale")
    except PackageNotFoundError:
        return "source"


@cache
def build_record() -> dict[str, Any] | None:
    """build.json, which the build wrote; None if the compiled parts are not installed."""
    core = find_spec("millscale._core")
    beside = [Path(core.origin).parent] if core and core.origin else []
    for folder in (Path(__file__).parents[1], *beside):
        try:
            return read_object(folder / BUILD_FILE, "")
        except RunFolderError:
            continue
    return None


def source_commit() -> str | None:
    """Commit checked out where this file lies in its repository; None if it is installed."""
    git = Path(__file__).parents[3] / ".git"
    try:
        if git.is_file():
            git = git.parent / _git_text(git).removeprefix("gitdir:").strip()
        head = _git_text(git / "HEAD")
        if not head.startswith("ref:"):
            return head
        name = head.removeprefix("ref:").strip()
        shared = git / "commondir"
        places = [git, git / _git_text(shared)] if shared.exists() else [git]
        loose = next((x / name for x in places if (x / name).exists()), None)
        if loose:
            return _git_text(loose)
        packed = (places[-1] / "packed-refs").read_text(encoding="utf-8").splitlines()
        return next((line.split()[0] for line in packed if line.endswith(f" {name}")), None)
    except OSError:
        return None


def _git_text(path: Path) -> str:
    with path.open(encoding="utf-8") as file:
        return file.read(_GIT_HEAD_BYTES).strip()


def _libraries() -> Iterator[tuple[str, str]]:
    for name in LIBRARIES:
        try:
            yield name, version(name)
        except PackageNotFoundError:
            continue


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
