"""Outlines from few numbers: rows of lifters with faces of their own, waves and steps."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from millscale.errors import CampaignError
from millscale.liner.outline import Outline

# Outlines of this module are in the direction of rotation, counter-clockwise around the axis.


@dataclass(frozen=True)
class LifterRow:
    """A lifter with a flat top.

    Attributes:
        height: of the middle of the top above the liner [m].
        top_width: between the edges of the top, before they are rounded [m].
        leading_angle, trailing_angle: between a face and the lifter's centre line [rad].
        edge_radius: of both edges of the top; 0: sharp [m].
    """

    height: float
    top_width: float
    leading_angle: float
    trailing_angle: float
    edge_radius: float = 0.0


@dataclass(frozen=True)
class Corner:
    """A corner of an outline between straight lines.

    Attributes:
        point: (2,) float [m].
        radius: of the arc that rounds it; 0: sharp [m].
        bulge: of the piece that begins here, as in Outline.
    """

    point: np.ndarray
    radius: float = 0.0
    bulge: float = 0.0


def rows_outline(file: Path, radius: float, rows: Sequence[LifterRow], lifters: int) -> Outline:
    """Return one pitch of lifters that repeat in the order of the rows, in the direction of
    rotation.

    Raises:
        CampaignError: lifters that overlap, or rows that do not fit the number of lifters.
    """
    step = math.tau / lifters
    feet = [_feet(file, radius, row, f"row {i + 1}", step) for i, row in enumerate(rows)]
    corners: list[Corner] = []
    names: list[str] = []
    for i, row in enumerate(rows):
        place = i * step
        lead, trail = feet[i]
        trail_next = feet[(i + 1) % len(rows)][1]
        groove = step - lead - trail_next
        if groove <= 0.0:
            raise _refused(
                file,
                f"row {i + 1}",
                f"overlaps the next lifter at the foot by {-groove * radius:.3g} m",
                "fewer or narrower lifters, or smaller face angles",
            )
        half, top = 0.5 * row.top_width, radius - row.height
        corners += [
            Corner(radius * _on_circle(place - trail)),
            Corner(_local(top, -half, place), row.edge_radius),
            Corner(_local(top, half, place), row.edge_radius),
            Corner(radius * _on_circle(place + lead), bulge=math.tan(0.25 * groove)),
        ]
        names += [f"row {i + 1}"] * 4
    end = radius * _on_circle(len(rows) * step - feet[0][1])
    return _rounded(file, [*corners, Corner(end)], [*names, "row 1"])


def step_outline(
    file: Path, radius: float, height: float, face_angle: float, edge_radius: float, steps: int
) -> Outline:
    """Return one pitch of steps: a leading face, and a straight ramp up to the next edge.

    Args:
        face_angle: between the leading face and the radius through its edge [rad].
    """
    step = math.tau / steps
    foot = _foot(radius, radius - height, 0.0, face_angle)
    if foot >= step:
        raise _refused(
            file, "step", "the leading face reaches the next step", "fewer steps or a steeper face"
        )
    corners = [
        Corner(radius * _on_circle(foot - step)),
        Corner(_local(radius - height, 0.0, 0.0), edge_radius),
        Corner(radius * _on_circle(foot)),
    ]
    return _rounded(file, corners, ["step"] * 3)


def wave_outline(file: Path, radius: float, height: float, waves: int) -> Outline:
    """Return one pitch of a wave, from crest to crest: four arcs with smooth joints.

    Between crest and trough lie two arcs that touch, with tangents of equal length d: the joint is
    smooth if 2 (1 - t0 . t1) d^2 + 2 v . (t0 + t1) d = v . v, v being the chord and t0, t1 the unit
    tangents at its ends. Derived here.
    """
    half = math.pi / waves
    begin, end = np.array([radius - height, 0.0]), radius * _on_circle(half)
    into, out = np.array([0.0, 1.0]), np.array([-math.sin(half), math.cos(half)])
    chord, tangents = end - begin, into + out
    bend = 2.0 * (1.0 - float(into @ out))
    along = float(chord @ tangents)
    reach = (math.sqrt(along**2 + bend * float(chord @ chord)) - along) / bend
    joint = 0.5 * (begin + end + reach * (into - out))
    bulges = [_bulge_from(into, joint - begin), -_bulge_from(out, end - joint)]
    points = [begin, joint, end]
    mirror = np.array([[math.cos(2 * half), math.sin(2 * half)],
                       [math.sin(2 * half), -math.cos(2 * half)]])  # fmt: skip
    points += [mirror @ joint, mirror @ begin]
    return Outline(
        file=file,
        points=np.array(points),
        bulges=np.array([*bulges, bulges[1], bulges[0], 0.0]),
        names=("crest", "flank", "trough", "flank", "crest"),
        closed=False,
    )


def _bulge_from(tangent: np.ndarray, chord: np.ndarray) -> float:
    """Return the bulge of an arc that leaves along a tangent and ends at a chord's end."""
    sine = float(tangent[0] * chord[1] - tangent[1] * chord[0])
    return math.tan(0.5 * math.atan2(sine, float(tangent @ chord)))


def _feet(file: Path, radius: float, row: LifterRow, name: str, step: float) -> tuple[float, float]:
    """Return the angles from a lifter's centre line to the feet of its leading and its trailing
    face [rad]."""
    top, half = radius - row.height, 0.5 * row.top_width
    if top <= 0.0:
        raise _refused(file, name, f"height {row.height:g} m reaches the axis", f"< {radius:g} m")
    if math.hypot(top, half) >= radius:
        most = 2.0 * math.sqrt(radius**2 - top**2)
        cause = f"the top of {row.top_width:g} m leaves the liner's circle"
        raise _refused(file, name, cause, f"top width < {most:.4g} m at this height")
    lead = _foot(radius, top, half, row.leading_angle)
    trail = _foot(radius, top, half, row.trailing_angle)
    if lead + trail >= math.tau or max(lead, trail) >= math.pi:
        raise _refused(file, name, "wider than the mill", "a narrower lifter")
    return lead, trail


def _foot(radius: float, top: float, half: float, angle: float) -> float:
    """Return the angle from a centre line to where a face meets the liner's circle [rad].

    The face begins at (top, half), along and across the centre line.
    """
    c, s = math.cos(angle), math.sin(angle)
    projection = top * c + half * s
    length = -projection + math.sqrt(projection**2 + radius**2 - top**2 - half**2)
    return math.atan2(half + length * s, top + length * c)


def _on_circle(angle: float) -> np.ndarray:
    return np.array([math.cos(angle), math.sin(angle)])


def _local(along: float, across: float, angle: float) -> np.ndarray:
    """Return a point along and across a radius at a polar angle [m]."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([along * c - across * s, along * s + across * c])


def _rounded(file: Path, corners: Sequence[Corner], names: Sequence[str]) -> Outline:
    """Return the outline of corners, those with a radius as arcs that touch both lines."""
    points: list[np.ndarray] = []
    bulges: list[float] = []
    said: list[str] = []
    taken = [0.0] * len(corners)
    for i, corner in enumerate(corners):
        if corner.radius == 0.0:
            points.append(corner.point)
            bulges.append(corner.bulge)
            said.append(names[i])
            continue
        before, after = corner.point - corners[i - 1].point, corners[i + 1].point - corner.point
        lengths = float(np.linalg.norm(before)), float(np.linalg.norm(after))
        before, after = before / lengths[0], after / lengths[1]
        turn = math.atan2(float(before[0] * after[1] - before[1] * after[0]), float(before @ after))
        cut = corner.radius * math.tan(0.5 * abs(turn))
        free = min(lengths[0] - taken[i - 1], lengths[1])
        if cut > free * (1.0 + 1e-9):
            most = corner.radius * free / cut
            raise _refused(
                file,
                names[i],
                f"an edge radius of {corner.radius:g} m does not fit its top and faces",
                f"<= {most:.3g} m, or less if both edges of a top are rounded",
            )
        taken[i] = cut
        points += [corner.point - cut * before, corner.point + cut * after]
        bulges += [math.tan(0.25 * turn), 0.0]
        said += [names[i]] * 2
    return Outline(file, np.array(points), np.array(bulges), tuple(said), closed=False)


def _refused(file: Path, name: str, cause: str, accepted: str) -> CampaignError:
    return CampaignError(file, f"liner.{name}", cause, accepted)
