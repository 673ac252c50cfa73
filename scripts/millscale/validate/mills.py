"""Physical mills in runs folders: their runs of S = 1 and their scaled mills, measured."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

from millscale.analysis.charge.measured import measure
from millscale.analysis.finished import Charge
from millscale.errors import PredictionError
from millscale.prediction.extrapolation import by_ratio
from millscale.prediction.observables import OBSERVABLES, Observable
from millscale.prediction.selection import by_physical_mill, usable_charges
from millscale.runs.untrusted import RunFolderError

# Observables that are another one in another unit, such as torque and power, count once.
COUNTED = tuple(row for row in OBSERVABLES if not row.restates)


class Scaling(NamedTuple):
    """How a scaled mill follows from the physical mill."""

    scheme: str
    policy: str


@dataclass(frozen=True)
class Mill:
    """A physical mill and its steady charges.

    Attributes:
        charges: by S, then seed; all schemes and policies.
        values: of each charge, by the name of `measures.NUMBERS`.
    """

    charges: tuple[Charge, ...]
    values: Mapping[Charge, Mapping[str, float | None]]

    @cached_property
    def physical(self) -> tuple[Charge, ...]:
        """Return the charges of S = 1, where all schemes and policies are one mill."""
        return tuple(charge for charge in self.charges if charge.case.is_physical)

    @cached_property
    def scaled(self) -> dict[Scaling, dict[float, tuple[Charge, ...]]]:
        """Return the charges of the scaled mills by scaling and S, in rising order of S."""
        found: dict[Scaling, list[tuple[float, Charge]]] = {}
        for charge in self.charges:
            if not charge.case.is_physical:
                scaling = Scaling(charge.scheme, charge.policy)
                found.setdefault(scaling, []).append((charge.S, charge))
        return {
            scaling: {S: tuple(seeds) for S, seeds in by_ratio(charges)}
            for scaling, charges in sorted(found.items())
        }

    @property
    def name(self) -> str:
        """Return the name of the campaign of S = 1, or of the first charge without one."""
        return (self.physical or self.charges)[0].campaign

    @property
    def description(self) -> str:
        """Return size, lifters, ball size and speed."""
        mill = self.charges[0].case.physical
        froude = mill.omega_rad_s**2 * (mill.radius_m - mill.ball_radius_m) / mill.gravity_m_s2
        return (
            f"{2.0 * mill.radius_m:.3g} m, {mill.lifters} lifters, "
            f"R / a = {mill.radius_m / mill.ball_radius_m:.3g}, "
            f"{100.0 * math.sqrt(froude):.0f} % of critical"
        )

    @property
    def length_share(self) -> float:
        """Return the simulated length of S = 1 over that of the whole mill."""
        mill = self.physical[0].case.mill
        return mill.simulated_length_m / mill.length_m

    def value(self, row: Observable, charge: Charge) -> float | None:
        """Return the dimensionless number of an observable in a charge."""
        return row.read(charge, self.values[charge])

    def physical_value(self, row: Observable) -> float | None:
        """Return the number of an observable at S = 1, in the mean over its charges."""
        known = [x for charge in self.physical if (x := self.value(row, charge)) is not None]
        return math.fsum(known) / len(known) if known else None


def load_mills(folders: Sequence[Path], every: bool = False) -> tuple[list[Mill], dict[str, str]]:
    """Return the physical mills of runs folders that have a run of S = 1, and what is not used.

    Args:
        every: use all finished charges, also those that a prediction refuses.

    Returns:
        The mills; why charges are not used, by folder and id.

    Raises:
        PredictionError: no mill has both a finished, steady run of S = 1 and one of a scaled mill.
        RunFolderError: a folder holds no campaign, or a damaged one.
    """
    charges: list[Charge] = []
    excluded: dict[str, str] = {}
    for folder in folders:
        found, unused = usable_charges([folder], every)
        charges += found
        excluded |= {f"{folder.name}/{name}": why for name, why in unused.items()}
    charges.sort(key=lambda charge: (charge.S, charge.seed))
    values = measure(charges, []).numbers
    mills = [Mill(tuple(group), values) for group in by_physical_mill(charges)]
    complete = [mill for mill in mills if mill.physical and mill.scaled]
    if not complete:
        raise PredictionError(
            "no mill has both a finished, steady run of S = 1 and one of a scaled mill: "
            "millscale status DIR shows which are missing"
        )
    for mill in mills:
        if mill not in complete:
            lacks = "scaled mill" if mill.physical else "run of S = 1"
            for charge in mill.charges:
                name = f"{charge.folder.parents[1].name}/{charge.id}"
                excluded[name] = f"no {lacks} of its mill"
    return sorted(complete, key=lambda mill: mill.name), excluded


def processor_time(charge: Charge) -> float:
    """Return the processor time of settling and rotation [s]."""
    settled, rotated = charge.settled.processor_time_s, charge.timing.processor_time_s
    if settled is None or rotated is None:
        raise RunFolderError(charge.folder, "its processor time is not known", "run it again")
    return settled + rotated


def mean_time(charges: Sequence[Charge]) -> float:
    """Return the processor time of one of several charges, in their mean [s]."""
    return math.fsum(map(processor_time, charges)) / len(charges)
