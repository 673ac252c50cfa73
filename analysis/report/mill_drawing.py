"""The drawing of a mill on the first screen: liner, surface of the charge, toe and impact point."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from millscale.analysis.charge.comparison import ChargeComparison
from millscale.analysis.charge.scaled_mills import ScaledMill
from millscale.analysis.shapes.cross_section import liner_outline
from millscale.analysis.shapes.shape import Shape, end_circle
from millscale.runs.case_file import Case

SIZE = 100.0  # of the mill radius in the drawing


@dataclass(frozen=True)
class Mark:
    """A labelled point of the drawing; `dx` and `anchor` place the label."""

    name: str
    label: str
    x: float
    y: float
    dx: float
    anchor: str


@dataclass(frozen=True)
class MillDrawing:
    """Paths of an SVG drawing, and what it shows."""

    liner: str
    surface: list[str]
    marks: list[Mark]
    caption: str


def mill_drawing(
    case: Case, comparison: ChargeComparison | None = None, mill: ScaledMill | None = None
) -> MillDrawing:
    """Return the drawing of the liner of a case; with a finished charge also its surface, at the
    last mill angle of the comparison."""
    shape = None
    if comparison and mill:
        shape = comparison.measured.last_shape(mill.first)
    if shape is None:
        outline = liner_outline(case, 0.0) / case.mill.radius_m
        return MillDrawing(
            _path(outline), [], [], "Liner, along the axis. The mill turns clockwise."
        )
    assert mill is not None
    caption = (
        f"{mill.first.id} at {shape.mill_angle:.2f} rad: liner and surface of the charge, along "
        f"the axis. The mill turns clockwise. {mill.first.balls:,} balls, seed {mill.first.seed}."
    )
    return MillDrawing(
        _path(shape.outline),
        [_path(line) for line in shape.contour.lines],
        _marks(shape, end_circle(case)),
        caption,
    )


def _marks(shape: Shape, radius: float) -> list[Mark]:
    known = [("landing", "impact", shape.landing_angle)]
    if shape.ends:
        known += [("toe", "toe", shape.ends.toe), ("shoulder", "shoulder", shape.ends.shoulder)]
    found = []
    for name, label, angle in known:
        if angle is not None:
            x, y = -np.sin(angle) * radius * SIZE, -np.cos(angle) * radius * SIZE
            found.append(
                Mark(name, label, x, y, -7.0 if x > 0.0 else 7.0, "end" if x > 0 else "start")
            )
    return found


def _path(points: Sequence | np.ndarray) -> str:
    """Return the path of points [x, z], z up, in the coordinates of an SVG."""
    return "M" + "L".join(f"{SIZE * x:.1f} {-SIZE * z:.1f}" for x, z in points)
