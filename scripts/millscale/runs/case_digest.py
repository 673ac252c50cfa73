"""Hashes of the content of a case.json: of what decides the case, without what is only said."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Any

# Parts that inform: a case need not run again because their wording or numbers change.
SAID = ("digest", "model", "predicted", "versions", "warnings")
NAMES = ("id", "campaign")


def case_digest(case: Mapping[str, Any]) -> str:
    """Hash of all that decides a case: everything but what is only said about it."""
    return _hash({key: value for key, value in case.items() if key not in SAID})


def case_identity(case: Mapping[str, Any]) -> str:
    """The same without names, so that a case of another campaign can be the same case."""
    return _hash({key: value for key, value in case.items() if key not in (*SAID, *NAMES)})


def is_outdated(campaign: Mapping[str, Any], case: Mapping[str, Any]) -> bool:
    """Whether a campaign.json names another content for a case than its case.json has: the campaign
    was edited since, and the case has not been run again."""
    wanted = campaign.get("digests")
    if not isinstance(wanted, Mapping) or case.get("id") not in wanted:
        return False
    return wanted[case["id"]] != case_digest(case)


def _hash(content: Mapping[str, Any]) -> str:
    text = json.dumps(content, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()
