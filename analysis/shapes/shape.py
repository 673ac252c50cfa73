"""Contours and curtains of a multi-ball case at given mill angles, from its dumps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from millscale import _core
from millscale.analysis.shapes.comparison import points_along
from millscale.analysis.shapes.contour import Contour, first_gaps, surface_contour
from millscale.analysis.shapes.cross_section import liner_outline
from millscale.analysis.shapes.curtain import (
    IN_FLIGHT,
    Curtain,
    Lifters,
    curtains,
    longest_flight,
    may_have_thrown,
)
from millscale.analysis.shapes.landing import landing_angle
from millscale.analysis.shapes.snapshots import Snapshot, snapshots_near
from millscale.analysis.shapes.solid_fraction import RESOLUTION, Grid, value_at
from millscale.analysis.shapes.surface_ends import SurfaceEnds, surface_ends
from millscale.analysis.shapes.throw_angle import throw_angle
from millscale.runs.case_file import Case, Mill, PhysicalMill
from millscale.runs.dumps import Dump
from millscale.runs.liner import liner_of
from millscale.runs.untrusted import RunFolderError

ANGLE_STEP = 0.5  # between the mill angles at which shapes are compared [rad]
SAME_ANGLE = 0.02  # dumps this close are at the same mill angle [rad]; a pitch is 0.25
KERNEL_OVER_BALL_RADIUS = 1.5  # smallest: single balls show under a narrower kernel
# Radius of the circle of toe and shoulder over that of the lifter tops. Nearer to the tops, the
# surface is that of the balls on the lifters: docs/results/observable-definitions.md.
END_CIRCLE = 0.9
STATE, LAST_LIFTER = (
    "c_detach[1]",
    "c_detach[24]",
)  # of compute mill/detach: docs/reference/styles/compute-mill-detach.md


@dataclass(frozen=True)
class Shape:
    """Shape of a charge at one mill angle; lengths over R - a.

    Attributes:
        mill_angle: of the dump [rad].
        outline: (n, 2) float, the liner at this mill angle.
        cross_check: (n, 2) float, the surface by the second method.
        curtains: by number; None if the dumps lack the columns, or the mill lifters.
        problem: why there are no curtains.
        curtain_share: balls of all curtains over all balls; None if there are no curtains.
        ends: toe and shoulder; None if the surface does not reach their circle.
        throw_angle: of `throw_angle.throw_angle` [rad]; None if too few balls are in flight.
        landing_angle: of `landing.landing_angle` [rad]; None as the throw angle.
    """

    mill_angle: float
    outline: np.ndarray
    contour: Contour
    cross_check: np.ndarray
    curtains: dict[int, Curtain] | None
    problem: str
    curtain_share: float | None = None
    ends: SurfaceEnds | None = None
    throw_angle: float | None = None
    landing_angle: float | None = None

    @property
    def curtain_width(self) -> float | None:
        """Return the root mean square width of the curtains; None without curtains."""
        if not self.curtains:
            return None
        balls = [len(curtain.centres) for curtain in self.curtains.values()]
        squares = [curtain.width**2 for curtain in self.curtains.values()]
        return float(np.sqrt(np.average(squares, weights=balls)))

    @property
    def method_distance(self) -> float | None:
        """Return the median distance of the second method's surface from the contour."""
        if not self.contour.lines or not len(self.cross_check):
            return None
        tree = cKDTree(points_along(self.contour.lines))
        return float(np.median(tree.query(self.cross_check)[0]))


def unit_length(case: Case) -> float:
    """Return R - a of the mean ball [m]."""
    return case.mill.radius_m - case.ball.radius_m


def physical_unit_length(case: Case) -> float:
    """Return R - a of the physical mill and its mean ball [m]."""
    return case.physical.radius_m - case.physical.ball_radius_m


def contour_grid(case: Case) -> Grid:
    """Return the grid of a case's contours: as fine as RESOLUTION unless its balls are too
    large."""
    radius = case.ball.radius_m / unit_length(case)
    return Grid(max(RESOLUTION, KERNEL_OVER_BALL_RADIUS * radius))


def end_circle(case: Case) -> float:
    """Return the radius of the circle of toe and shoulder over R - a: that of the physical mill,
    for all its scaled mills."""
    return (
        END_CIRCLE
        * _innermost(case.physical)
        / (case.physical.radius_m - case.physical.ball_radius_m)
    )


def wanted_angles(end: float) -> list[float]:
    """Return the mill angles at which shapes are compared: every ANGLE_STEP to the end of the
    rotation [rad]."""
    return [ANGLE_STEP * i for i in range(1, int((end + SAME_ANGLE) / ANGLE_STEP) + 1)]


def snapshots_at(folder: Path, mill_angles: Sequence[float]) -> dict[float, Snapshot]:
    """Return the dumps of a case folder by wanted mill angle [rad], where it has one.

    Raises:
        RunFolderError: no dumps at all.
    """
    if not mill_angles:
        return {}
    found = {}
    for snapshot in snapshots_near(folder, mill_angles):
        wanted = min(mill_angles, key=lambda angle: abs(angle - snapshot.mill_angle))
        if abs(snapshot.mill_angle - wanted) <= SAME_ANGLE:
            found[wanted] = snapshot
    return found


def shape_of(dump: Dump, snapshot: Snapshot, case: Case) -> Shape:
    """Return the shape of one dump."""
    unit, mill = unit_length(case), case.mill
    length = mill.simulated_length_m / unit
    places = dump.positions / unit
    areas = 4.0 / 3.0 * np.pi * (dump["radius"] / unit) ** 3 / length
    outline = liner_outline(case, snapshot.mill_angle) / unit
    grid = contour_grid(case)
    try:
        contour = surface_contour(places[:, [0, 2]], areas, outline, grid)
    except ValueError as error:
        raise RunFolderError(snapshot.path, str(error), "look at it in OVITO") from None
    ball, tops = case.ball.radius_m / unit, _innermost(mill) / unit
    problem = _no_curtains(dump, mill)
    found, share = None, None
    if not problem:
        found, share = _curtains(dump, places[:, [0, 2]], contour, snapshot.mill_angle, case)
    second = first_gaps(places, ball, length, tops)
    circle = end_circle(case)
    return Shape(
        mill_angle=snapshot.mill_angle,
        outline=outline,
        contour=contour,
        cross_check=second,
        curtains=found,
        problem=problem,
        curtain_share=share,
        ends=surface_ends(contour, grid, circle),
        throw_angle=throw_angle(dump, case, circle * unit),
        landing_angle=landing_angle(dump, case, circle * unit),
    )


def _innermost(mill: Mill | PhysicalMill) -> float:
    return mill.lifter_top_radius_m if mill.lifters else mill.radius_m


def _no_curtains(dump: Dump, mill: Mill) -> str:
    """Return why a dump has no curtains; empty if it has."""
    missing = [name for name in (STATE, LAST_LIFTER) if name not in dump.columns]
    if missing:
        return (
            f"the dumps have no column {', '.join(missing)}: written before dumps named the "
            "lifter that carried a ball last; run the case again"
        )
    return "" if mill.lifters else "a plain drum has no lifters"


def _curtains(
    dump: Dump, centres: np.ndarray, contour: Contour, mill_angle: float, case: Case
) -> tuple[dict[int, Curtain], float]:
    """Return curtains by number, and the share of all balls that is in curtains."""
    lifters, lifter = _lifters(case), dump[LAST_LIFTER]
    flying = (dump[STATE] == IN_FLIGHT) & (lifter >= 0.0)
    flying &= may_have_thrown(lifter, lifters, mill_angle, longest_flight(case.mill.froude))
    flying &= ~value_at(contour.inside, centres, contour_grid(case))
    found = curtains(centres[flying], lifter[flying], lifters, mill_angle)
    return {curtain.number: curtain for curtain in found}, float(flying.mean())


def _lifters(case: Case) -> Lifters:
    """Return the lifters of a case. Curtains are numbered from the angle at which a ball leaves the
    physical mill by Eq. 4, so a policy that corrects the speed changes no number."""
    mill, physical = case.mill, case.physical
    froude = physical.omega_rad_s**2 * physical.radius_m / physical.gravity_m_s2
    first = _core.detach_angle(froude) if froude < 1.0 else 0.0
    if mill.profile is None:
        return Lifters(mill.lifters, mill.phase_rad, first)
    angles = tuple(liner_of(mill).lifter_angles.tolist())
    return Lifters(len(angles), mill.phase_rad, first, angles)
