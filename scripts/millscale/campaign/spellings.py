"""Other spellings of a campaign key: in another unit, or as a diameter in place of a radius."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from millscale.campaign.keys import Key
from millscale.campaign.units import AGREEMENT, UNITS, split_unit

_UNIT_IN_WORDS = re.compile(r" \[[^\]]+\]")
_SHARE = UNITS["_percent"].dimension


@dataclass(frozen=True)
class Spelling:
    """Another spelling of a key.

    A number of it times `numerator` / `denominator` is a number of the key.

    Attributes:
        canonical: the key as it is declared.
        key: what the spelling accepts, bounds in its own unit.
    """

    canonical: str
    key: Key
    numerator: float
    denominator: float

    def to_canonical(self, value: Any) -> Any:
        """Return an accepted value in the unit of the declared key; words stay as they are."""
        if isinstance(value, tuple):
            return tuple(self.to_canonical(one) for one in value)
        if isinstance(value, str):
            return value
        return value * self.numerator / self.denominator


def spelling_of(word: str, known: Mapping[str, Key]) -> Spelling | None:
    """Return how a word spells one of the known keys; None if it is one, or spells none."""
    quantity, suffix = split_unit(word)
    if word in known or suffix not in UNITS or not word.endswith(suffix):
        return None
    for name, key in known.items():
        if key.type != "number" or _dimension(name, key) != UNITS[suffix].dimension:
            continue
        own, own_suffix = split_unit(name)
        if quantity not in (own, _as_diameter(own)):
            continue
        unit, canonical = UNITS[suffix], UNITS.get(own_suffix)
        numerator = unit.numerator * (canonical.denominator if canonical else 1)
        denominator = unit.denominator * (canonical.numerator if canonical else 1)
        denominator *= 1 if quantity == own else 2
        scaled = [
            None if bound is None else bound * denominator / numerator
            for bound in (key.above, key.least, key.most)
        ]
        # The unit of the meaning is that of the declared key.
        meaning = _UNIT_IN_WORDS.sub("", key.meaning)
        meaning = meaning if quantity == own else f"twice {meaning}"
        own_unit = replace(key, meaning=meaning, above=scaled[0], least=scaled[1], most=scaled[2])
        return Spelling(name, own_unit, numerator, denominator)
    return None


def spellings_of(name: str, key: Key) -> list[str]:
    """Return every other spelling of a key."""
    quantity, dimension = split_unit(name)[0], _dimension(name, key)
    if key.type != "number" or dimension is None:
        return []
    suffixes = [unit for unit, known in UNITS.items() if known.dimension == dimension]
    quantities = dict.fromkeys([quantity, _as_diameter(quantity)])
    return [
        quantity + unit for quantity in quantities for unit in suffixes if quantity + unit != name
    ]


def agree(one: Any, other: Any) -> bool:
    """Return whether two values of a key, or two tuples of them, agree within `AGREEMENT`."""
    if isinstance(one, tuple) and isinstance(other, tuple):
        return len(one) == len(other) and all(map(agree, one, other))
    if isinstance(one, float | int) and isinstance(other, float | int):
        return abs(one - other) <= AGREEMENT * abs(one)
    return bool(one == other)


def _dimension(name: str, key: Key) -> str | None:
    """Return what the unit of a key measures; of a key without unit, whether it is a share."""
    suffix = split_unit(name)[1]
    if suffix in UNITS:
        return UNITS[suffix].dimension
    return _SHARE if key.most is not None and key.most <= 1.0 else None


def _as_diameter(quantity: str) -> str:
    return "_".join("diameter" if word == "radius" else word for word in quantity.split("_"))
