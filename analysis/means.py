"""Means and scatter of values of which some may be missing."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np


def mean_known(values: Iterable[Any]) -> Any:
    """Return the mean of the values that are not None, of mappings entry by entry; None if there is
    none."""
    known = [value for value in values if value is not None]
    if not known:
        return None
    if isinstance(known[0], Mapping):
        names = sorted({name for value in known for name in value}, key=_by_number)
        return {name: mean_known(v.get(name) for v in known) for name in names} or None
    return float(np.mean(known))


def deviation(values: Sequence[float | None]) -> float | None:
    """Return the standard deviation (n - 1) of the values that are not None; None below two."""
    known = [value for value in values if value is not None]
    return float(np.std(known, ddof=1)) if len(known) > 1 else None


def _by_number(name: str) -> tuple[int, str]:
    return (int(name) if name.isdecimal() else 0, name)
