"""Version of the code that runs: package, commit, build of the compiled parts, libraries."""

from __future__ import annotations

import platform
import subprocess
from collections.abc import Iterator
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from millscale.runs.untrusted import RunFolderError, read_object

BUILD_FILE = "build.json"
LIBRARIES = ("numpy", "scipy", "gmsh", "psutil", "snakemake")
_GIT_HEAD_BYTES = 4096
_COMMIT_DIGITS = 12
# Of the repository, if this file lies in its sources.
_TOP = Path(__file__).parents[3]


@cache
def code() -> dict[str, Any]:
    """Return version and commit of the Python code, build of the compiled parts, libraries."""
    return {
        "millscale": installed_version(),
        "commit": source_commit() or (build_record() or {}).get("commit"),
        "build": build_record(),
        "python": platform.python_version(),
        "libraries": dict(sorted(_libraries())),
    }


@cache
def installed_version() -> str:
    """Return the version of the installed package; "source" if it is not installed."""
    try:
        return version("millscale")
    except PackageNotFoundError:
        return "source"


@cache
def build_record() -> dict[str, Any] | None:
    """Return build.json, which the build wrote; None if there is none."""
    core = find_spec("millscale._core")
    beside = [Path(core.origin).parent] if core and core.origin else []
    for folder in (Path(__file__).parents[1], *beside):
        try:
            return read_object(folder / BUILD_FILE, "")
        except RunFolderError:
            continue
    return None


def source_commit() -> str | None:
    """Return the commit of the repository that this file lies in; None if it is installed.

    Reads the files of git, because each stage calls it: a process would take longer.
    """
    git = _TOP / ".git"
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


def described_commit() -> str | None:
    """Return the commit of the code in 12 digits, with `-dirty` if files differ from it.

    None if it is unknown.
    """
    commit: str | None = source_commit()
    modified = False
    if commit:
        line = ["git", "-C", str(_TOP), "status", "--porcelain", "--untracked-files=no"]
        done = subprocess.run(line, capture_output=True, encoding="utf-8")
        modified = bool(done.stdout.strip())
    elif build := build_record():
        commit, modified = build.get("commit"), bool(build.get("modified"))
    return commit and commit[:_COMMIT_DIGITS] + ("-dirty" if modified else "")


def _git_text(path: Path) -> str:
    with path.open(encoding="utf-8") as file:
        return file.read(_GIT_HEAD_BYTES).strip()


def _libraries() -> Iterator[tuple[str, str]]:
    for name in LIBRARIES:
        try:
            yield name, version(name)
        except PackageNotFoundError:
            continue
