"""Multi-ball cases as models of one mill: which are seeds of the same, which is the reference."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from millscale.runs.case_folder import SERIES, FinishedCase, is_physical
from millscale.runs.series import Series, read_series

Model = tuple[str, str, str, str, float]


@dataclass(frozen=True)
class Charge:
    """A finished multi-ball case and the name of its campaign."""

    campaign: str
    finished: FinishedCase

    @property
    def case(self) -> dict[str, Any]:
        return self.finished.case

    @property
    def result(self) -> dict[str, Any]:
        return self.finished.result

    @property
    def timing(self) -> dict[str, Any]:
        return self.finished.timing

    @cached_property
    def series(self) -> Series:
        return read_series(self.finished.folder / SERIES, "multi-ball")

    def has(self, column: str) -> bool:
        """Whether the series has a column; of nan is as good as none: a plain drum has no box."""
        return column in self.series and bool(np.isfinite(self.series[column]).all())

    @property
    def steady_from(self) -> float:
        """Mill angle at which the window of its means begins [rad]."""
        return self.result["mean_from_rad"]

    @property
    def id(self) -> str:
        return self.finished.id

    @property
    def key(self) -> tuple[str, str]:
        """Campaign and id."""
        return self.campaign, self.id

    @property
    def S(self) -> float:
        return self.case["S"]

    @property
    def stiffness(self) -> str:
        """fixed or overlap-matched; cases from before the choice are fixed."""
        return self.case["material"].get("stiffness", "fixed")

    @property
    def label(self) -> str:
        """For a legend of models of one scheme."""
        words = [f"S = {self.S:.4g}"]
        if self.stiffness != "fixed":
            words.append("E matched")
        if self.case["policy"] != "paper":
            words.append(self.case["policy"])
        return ", ".join(words)

    @property
    def model(self) -> Model:
        """What all seeds of a model share."""
        case = self.case
        return self.campaign, case["scheme"], case["policy"], self.stiffness, case["S"]

    @property
    def mass(self) -> float:
        """Mass of the charge [kg]."""
        return self.case["ball"]["mass_kg"] * self.case["ball"]["count"]

    @property
    def filling(self) -> float:
        """Balls a length, in the measure of the physical mill: N S^2 / L [1/m]. The same in
        models filled alike."""
        return self.case["ball"]["count"] * self.S**2 / self.case["mill"]["simulated_length_m"]


def seeds_of(charge: Charge, charges: Sequence[Charge]) -> list[Charge]:
    """The cases of a charge's model, itself among them, by seed."""
    same = [other for other in charges if other.model == charge.model]
    return sorted(same, key=lambda other: other.case["seed"])


def reference_of(charge: Charge, charges: Sequence[Charge]) -> Charge:
    """What a charge is compared with; itself if it is a seed of the reference.

    The physical mill, S = 1, of its own campaign, and there of its own scheme, policy and
    stiffness if possible: at S = 1 all of them are the same mill. Else that of another campaign.
    Else the largest mill (smallest S) of its own campaign. The first seed of each.
    """
    own = [other for other in charges if other.campaign == charge.campaign]
    physical = [other for other in charges if is_physical(other.S)]
    largest = [other for other in own if min(c.S for c in own) == other.S]

    def likeness(other: Charge) -> tuple:
        differs = [a != b for a, b in zip(other.model[:4], charge.model[:4], strict=True)]
        return *differs, other.case["seed"]

    best = min(physical or largest, key=likeness)
    return charge if best.model == charge.model else best


def pairs(charges: Sequence[Charge]) -> list[tuple[Charge, Charge]]:
    """Every two of some charges, once."""
    return [(a, b) for i, a in enumerate(charges) for b in charges[i + 1 :]]
