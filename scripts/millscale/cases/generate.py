"""Writes a campaign's resolved cases; the stages read nothing but these."""

from __future__ import annotations

import json
import shlex
from collections.abc import Collection, Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from millscale.campaign.build import load_campaign
from millscale.campaign.campaign import Campaign
from millscale.cases.case import cases_of
from millscale.engine.code_version import installed_version
from millscale.errors import CampaignError
from millscale.runs.case_digest import case_digest, differing_keys
from millscale.runs.case_file import SCHEMA, Case, load_case
from millscale.runs.digests import digest_of, text_digest
from millscale.runs.layout import CAMPAIGN_FILE, CASE_FILE, CASES_FOLDER
from millscale.runs.untrusted import MOST_JSON, RunFolderError, is_id, read_object, read_text
from millscale.runs.writing import write_text
from millscale.terminal import one_line

# The campaign file as it was when the cases were written.
CAMPAIGN_COPY = "campaign.toml"


def generate(
    campaign_file: str | Path, runs: str | Path, only: Collection[str] | None = None
) -> list[Case]:
    """Resolve a campaign; write campaign.json, a copy of the file and a case.json for each case.

    A case.json is touched only if something that decides the case has changed. Folders of cases
    that left the campaign stay. Nothing is written if the campaign is not accepted.

    Args:
        only: ids of the cases whose case.json may be replaced; one that is not there yet is written
            all the same. None: every case.

    Returns:
        The cases, in the order of the campaign.

    Raises:
        CampaignError: the campaign is not accepted, or the folder is another campaign's.
    """
    campaign = load_campaign(campaign_file)
    runs = Path(runs)
    cases = as_written(cases_of(campaign), runs)
    check_owner(campaign, cases, runs)
    for case in cases:
        folder = runs / CASES_FOLDER / case.id
        folder.mkdir(parents=True, exist_ok=True)
        found = _digest_of(folder / CASE_FILE)
        chosen = only is None or case.id in only or found is None
        if chosen and found != case.digest:
            write_text(folder / CASE_FILE, case.text())
    _write_if_new(runs / CAMPAIGN_COPY, Path(campaign_file).read_text(encoding="utf-8"))
    _write_if_new(runs / CAMPAIGN_FILE, json.dumps(_summary(campaign, cases), indent=2) + "\n")
    return cases


def as_written(cases: Iterable[Case], runs: str | Path) -> list[Case]:
    """Return the cases, each as its case.json states it if the two differ by rounding alone.

    Such a case is finished if its stages are: rounding in another version does not start it again.
    """
    return [_as_written(case, Path(runs) / CASES_FOLDER / case.id) for case in cases]


def _as_written(case: Case, folder: Path) -> Case:
    found = _document(folder / CASE_FILE)
    if not found or case_digest(found) == case.digest or any(differing_keys(case.document, found)):
        return case
    try:
        return load_case(folder)
    except RunFolderError:
        return case


def check_owner(campaign: Campaign, cases: list[Case], runs: Path) -> None:
    """Refuse a runs folder of another campaign, or one whose campaign file was edited in it.

    A campaign is known by its name and its physical mill: everything else may be changed.

    Raises:
        CampaignError: says what differs and what to do.
    """
    owner = _owner(cases, runs)
    if owner is None:
        return
    other = "another folder after --runs: a runs folder belongs to one campaign"
    if owner["name"] != campaign.name:
        cause = f'belongs to campaign "{owner["name"]}", {campaign.file} is "{campaign.name}"'
        raise CampaignError(runs, "", cause, other)
    physical = cases[0].document["physical"]
    for key, value in physical.items():
        if (found := owner["physical"].get(key, value)) != value:
            cause = f"belongs to another physical mill: its {key} is {found!r:.60}, not {value!r}"
            raise CampaignError(runs, "", cause, other)
    copy = runs / CAMPAIGN_COPY
    # A link is refused by the lock.
    if owner["copy"] and copy.is_file() and not copy.is_symlink():
        text = campaign.file.read_text(encoding="utf-8")
        if digest_of(copy) not in (owner["copy"], text_digest(text)):
            where = shlex.quote(str(copy))
            remedy = f"mv {where} mine.toml and run that, or rm {where} to give up the changes"
            raise CampaignError(copy, "", "changed by hand, and would be overwritten", remedy)


def _owner(cases: list[Case], runs: Path) -> dict[str, Any] | None:
    """Return name, physical mill and digest of the campaign file of a runs folder.

    Without campaign.json they are taken from its first case. None for a new folder.
    """
    if (runs / CAMPAIGN_FILE).exists():
        summary = read_summary(runs)
        physical = summary.get("physical")
        if isinstance(physical, Mapping):
            return {"name": summary["name"], "physical": physical, "copy": summary.get("copy")}
    folders = (runs / CASES_FOLDER / case.id for case in cases)
    for document in filter(None, (_document(folder / CASE_FILE) for folder in folders)):
        physical = document.get("physical")
        if isinstance(physical, Mapping) and isinstance(document.get("campaign"), str):
            return {"name": document["campaign"], "physical": physical, "copy": None}
    return None


def read_summary(runs: Path) -> dict[str, Any]:
    """Return the content of campaign.json, whose ids are names that stay in their folder.

    Raises:
        CampaignError: the folder holds no generated campaign.
    """
    accepted = "a folder made by `millscale generate` or `run`"
    path = runs / CAMPAIGN_FILE
    if not path.exists():
        raise CampaignError(runs, "", f"no {CAMPAIGN_FILE} in it", accepted)
    try:
        summary = read_object(path, accepted)
    except RunFolderError as error:
        raise CampaignError(path, "", error.cause, error.remedy) from None
    name, ids = summary.get("name"), summary.get("cases")
    if not isinstance(name, str) or not isinstance(ids, list):
        raise CampaignError(path, "", "not understood", accepted)
    for case_id in ids:
        if not is_id(case_id):
            cause = f"got {case_id!r:.60}, not the id of a case"
            raise CampaignError(path, "cases", cause, "ids such as sb-cg-paper-S1.000")
    return summary


def changed_cases(cases: list[Case], runs: str | Path) -> set[str]:
    """Return the ids of the cases that `generate` would write, new ones included."""
    folder = Path(runs) / CASES_FOLDER
    return {case.id for case in cases if _digest_of(folder / case.id / CASE_FILE) != case.digest}


def _summary(campaign: Campaign, cases: list[Case]) -> dict[str, Any]:
    return {
        "schema": SCHEMA,
        "name": campaign.name,
        "about": campaign.about,
        "file": one_line(campaign.file.name),
        "cases": [case.id for case in cases],
        "digests": {case.id: case.digest for case in cases},
        "physical": cases[0].document["physical"],
        "copy": text_digest(campaign.file.read_text(encoding="utf-8")),
        "run": {"ranks": campaign.ranks, "jobs": campaign.jobs},
        "versions": {"millscale": installed_version()},
    }


def _digest_of(path: Path) -> str | None:
    """Return the digest of a case.json's content as it stands, so that an edited file counts as
    changed."""
    document = _document(path)
    return case_digest(document) if document else None


def _document(path: Path) -> Mapping[str, Any] | None:
    try:
        return read_object(path, "", MOST_JSON)
    except RunFolderError:
        return None


def _write_if_new(path: Path, text: str) -> None:
    with suppress(RunFolderError):
        if read_text(path, MOST_JSON, "") == text:
            return
    write_text(path, text)
