"""Export the finished cases of a runs folder in the format of another program."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path

from millscale.analysis.finished import Charge, SingleBall
from millscale.analysis.finished_campaign import Campaign, load_campaign
from millscale.engine.record import provenance
from millscale.errors import nearest
from millscale.exports.ovito import write_ovito
from millscale.exports.paraview import write_paraview
from millscale.exports.tables import write_cases, write_tables
from millscale.runs.dumps import dump_files
from millscale.runs.links import check_folder
from millscale.runs.untrusted import RunFolderError
from millscale.runs.writing import write_json, writing_folder

FORMATS = ("paraview", "csv", "ovito")
FOLDER = "export"
# Marks a folder as an export, which another export may replace.
RECORD = "export.json"


@dataclass(frozen=True)
class Exported:
    """What was written.

    Attributes:
        files: the files to open, one for each case; of tables first that of all cases.
        left_out: why a case was not written, by its id.
    """

    files: list[Path] = field(default_factory=list)
    left_out: dict[str, str] = field(default_factory=dict)


def export(
    runs: Path,
    kind: str,
    to: Path | None = None,
    only: Sequence[str] = (),
    every: int = 1,
    replace: bool = False,
) -> Exported:
    """Write the finished cases of a runs folder in one format.

    Args:
        kind: of `FORMATS`.
        to: folder to write; None for DIR/export/KIND. It must be new, unless `replace`.
        only: ids of cases, or patterns with `*`; empty for every case.
        every: write every so many dumps.
        replace: replace an earlier export.

    Raises:
        RunFolderError: no such case, nothing to write, a damaged file, or a folder that is there.
    """
    campaign = load_campaign(Path(runs))
    if to is None:
        check_folder(campaign.runs)
    to = Path(to) if to else campaign.runs / FOLDER / kind
    found = Exported()
    chosen = []
    for case in _chosen(campaign, only):
        if reason := _why_not(case, kind):
            found.left_out[case.id] = reason
        else:
            chosen.append(case)
    if not chosen:
        causes = "; ".join(f"{name}: {why}" for name, why in found.left_out.items())
        raise RunFolderError(campaign.runs, f"nothing to export: {causes}", "see millscale status")
    _check_new(to, replace)
    to.parent.mkdir(parents=True, exist_ok=True)
    with writing_folder(to) as part:
        if kind == "csv":
            found.files.append(to / write_cases(campaign, part).name)
        for case in chosen:
            (part / case.id).mkdir()
            written = _write(case, kind, part / case.id, to / case.id, every)
            found.files.append(to / case.id / written.name)
        about = {"schema": 1, "format": kind, "campaign": campaign.name}
        write_json(part / RECORD, about | {"cases": [x.id for x in chosen]} | provenance())
    return found


def _chosen(campaign: Campaign, only: Sequence[str]) -> list[SingleBall | Charge]:
    """Return the cases that match; refuse a pattern without a finished case."""
    cases = campaign.cases
    ids = [case.id for case in cases]
    for pattern in only:
        if not any(fnmatchcase(name, pattern) for name in ids):
            for name, why in campaign.missing.items():
                if fnmatchcase(name, pattern):
                    raise RunFolderError(campaign.runs, f"{name} is not finished", why)
            near = nearest(pattern, ids) or ", ".join(ids[:3]) or "none"
            cause = f"--only {pattern}: no such finished case"
            raise RunFolderError(campaign.runs, cause, f"finished is {near}")
    return [x for x in cases if not only or any(fnmatchcase(x.id, pattern) for pattern in only)]


def _why_not(case: SingleBall | Charge, kind: str) -> str:
    """Return why a case cannot be written; empty if it can."""
    if kind == "csv":
        return ""
    if isinstance(case, SingleBall):
        return "a single ball has no dumps"
    return "" if dump_files(case.folder) else "it has no dumps"


def _check_new(to: Path, replace: bool) -> None:
    """Refuse a folder that is there; one that is no export is never replaced."""
    if not to.exists() and not to.is_symlink():
        return
    if not (to / RECORD).is_file():
        raise RunFolderError(to, "is there, and is no earlier export", "name a new folder: --to")
    if not replace:
        remedy = "--replace writes it again, --to DIR writes elsewhere"
        raise RunFolderError(to, "is there", remedy)


def _write(case: SingleBall | Charge, kind: str, part: Path, final: Path, every: int) -> Path:
    if kind == "csv":
        return write_tables(case, part, every)
    assert isinstance(case, Charge)
    if kind == "ovito":
        return write_ovito(case, part, every)
    return write_paraview(case, part, final, every)
