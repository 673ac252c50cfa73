"""An outline of a liner: lines and arcs in the plane of a drawing, before any mill is known."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from millscale.errors import CampaignError

# Arc radius over the outline's size beyond which an arc is a line: its centre is lost to rounding.
STRAIGHT = 1e4
# Least sagitta of a chord over the radius of its arc.
FINEST = 1e-7
# Of the outline's size: points nearer to each other are one point.
SAME_POINT = 1e-9


@dataclass(frozen=True)
class Outline:
    """A chain of lines and arcs.

    Attributes:
        file: where the outline comes from, for messages.
        points: (n, 2) float, x to the right and y up [m]. Piece i begins at point i and ends at
            point i + 1; the last piece of a closed outline ends at point 0.
        bulges: (n,) float, tan(a / 4) of a piece that turns by the angle a, > 0 to the left; 0: a
            line. The last one of an open outline has no meaning.
        names: place of each point in the file, such as `row 12`.
        closed: the chain ends where it begins.
        unit: metres of a unit of the file.
    """

    file: Path
    points: np.ndarray
    bulges: np.ndarray
    names: tuple[str, ...]
    closed: bool
    unit: float = 1.0

    @property
    def pieces(self) -> int:
        return len(self.points) if self.closed else len(self.points) - 1

    @property
    def ends(self) -> np.ndarray:
        """Return where each piece ends, (pieces, 2) float [m]."""
        return np.roll(self.points, -1, axis=0)[: self.pieces]

    def place(self, index: int) -> str:
        """Return a point as the file names it, with its coordinates in the unit of the file."""
        x, y = (self.points[index] / self.unit).tolist()
        return f"{self.names[index]} (x = {x:.6g}, y = {y:.6g})"

    def refused(self, where: str, cause: str, accepted: str) -> CampaignError:
        """Return the error about a place of the file."""
        return CampaignError(self.file, where, cause, accepted)


def reversed_outline(outline: Outline) -> Outline:
    """Return the same lines and arcs, run through from the end to the beginning."""
    points, names = outline.points[::-1], outline.names[::-1]
    bulges = -outline.bulges[::-1]
    # Piece i of the result is piece n - 1 - i of a closed chain whose points are rolled by one.
    bulges = np.roll(bulges, -1) if outline.closed else np.append(bulges[1:], 0.0)
    return replace(outline, points=points, bulges=bulges, names=names)


def mirrored_outline(outline: Outline) -> Outline:
    """Return the outline mirrored at the x axis."""
    return replace(outline, points=outline.points * [1.0, -1.0], bulges=-outline.bulges)


def without_repeats(outline: Outline) -> Outline:
    """Return the outline without pieces of no length; an open chain that ends where it begins is
    closed."""
    size = float(np.abs(outline.points).max(initial=0.0))
    points, closed = outline.points, outline.closed
    apart = np.linalg.norm(np.diff(points, axis=0), axis=1) > SAME_POINT * size
    keep = np.append(apart, True)
    points, bulges = points[keep], outline.bulges[keep]
    names = tuple(name for name, kept in zip(outline.names, keep, strict=True) if kept)
    while len(points) > 1 and np.linalg.norm(points[-1] - points[0]) <= SAME_POINT * size:
        points, bulges, names, closed = points[:-1], bulges[:-1], names[:-1], True
    return replace(outline, points=points, bulges=bulges, names=names, closed=closed)


def without_flat_arcs(outline: Outline) -> Outline:
    """Return the outline with lines in place of arcs of almost no curvature."""
    size = float(np.abs(outline.points).max(initial=0.0))
    bulges = outline.bulges.copy()
    bulges[: outline.pieces][np.abs(arc_radii(outline)) > STRAIGHT * size] = 0.0
    return replace(outline, bulges=bulges)


def in_halves(outline: Outline) -> Outline:
    """Return the outline with every arc of more than half a turn cut into two."""
    points: list[np.ndarray] = []
    bulges: list[float] = []
    names: list[str] = []
    for i, (begin, bulge) in enumerate(zip(outline.points, outline.bulges.tolist(), strict=True)):
        points.append(begin)
        names.append(outline.names[i])
        if abs(bulge) <= 1.0 or i >= outline.pieces:
            bulges.append(bulge)
            continue
        half = math.tan(0.5 * math.atan(bulge))
        points.append(arc_middle(begin, outline.ends[i], bulge))
        names.append(outline.names[i])
        bulges += [half, half]
    return replace(outline, points=np.array(points), bulges=np.array(bulges), names=tuple(names))


def arc_middle(begin: np.ndarray, end: np.ndarray, bulge: float) -> np.ndarray:
    """Return the point in the middle of an arc [m]: bulge times half the chord to its right."""
    chord = end - begin
    middle: np.ndarray = 0.5 * (begin + end) + 0.5 * bulge * np.array([chord[1], -chord[0]])
    return middle


def arc_radii(outline: Outline) -> np.ndarray:
    """Return the radius of each piece, (pieces,) float [m]; > 0: it turns left; 0: a line."""
    b = outline.bulges[: outline.pieces]
    chord = np.linalg.norm(outline.ends - outline.points[: outline.pieces], axis=1)
    radii = np.zeros(len(b))
    np.divide(chord * (1.0 + b * b), 4.0 * b, out=radii, where=b != 0.0)
    return radii


def flattened(outline: Outline, error: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the outline as a chain of points with chords in place of arcs.

    Args:
        error: largest distance of a chord from its arc [m].

    Returns:
        Points (m, 2) float [m], of a closed outline without its first point again, and the piece
        that each point belongs to, (m,) int.
    """
    points: list[np.ndarray] = []
    owners: list[int] = []
    radii = np.abs(arc_radii(outline))
    for i in range(outline.pieces):
        begin, end, bulge = outline.points[i], outline.ends[i], float(outline.bulges[i])
        points.append(begin)
        owners.append(i)
        if bulge == 0.0:
            continue
        angle = 4.0 * math.atan(abs(bulge))
        sagitta = max(error / float(radii[i]), FINEST)
        step = 2.0 * math.acos(max(0.0, 1.0 - sagitta))
        count = max(2, math.ceil(angle / step))
        inner = arc_points(begin, end, bulge, np.arange(1, count) / count)
        points += list(inner)
        owners += [i] * len(inner)
    if not outline.closed:
        points.append(outline.points[-1])
        owners.append(outline.pieces - 1)
    return np.array(points), np.array(owners)


def arc_points(begin: np.ndarray, end: np.ndarray, bulge: float, shares: np.ndarray) -> np.ndarray:
    """Return the points at shares of an arc's angle, (m, 2) float [m]."""
    chord = end - begin
    angle = 4.0 * math.atan(bulge)
    # From the chord's middle to the centre, to the left of the chord, in chord lengths.
    to_centre = 0.5 / math.tan(0.5 * angle)
    centre = 0.5 * (begin + end) + to_centre * np.array([-chord[1], chord[0]])
    arm = begin - centre
    c, s = np.cos(angle * shares), np.sin(angle * shares)
    return centre + np.column_stack([arm[0] * c - arm[1] * s, arm[0] * s + arm[1] * c])


def check_no_crossing(outline: Outline, error: float) -> None:
    """Refuse an outline that crosses or touches itself.

    Args:
        error: of chords that stand for arcs [m].

    Raises:
        CampaignError: names both pieces.
    """
    from shapely import STRtree, linestrings

    points, owners = flattened(outline, error)
    ends = np.roll(points, -1, axis=0)
    if not outline.closed:
        points, ends, owners = points[:-1], ends[:-1], owners[:-1]
    segments = linestrings(np.stack([points, ends], axis=1))
    one, other = STRtree(segments).query(segments, predicate="intersects")
    apart = other - one
    beyond = len(points) - 1 if outline.closed else len(points) + 1
    found = np.flatnonzero((apart > 1) & (apart < beyond))
    # Neighbours share an end; more than that is a piece that runs back on itself.
    along, onwards = ends - points, np.roll(ends - points, -1, axis=0)
    turned = along[:, 0] * onwards[:, 1] - along[:, 1] * onwards[:, 0]
    size = np.linalg.norm(along, axis=1) * np.linalg.norm(onwards, axis=1)
    back = (np.abs(turned) <= 1e-9 * size) & ((along * onwards).sum(axis=1) < 0.0)
    if not outline.closed:
        back[-1] = False
    if len(found):
        first = found[np.lexsort((other[found], one[found]))[0]]
        pair = int(owners[one[first]]), int(owners[other[first]])
    elif back.any():
        i = int(np.flatnonzero(back)[0])
        pair = int(owners[i]), int(owners[(i + 1) % len(owners)])
    else:
        return
    raise outline.refused(
        outline.place(pair[0]),
        f"the outline crosses or touches itself: the piece from here and the piece from "
        f"{outline.place(pair[1])}",
        "a line around the cavity that never crosses itself; points in order along the liner",
    )


def joined(outlines: Sequence[Outline]) -> Outline:
    """Return open outlines, each of which begins where the one before ends, as one open outline."""
    points = [part.points[:-1] for part in outlines] + [outlines[-1].points[-1:]]
    bulges = [part.bulges[:-1] for part in outlines] + [np.zeros(1)]
    names = [name for part in outlines for name in part.names[:-1]] + [outlines[-1].names[-1]]
    return replace(
        outlines[0],
        points=np.concatenate(points),
        bulges=np.concatenate(bulges),
        names=tuple(names),
        closed=False,
    )
