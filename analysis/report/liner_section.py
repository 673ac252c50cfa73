"""The section "Liner" of a report: loads on the liner of the charges that recorded them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from millscale.analysis.finished import Charge
from millscale.analysis.result_file import LinerLoadsResult
from millscale.analysis.wear.lifter_load import lifter_loads
from millscale.analysis.wear.loads import read_liner_loads
from millscale.analysis.wear.rate import LAWS, wear_rate
from millscale.report.figures.liner_loads import lifter_load_figure, load_map, wear_figure
from millscale.report.images import Image, save_image


@dataclass(frozen=True)
class LinerFigures:
    """Loads and figures of one charge."""

    id: str
    loads: LinerLoadsResult
    images: list[Image]

    @staticmethod
    def degrees(angle: float | None) -> float | None:
        """Return an angle in degrees."""
        return None if angle is None else math.degrees(angle)

    def percent(self, face: str) -> float | None:
        """Return the share of a face in the slip work [%]."""
        share = self.loads.slip_share[face]
        return None if share is None else 100.0 * share


def liner_section(charges: Sequence[Charge], to: Path) -> list[LinerFigures]:
    """Draw the loads on the liner of each charge that recorded them."""
    return [_figures(x, x.result.liner_loads, to) for x in charges if x.result.liner_loads]


def _figures(charge: Charge, result: LinerLoadsResult, to: Path) -> LinerFigures:
    loads = read_liner_loads(charge.folder, charge.case)
    images = [
        save_image(
            load_map(loads, charge.case),
            to / f"{charge.id}-liner-map.png",
            f"{charge.id}: normal force by arc length of a pitch and by place",
        )
    ]
    if lifters := lifter_loads(loads, charge.case):
        images.append(
            save_image(
                lifter_load_figure(lifters, charge),
                to / f"{charge.id}-lifter-load.png",
                f"{charge.id}: force on a lifter over a revolution",
            )
        )
    rates = [wear_rate(loads, charge.case, law) for law in LAWS]
    images.append(
        save_image(
            wear_figure(rates, loads.bins),
            to / f"{charge.id}-wear.png",
            f"{charge.id}: energy that wears the physical mill, along a pitch",
        )
    )
    return LinerFigures(charge.id, result, images)
