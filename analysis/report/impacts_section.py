"""The section "Impacts" of a report: spectra of the charges that recorded their contacts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from millscale.analysis.charge.impacts import Collapse, collapses
from millscale.analysis.finished import Charge
from millscale.analysis.result_file import ImpactsResult
from millscale.report.figures.impacts import collapse_figure, impacts_figure
from millscale.report.images import Image, save_image


@dataclass(frozen=True)
class ImpactFigures:
    """Impacts and the figure of one charge.

    Attributes:
        tonnes: mass of the balls [t].
    """

    id: str
    result: ImpactsResult
    tonnes: float
    image: Image


@dataclass(frozen=True)
class ImpactsSection:
    """What the section shows.

    Attributes:
        collapse: spectra of all charges over m (omega R)^2; None of one value of S.
        compared: scaled mills beside the mill of the smallest S.
    """

    charges: tuple[ImpactFigures, ...]
    collapse: Image | None
    compared: tuple[Collapse, ...]


def impacts_section(charges: Sequence[Charge], to: Path) -> ImpactsSection | None:
    """Draw the impacts of the charges that recorded them; None if none did."""
    kept = [charge for charge in charges if charge.result.impacts is not None]
    if not kept:
        return None
    compared = collapses(kept)
    several = save_image(
        collapse_figure(kept),
        to / "impacts.png",
        "dissipated energy by the energy of a contact, of all scaled mills",
    )
    return ImpactsSection(
        tuple(_figures(charge, to) for charge in kept), several if compared else None, compared
    )


def _figures(charge: Charge, to: Path) -> ImpactFigures:
    result = charge.result.impacts
    assert result is not None
    tonnes = 1e-3 * charge.balls * charge.case.ball.mass_kg
    image = save_image(
        impacts_figure(result, tonnes),
        to / f"{charge.id}-impacts.png",
        f"{charge.id}: power of the contacts by their energy",
    )
    return ImpactFigures(charge.id, result, tonnes, image)
