"""The classes of balls of a charge in tables, pictures and views: names, colours, segregation."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import to_hex

from millscale.analysis.finished import Charge
from millscale.report.figures.style import LIGHTEST
from millscale.runs.case_file import Balls


@dataclass(frozen=True)
class ClassLine:
    """A class of balls of a charge.

    Attributes:
        share, mass_share: of all balls, by number and by mass.
        segregation: radial index; None without dumps in the window of the means.
    """

    name: str
    colour: str
    balls: int
    share: float
    mass_kg: float
    mass_share: float
    segregation: float | None


def class_lines(charge: Charge) -> list[ClassLine]:
    """Return the classes of a charge; none if all its balls are of one."""
    ball = charge.case.ball
    names, colours = names_of_classes(ball), colours_of_classes(ball)
    volumes = [4.0 / 3.0 * math.pi * one.radius_m**3 for one in ball.classes]
    masses = [
        one.count * one.density_kg_m3 * volume
        for one, volume in zip(ball.classes, volumes, strict=True)
    ]
    indices = charge.result.segregation or (None,) * len(masses)
    return [
        ClassLine(name, colour, one.count, one.count / ball.count, mass, mass / sum(masses), index)
        for one, name, colour, mass, index in zip(
            ball.classes, names, colours, masses, indices, strict=True
        )
    ]


def names_of_classes(ball: Balls) -> list[str]:
    """Return the radius of each class, with its density if classes differ in it."""
    several = len({one.density_kg_m3 for one in ball.classes}) > 1
    return [
        f"{1e3 * one.radius_m:.4g} mm" + f", {one.density_kg_m3:.4g} kg/m³" * several
        for one in ball.classes
    ]


def colours_of_classes(ball: Balls) -> list[str]:
    """Return the colour of each class, from blue for the smallest balls to orange. Each has a
    contrast of 3 or more on white."""
    rank = np.argsort(np.argsort([one.radius_m for one in ball.classes], kind="stable"))
    return [to_hex(colormaps["plasma"](LIGHTEST * k / max(len(rank) - 1, 1))) for k in rank]
