"""Hashes of what decides a case: the content of case.json without what only informs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from millscale.runs.digests import json_digest

# Keys that inform: a case need not run again because their wording or numbers change.
INFORMING = ("digest", "model", "predicted", "versions", "warnings")
NAMES = ("id", "campaign")


def case_digest(case: Mapping[str, Any]) -> str:
    """Return the hash of all that decides a case: of every key but those that only inform."""
    return json_digest({key: value for key, value in case.items() if key not in INFORMING})


def case_identity(case: Mapping[str, Any]) -> str:
    """Return the hash of the same keys without names: equal for the same case of two campaigns."""
    return json_digest(
        {key: value for key, value in case.items() if key not in (*INFORMING, *NAMES)}
    )
