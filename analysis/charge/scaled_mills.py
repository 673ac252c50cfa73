"""Scaled mills and their references: which charges are seeds of one mill, which are compared.

At S = 1 all schemes and policies are the same mill, the physical one. Mills with another state of
the liner are never references of each other.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import NamedTuple

from millscale.analysis.finished import Charge

Pair = tuple[Charge, Charge]


class MillName(NamedTuple):
    """What all seeds of a scaled mill share; `policy` with the state of the liner, as in
    `Finished.variant`."""

    campaign: str
    scheme: str
    policy: str
    stiffness: str
    S: float


@dataclass(frozen=True, eq=False)
class ScaledMill:
    """The finished charges of one scaled mill, which differ in the packing alone, by seed."""

    name: MillName
    seeds: tuple[Charge, ...]

    @property
    def first(self) -> Charge:
        return self.seeds[0]

    @property
    def is_physical(self) -> bool:
        return self.first.case.is_physical

    def pairs(self) -> list[Pair]:
        """Return every two of its seeds, once."""
        return list(combinations(self.seeds, 2))


def scaled_mills(charges: Sequence[Charge]) -> list[ScaledMill]:
    """Return the scaled mills of some charges, in their order."""
    groups: dict[MillName, list[Charge]] = {}
    for charge in charges:
        groups.setdefault(mill_name(charge), []).append(charge)
    return [
        ScaledMill(name, tuple(sorted(group, key=lambda charge: charge.seed)))
        for name, group in groups.items()
    ]


def mill_name(charge: Charge) -> MillName:
    """Return the name of the scaled mill of a charge."""
    return MillName(charge.campaign, charge.scheme, charge.variant, charge.stiffness, charge.S)


@dataclass(frozen=True)
class Charges:
    """All charges that are compared with one another, and what each is compared with."""

    every: tuple[Charge, ...]

    def __iter__(self) -> Iterator[Charge]:
        return iter(self.every)

    @cached_property
    def mills(self) -> list[ScaledMill]:
        return scaled_mills(self.every)

    @cached_property
    def _mill_of(self) -> dict[Charge, ScaledMill]:
        return {charge: mill for mill in self.mills for charge in mill.seeds}

    def mill_of(self, charge: Charge) -> ScaledMill:
        """Return the scaled mill that a charge is a seed of."""
        return self._mill_of[charge]

    def reference_of(self, charge: Charge) -> Charge:
        """Return what a charge is compared with; itself if it is a seed of the reference.

        Among the mills with the same state of the liner: the physical mill of its own campaign,
        there of its own scheme, policy and stiffness if possible. Else the physical mill of another
        campaign. Else the largest mill (smallest S) of its own campaign. The first seed of each.
        """
        mill = self.mill_of(charge)
        alike = [other for other in self.mills if other.first.state == charge.state]
        own = [other for other in alike if other.name.campaign == mill.name.campaign]
        largest = [other for other in own if min(x.name.S for x in own) == other.name.S]
        physical = [other for other in alike if other.is_physical]

        def likeness(other: ScaledMill) -> tuple:
            differs = [a != b for a, b in zip(other.name[:4], mill.name[:4], strict=True)]
            return *differs, other.first.seed

        best = min(physical or largest, key=likeness)
        return charge if best is mill else best.first

    def twin_of(self, charge: Charge) -> Charge | None:
        """Return the same mill and seed at constant gravity, of a charge at constant speed; of its
        own campaign if possible."""
        if charge.scheme != "constant-speed":
            return None
        name = mill_name(charge)
        twins = [
            other
            for other in self.every
            if other.scheme == "constant-gravity"
            and mill_name(other)[2:] == name[2:]
            and (other.seed, other.balls) == (charge.seed, charge.balls)
        ]
        return min(twins, key=lambda other: other.campaign != charge.campaign, default=None)

    def with_seeds_near(self, charge: Charge) -> ScaledMill | None:
        """Return the scaled mill of the same campaign, nearest in S, that has several seeds; its
        own mill if that has."""
        own = self.mill_of(charge)
        several = [
            mill
            for mill in self.mills
            if mill.name.campaign == charge.campaign and len(mill.seeds) > 1
        ]

        def distance(mill: ScaledMill) -> tuple:
            return mill is not own, abs(mill.name.S - charge.S), mill.name[1:4] != own.name[1:4]

        return min(several, key=distance, default=None)

    def compared_pairs(self) -> list[Pair]:
        """Return all pairs to compare: with references, with twins, seeds with one another."""
        found = [(charge, self.reference_of(charge)) for charge in self.every]
        found += [(charge, self.twin_of(charge)) for charge in self.every]
        found += [pair for mill in self.mills for pair in mill.pairs()]
        return list(dict.fromkeys((a, b) for a, b in found if b is not None and b is not a))
