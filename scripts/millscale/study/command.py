"""`millscale study`: run the settings of a parameter study and compare them."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

from rich.console import Console

from millscale.engine.machine import CoreWish
from millscale.engine.record import provenance
from millscale.errors import CampaignError, nearest
from millscale.runs.case_folder import read_json
from millscale.runs.lock import hold
from millscale.runs.untrusted import RunFolderError
from millscale.runs.writing import write_json
from millscale.study.file import Setting, StudyFile, load_study
from millscale.study.folders import Places, found_cases, record
from millscale.study.page import REPORT, RESULTS, build_study
from millscale.study.plan import render, study_plan
from millscale.study.results import StudyResults, published, with_study
from millscale.study.running import RunOptions, run_settings
from millscale.study.tables import tables
from millscale.workflow.placement import OPEN

# Of a plan without a runs folder: no case in it is finished.
NO_FOLDER = Path("/nonexistent")


@dataclass(frozen=True)
class StudyCall:
    """Arguments of the command.

    Attributes:
        runs: runs folder of the study; NO_FOLDER for a plan without one.
        others: runs folders whose finished cases are reused.
        only: names of settings to run, or patterns with `*`; empty for every setting.
        no_run: compare finished cases only.
        to: file that also gets the results.
    """

    file: Path
    runs: Path
    others: tuple[Path, ...] = ()
    only: tuple[str, ...] = ()
    cores: CoreWish = OPEN
    ignore_disk: bool = False
    no_run: bool = False
    to: Path | None = None


def plan(call: StudyCall) -> list[dict[str, Any]]:
    """Return the rows of `plan.study_plan`; writes no file."""
    study = load_study(call.file)
    places = Places(call.runs, call.others)
    places.check("millscale study")
    chosen = {setting.name for setting in _chosen(study, call.only)}
    found = {s.name: found_cases(study.settings, s, places) for s in study.settings}
    return [row for row in study_plan(study, found) if row["setting"] in chosen]


def run_and_compare(call: StudyCall, console: Console) -> tuple[bool, StudyResults]:
    """Run missing cases and write the page; return whether all cases have results, and the results.

    Raises:
        CampaignError: wrong arguments, or no case can be compared.
    """
    study = load_study(call.file)
    places = Places(call.runs, call.others)
    places.check("millscale study")
    chosen = _chosen(study, call.only)
    content = _content_of(call.to) if call.to else {}
    done = True
    with hold(places.runs):
        record(study, places)
        if not call.no_run:
            how = RunOptions(call.cores, call.ignore_disk, console)
            done = run_settings(study.settings, chosen, places, how)
            record(study, places)
        about = provenance()
        results = _compared(places.runs, about)
    if call.to:
        write_json(call.to, with_study(content, published([results], about)))
    for part in tables(results):
        console.print(part)
    console.print(f"page: {places.runs / REPORT / 'index.html'}", markup=False, highlight=False)
    return done, results


def results_text(call: StudyCall) -> str:
    """Return speed-against-error.json of a study that has been compared."""
    return (call.runs / REPORT / RESULTS).read_text(encoding="utf-8").rstrip("\n")


def _compared(runs: Path, about: dict[str, Any]) -> StudyResults:
    try:
        return build_study(runs, about)
    except RunFolderError as error:
        raise CampaignError(error.path, "", error.cause, error.remedy) from None


def _content_of(file: Path) -> dict[str, Any]:
    """Return speed-against-error.json, or an empty one."""
    if not file.exists():
        if not file.parent.is_dir():
            raise CampaignError("millscale study", "--to", f"no folder {file.parent}", "a file")
        return published([], {})
    try:
        content = read_json(file, "millscale study --to")
    except RunFolderError as error:
        raise CampaignError(file, "", error.cause, error.remedy) from None
    if not isinstance(content.get("rows"), list) or not isinstance(content.get("studies"), dict):
        cause = "not a file of millscale study --to"
        raise CampaignError(file, "", cause, "another file, or delete it")
    return content


def _chosen(study: StudyFile, only: Sequence[str]) -> list[Setting]:
    names = [setting.name for setting in study.settings]
    for pattern in only:
        if not any(fnmatchcase(name, pattern) for name in names):
            near = nearest(pattern, names) or names[0]
            cause = f"no setting {pattern}, nearest is {near}"
            raise CampaignError("millscale study", "--only", cause, ", ".join(names))
    return [
        setting
        for setting in study.settings
        if not only or any(fnmatchcase(setting.name, pattern) for pattern in only)
    ]


def plan_text(rows: list[dict[str, Any]]) -> str:
    return json.dumps(rows, indent=1, allow_nan=False)


__all__ = ["StudyCall", "plan", "plan_text", "render", "results_text", "run_and_compare"]
