"""A row for each charge: what it is, what it is compared with, how far it is from that."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from millscale.analysis.charge.measured import Measured
from millscale.analysis.charge.pair_errors import PairErrors, mean_of_pairs, no_errors
from millscale.analysis.charge.scaled_mills import Charges, ScaledMill
from millscale.analysis.finished import Charge
from millscale.analysis.means import deviation
from millscale.analysis.measures import ERRORS
from millscale.analysis.shapes.shape import Shape, contour_grid

SERIES_COLUMNS = ("box_fixed_mass_fraction",)


@dataclass(frozen=True)
class ChargeRow:
    """A charge against its reference.

    Attributes:
        mill: all seeds of its scaled mill.
        numbers: of `measures.NUMBERS`, by name.
        shape: at the last mill angle of the comparison; None without a dump there.
        seed_spread: standard deviation over the seeds of each error, and of power_W; None for one
            seed.
        between_seeds: errors of the seeds against one another, in the mean over the pairs. An error
            no larger than these may be chance. Of a mill with one seed they are those of `lender`.
        lender: the scaled mill whose seeds they are of; None if no mill has several.
        not_measured: what the row lacks, and why.
    """

    charge: Charge
    reference: Charge
    mill: ScaledMill
    errors: PairErrors
    numbers: Mapping[str, float | None]
    shape: Shape | None
    seed_spread: Mapping[str, float | None] | None
    between_seeds: PairErrors | None
    lender: ScaledMill | None
    not_measured: tuple[str, ...]

    @property
    def is_reference(self) -> bool:
        return self.reference is self.charge

    @property
    def length_share(self) -> float:
        """Return the simulated length over that of the scaled mill: below 1 in a slice."""
        mill = self.charge.case.mill
        return mill.simulated_length_m / mill.length_m

    @property
    def speed_up(self) -> float | None:
        """Return the time of the reference over its own; None if their ranks differ.

        Processor time, which a shared machine lengthens less than wall time, where both have it.
        """
        ours, theirs = self.charge.timing, self.reference.timing
        if ours.ranks != theirs.ranks:
            return None
        if ours.processor_time_s and theirs.processor_time_s:
            return theirs.processor_time_s / ours.processor_time_s
        return theirs.wall_time_s / ours.wall_time_s

    def document(self) -> dict[str, Any]:
        """Return the row of results.json; keys and units: docs/reference/files.md."""
        charge, reference, settled = self.charge, self.reference, self.charge.settled
        return {
            **{key: getattr(charge, key) for key in ("campaign", "id", "scheme", "policy", "S")},
            **({"state": charge.state} if charge.state else {}),
            "seed": charge.seed,
            "stiffness": charge.stiffness,
            "balls": charge.balls,
            "total_mass_kg": charge.mass,
            "balls_per_length_scaled_1_m": charge.balls_per_length_scaled,
            "simulated_length_m": charge.case.mill.simulated_length_m,
            "length_share": self.length_share,
            "reference": reference.id,
            "reference_campaign": reference.campaign,
            "reference_S": reference.S,
            "is_reference": self.is_reference,
            "wall_time_s": charge.timing.wall_time_s,
            "processor_time_s": charge.timing.processor_time_s,
            "ranks": charge.timing.ranks,
            "speed_up": self.speed_up,
            "power_W": charge.result.mean["power_W"],
            "power_dimensionless": charge.result.dimensionless["power"],
            "max_overlap": charge.result.largest_overlap_over_radius,
            "toe_angle_rad": self.numbers["toe_angle_rad"],
            "shoulder_angle_rad": self.numbers["shoulder_angle_rad"],
            "numbers": dict(self.numbers),
            "settled": {
                "largest_overlap_over_radius": settled.largest_overlap_over_radius,
                "bulk_fraction": settled.bulk_fraction,
            },
            "contour_resolution": contour_grid(charge.case).resolution,
            **self._of_shape(),
            **self.errors.document(),
            "seeds": len(self.mill.seeds),
            "seed_spread": self.seed_spread,
            "between_seeds": self.between_seeds and self.between_seeds.document(),
            "between_seeds_of": self.lender and self.lender.first.id,
            "not_measured": list(self.not_measured),
        }

    def _of_shape(self) -> dict[str, Any]:
        """Return the numbers of the last shape: distance of the surfaces by two methods,
        curtains."""
        if self.shape is None:
            return {"bulk_fraction": None, "contour_second_method": None, "curtains": None}
        curtains = None
        if self.shape.curtains is not None:
            curtains = {
                str(n): {"lifter": c.lifter, "balls": len(c.centres), "width": c.width}
                for n, c in self.shape.curtains.items()
            }
        return {
            "bulk_fraction": self.shape.contour.bulk_fraction,
            "contour_second_method": self.shape.method_distance,
            "curtains": curtains,
        }


def charge_rows(charges: Charges, measured: Measured) -> list[ChargeRow]:
    """Return a row for each charge, in their order."""
    errors = {charge: _errors(charge, charges, measured) for charge in charges}
    return [_row(charge, charges, measured, errors) for charge in charges]


def between_seeds(mill: ScaledMill, measured: Measured) -> PairErrors:
    """Return the errors of the seeds of a mill against one another, mean over the pairs."""
    return mean_of_pairs([measured.errors[pair] for pair in mill.pairs()])


def _errors(charge: Charge, charges: Charges, measured: Measured) -> PairErrors:
    pair = charge, charges.reference_of(charge)
    if pair in measured.errors:
        return measured.errors[pair]
    has_shape = measured.last_shape(charge) is not None
    return no_errors(max(measured.shapes, default=None) if has_shape else None)


def _row(
    charge: Charge, charges: Charges, measured: Measured, errors: Mapping[Charge, PairErrors]
) -> ChargeRow:
    mill, lender = charges.mill_of(charge), charges.with_seeds_near(charge)
    shape = measured.last_shape(charge)
    return ChargeRow(
        charge=charge,
        reference=charges.reference_of(charge),
        mill=mill,
        errors=errors[charge],
        numbers=measured.numbers[charge],
        shape=shape,
        seed_spread=_seed_spread(mill, errors) if len(mill.seeds) > 1 else None,
        between_seeds=between_seeds(lender, measured) if lender else None,
        lender=lender,
        not_measured=(
            *_not_measured(charge, shape),
            *(str(problem) for problem in measured.problems[charge]),
        ),
    )


def _seed_spread(mill: ScaledMill, errors: Mapping[Charge, PairErrors]) -> dict[str, float | None]:
    spread = {
        error.name: deviation([errors[seed].values[error.name] for seed in mill.seeds])
        for error in ERRORS
        if not error.by_curtain
    }
    return spread | {"power_W": deviation([seed.result.mean["power_W"] for seed in mill.seeds])}


def _not_measured(charge: Charge, shape: Shape | None) -> list[str]:
    """Return what a row lacks, and why."""
    lacks = []
    if shape is None:
        lacks.append("contour, curtains: no dump at the mill angle at which shapes are compared")
    elif shape.curtains is None:
        lacks.append(f"curtains: {shape.problem}")
    absent = [name for name in SERIES_COLUMNS if not charge.has(name)]
    if absent:
        lacks.append(f"series.csv has no column {', '.join(absent)}")
    return lacks
