"""Writes a campaign's resolved cases; the stages read nothing but these."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from mill_campaign.case import SCHEMA, Case, cases_of, digest
from mill_campaign.case_check import CASE_ID
from mill_campaign.config import Campaign
from mill_campaign.config_build import load_campaign
from mill_campaign.errors import CampaignError
from mill_campaign.provenance import installed_version
from mill_runs.layout import CAMPAIGN_FILE, CASE_FILE, CASES_FOLDER

# The campaign file as it was when the cases were written.
CAMPAIGN_COPY = "campaign.toml"
# A hundred thousand ids.
LARGEST_SUMMARY_BYTES = 1 << 23


def generate(campaign_file: str | Path, runs: str | Path) -> list[Case]:
    """Resolve a campaign; write campaign.json, a copy of the file and a case.json for each case.

    A case.json is touched only if something that decides the case has changed: its date tells the
    workflow what to run again. Folders of cases that left the campaign stay. Nothing is written
    if the campaign is not accepted.

    Returns:
        The cases, in the order of the campaign.

    Raises:
        CampaignError: the campaign is not accepted.
    """
    campaign = load_campaign(campaign_file)
    cases = cases_of(campaign)
    runs = Path(runs)
    for case in cases:
        folder = runs / CASES_FOLDER / case.id
        folder.mkdir(parents=True, exist_ok=True)
        if _digest_of(folder / CASE_FILE) != case["digest"]:
            _write(folder / CASE_FILE, case.text())
    _write_if_new(runs / CAMPAIGN_COPY, Path(campaign_file).read_text(encoding="utf-8"))
    _write_if_new(runs / CAMPAIGN_FILE, json.dumps(_summary(campaign, cases), indent=2) + "\n")
    return cases


def read_summary(runs: Path) -> dict[str, Any]:
    """Content of the campaign.json of a runs folder: a name, and ids that are plain names.

    Raises:
        CampaignError: the folder holds no generated campaign.
    """
    accepted = "a folder made by `millscale generate` or `run`"
    path = runs / CAMPAIGN_FILE
    try:
        with path.open("rb") as file:
            summary = json.loads(file.read(LARGEST_SUMMARY_BYTES))
        name, ids = summary["name"], summary["cases"]
    except OSError:
        raise CampaignError(runs, "", f"no {CAMPAIGN_FILE} in it", accepted) from None
    except (ValueError, TypeError, KeyError, RecursionError):
        raise CampaignError(path, "", "not understood", accepted) from None
    if not isinstance(name, str) or not isinstance(ids, list):
        raise CampaignError(path, "", "not understood", accepted)
    for case_id in ids:
        if not isinstance(case_id, str) or not CASE_ID.fullmatch(case_id):
            cause = f"got {case_id!r:.60}, not the id of a case"
            raise CampaignError(path, "cases", cause, "ids such as sb-cg-paper-S1.000")
    return summary


def changed_cases(cases: list[Case], runs: str | Path) -> set[str]:
    """Ids of the cases that `generate` would write, new ones included."""
    folder = Path(runs) / CASES_FOLDER
    return {case.id for case in cases if _digest_of(folder / case.id / CASE_FILE) != case["digest"]}


def _summary(campaign: Campaign, cases: list[Case]) -> dict[str, Any]:
    return {
        "schema": SCHEMA,
        "name": campaign.name,
        "about": campaign.about,
        "file": campaign.file.name,
        "cases": [case.id for case in cases],
        "run": {"ranks": campaign.ranks, "jobs": campaign.jobs},
        "versions": {"millscale": installed_version()},
    }


def _digest_of(path: Path) -> str | None:
    """Digest of a case.json's content as it stands, so that an edited file counts as changed."""
    try:
        document = json.loads(path.read_text())
    except (OSError, ValueError, RecursionError):
        return None
    return digest(document) if isinstance(document, Mapping) else None


def _write_if_new(path: Path, text: str) -> None:
    with suppress(OSError):
        if path.read_text() == text:
            return
    _write(path, text)


def _write(path: Path, text: str) -> None:
    """Write under another name, then rename: a reader never sees half a file."""
    part = path.with_name(f"{path.name}.{os.getpid()}.part")
    # A link of that name would lead elsewhere.
    part.unlink(missing_ok=True)
    part.write_text(text)
    part.replace(path)
