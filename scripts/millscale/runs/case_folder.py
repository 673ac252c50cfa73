"""The JSON files of a run folder: where cases are, reading with clear errors."""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from millscale.runs.case_file import Case, load_case
from millscale.runs.current import why_stale
from millscale.runs.typed import shown
from millscale.runs.untrusted import RunFolderError, is_id, read_object
from millscale.terminal import one_line

CASE, TIMING, RESULT, SERIES, LINER, STAGE = (
    "case.json",
    "timing.json",
    "result.json",
    "series.csv",
    "liner.stl",
    "stage.json",
)
SCHEMA = 1


@dataclass(frozen=True)
class FinishedCase:
    """What a case folder holds once its analysis is done."""

    folder: Path
    case: Case
    result: dict[str, Any]
    timing: dict[str, Any]

    @property
    def id(self) -> str:
        return self.case.id


def read_json(path: Path, made_by: str) -> dict[str, Any]:
    """Return the content of a JSON object with a known schema.

    Args:
        made_by: the command that makes the file, for the error message.

    Raises:
        RunFolderError: missing, cut short, not an object, or of another schema.
    """
    there = path.exists()
    content = read_object(path, f"{'delete it, then' if there else 'make it with'}: {made_by}")
    if content.get("schema", SCHEMA) != SCHEMA:
        raise RunFolderError(
            path,
            f"schema {content['schema']!r:.60}, accepted {SCHEMA}",
            f"delete it, then: {made_by}",
        )
    return content


def load_timing(folder: Path) -> dict[str, Any]:
    """Return the timing.json of a case folder."""
    return read_json(folder / TIMING, run_line(folder))


def load_finished(folder: Path) -> FinishedCase:
    """Return all JSON files of a finished case.

    Raises:
        RunFolderError: one is missing or damaged, or was not made from this case.json.
    """
    case = load_case(folder)
    check_current(folder, case)
    made_by = shlex.join(["millscale", "analyse", "case", str(folder)])
    result = read_json(folder / RESULT, made_by)
    if case.kind == "multi-ball" and "torque_balance" not in result:
        cause = "its torque and power are samples of single steps, made by an earlier version"
        raise RunFolderError(folder / RESULT, cause, f"run the case again: {run_line(folder)}")
    return FinishedCase(folder, case, result, load_timing(folder))


def finished_or_reason(folder: Path) -> FinishedCase | str:
    """Return a finished case, or why it cannot be used."""
    if missing_products(folder):
        return why_missing(folder)
    try:
        return load_finished(folder)
    except RunFolderError as error:
        return one_line(f"{error.path.name}: {error.cause}; {error.remedy}")


def check_current(folder: Path, case: Case, upto: str = "result") -> None:
    """Refuse products that were not made from the case.json and the other files beside them.

    Args:
        upto: the last stage whose products are read.

    Raises:
        RunFolderError: says what has changed.
    """
    if reason := why_stale(folder, case.kind, upto):
        raise RunFolderError(folder, f"stale: {reason}", f"make it again: {run_line(folder)}")


def case_folders(runs: Path) -> list[Path]:
    """Return the folders of all generated cases, in the order of campaign.json.

    Raises:
        RunFolderError: no case there.
    """
    remedy = "give the folder made by: millscale generate FILE --runs DIR"
    listed = read_json(runs / "campaign.json", "millscale generate FILE --runs DIR").get("cases")
    if listed is None:
        found = sorted(path.parent for path in runs.glob(f"cases/*/{CASE}"))
    else:
        found = []
        for entry in listed if isinstance(listed, list) else [listed]:
            case_id = entry.get("id") if isinstance(entry, dict) else entry
            if not is_id(case_id):
                cause = f"cases: got {shown(case_id)}, not the id of a case"
                raise RunFolderError(runs / "campaign.json", cause, remedy)
            found.append(runs / "cases" / str(case_id))
    if not found:
        raise RunFolderError(runs, "holds no cases", remedy)
    return found


def missing_products(folder: Path) -> list[str]:
    """Return the missing products of an unfinished case, in the order of the stages."""
    return [name for name in (CASE, SERIES, TIMING, RESULT) if not (folder / name).exists()]


def why_missing(folder: Path) -> str:
    """Return why a case is not finished: the failure of its last stage, or missing products."""
    absent = missing_products(folder)
    try:
        record = read_json(folder / STAGE, "")
    except RunFolderError:
        record = {}
    words = [record.get(key) for key in ("stage", "cause", "advice")]
    if record.get("state") != "failed" or not all(isinstance(x, str) for x in words):
        return f"no {', '.join(absent)} yet"
    return one_line(f"{words[0]} failed: {words[1]}" + (f"; to do: {words[2]}" if words[2] else ""))


def run_line(folder: Path) -> str:
    """Return the command that makes the files of a case folder."""
    runs = shlex.quote(str(folder.parent.parent))
    return f"millscale run FILE --runs {runs} --only {shlex.quote(folder.name)}"


def verify_line(runs: Path) -> str:
    """Return the command that finds damaged files of a runs folder."""
    return shlex.join(["millscale", "verify", str(runs)])
