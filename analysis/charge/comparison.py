"""Every multi-ball case against its reference: rows of results.json and the shapes to draw."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from millscale.analysis.charge.measured import Measured, measure
from millscale.analysis.charge.pair_errors import PairErrors
from millscale.analysis.charge.rows import ChargeRow, charge_rows
from millscale.analysis.charge.scaled_mills import Charges
from millscale.analysis.finished import Charge


@dataclass(frozen=True)
class SchemeRow:
    """A charge at constant speed against its twin at constant gravity, the same mill and seed.

    Attributes:
        between_seeds: errors between two seeds of the twin's mill, or of the one nearest to it.
    """

    charge: Charge
    twin: Charge
    errors: PairErrors
    between_seeds: PairErrors | None

    def document(self) -> dict[str, Any]:
        """Return the row of results.json."""
        ours, theirs = self.charge.result.dimensionless, self.twin.result.dimensionless
        return {
            **{key: getattr(self.charge, key) for key in ("policy", "S", "seed", "stiffness")},
            "constant_speed": self.charge.id,
            "constant_gravity": self.twin.id,
            "dimensionless": {
                name: {"constant_speed": ours[name], "constant_gravity": theirs[name]}
                for name in ours
            },
            **self.errors.document(),
            "between_seeds": self.between_seeds and self.between_seeds.document(),
        }


@dataclass(frozen=True)
class ChargeComparison:
    """All charges against their references."""

    charges: Charges
    measured: Measured

    @cached_property
    def rows(self) -> list[ChargeRow]:
        """Return a row for each charge."""
        return charge_rows(self.charges, self.measured)

    @cached_property
    def schemes(self) -> list[SchemeRow]:
        """Return constant speed against constant gravity at the same S, stiffness and seed."""
        between = {row.charge: row.between_seeds for row in self.rows}
        twins = [(charge, self.charges.twin_of(charge)) for charge in self.charges]
        return [
            SchemeRow(charge, twin, self.measured.errors[charge, twin], between[twin])
            for charge, twin in twins
            if twin is not None
        ]


def compare_charges(charges: Sequence[Charge]) -> ChargeComparison:
    """Return every charge compared with its reference, seeds with one another, and the schemes at
    the same S."""
    every = Charges(tuple(charges))
    return ChargeComparison(every, measure(every.every, every.compared_pairs()))
