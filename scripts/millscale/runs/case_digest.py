"""Comparison of cases by what decides them: the content of case.json without what only informs."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from millscale.runs.digests import json_digest

# Keys that inform: a case need not run again because their wording or numbers change.
INFORMING = ("digest", "liner_file", "model", "predicted", "versions", "warnings")
NAMES = ("id", "campaign")
# Another version, compiler or machine may round derived numbers otherwise. Thousands of roundings
# of double precision stay below this, and no input is known to as many digits.
ROUNDING = 1e-12
MISSING = object()


def case_digest(case: Mapping[str, Any]) -> str:
    """Return the hash of all that decides a case: of every key but those that only inform."""
    return json_digest({key: value for key, value in case.items() if key not in INFORMING})


def case_identity(case: Mapping[str, Any]) -> str:
    """Return the hash of the same keys without names: equal for the same case of two campaigns."""
    return json_digest(
        {key: value for key, value in case.items() if key not in (*INFORMING, *NAMES)}
    )


def differing_keys(
    wanted: Mapping[str, Any], found: Mapping[str, Any], above: str = ""
) -> Iterator[tuple[str, Any, Any]]:
    """Yield path, wanted and found value of each key that differs by more than rounding.

    The path is such as `mill.radius_m`; keys that only inform are left out. A value is `MISSING`
    where its document lacks the key.
    """
    for key in dict.fromkeys([*wanted, *found]):
        if not above and key in INFORMING:
            continue
        path = f"{above}{key}"
        a, b = wanted.get(key, MISSING), found.get(key, MISSING)
        if isinstance(a, Mapping) and isinstance(b, Mapping):
            yield from differing_keys(a, b, f"{path}.")
        elif not _agree(a, b):
            yield path, a, b


def _agree(a: Any, b: Any) -> bool:
    if isinstance(a, list | tuple) and isinstance(b, list | tuple):
        return len(a) == len(b) and all(map(_agree, a, b))
    if isinstance(a, float) and isinstance(b, int | float):
        return math.isclose(a, b, rel_tol=ROUNDING)
    return bool(a == b)
