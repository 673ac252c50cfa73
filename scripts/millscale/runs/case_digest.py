"""Hashes of what decides a case: the content of case.json without what only informs."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Any

# Keys that inform: a case need not run again because their wording or numbers change.
INFORMING = ("digest", "model", "predicted", "versions", "warnings")
NAMES = ("id", "campaign")


def case_digest(case: Mapping[str, Any]) -> str:
    """Return the hash of all that decides a case: of every key but those that only inform."""
    return _hash({key: value for key, value in case.items() if key not in INFORMING})


def case_identity(case: Mapping[str, Any]) -> str:
    """Return the hash of the same keys without names: equal for the same case of two campaigns."""
    return _hash({key: value for key, value in case.items() if key not in (*INFORMING, *NAMES)})


def _hash(content: Mapping[str, Any]) -> str:
    text = json.dumps(content, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()
