"""The outline of a liner after wear: every point of its surface worn by a depth of its own."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from millscale import _core
from millscale.errors import CampaignError
from millscale.liner.outline import Outline, flattened
from millscale.liner.sector import COUNTER, Placing, profile_of, reach, rotated

# Relative to the radius: chords that stand for arcs, and points that are left out of a result.
CHORD_ERROR = 1e-5
THINNED = 4e-6
# A shorter side between two corners, of at least this turn [rad], is a fillet: it would count as a
# groove.
SHORTEST, TURN = 6e-4, 0.25
# Samples of the surface in a smoothing width, at least.
FINEST = 4
MOST_SAMPLES = 1000
# Shares of the height between which the angle of a face is taken.
FACE = (0.2, 0.8)
# Of more sectors, five stand for all.
FEWEST_OPEN = 8
# Relative to the radius: a liner that is nowhere higher has no lifter.
LEAST_HEIGHT = 1e-3
WORN = Path("worn profile")


@dataclass(frozen=True)
class Wear:
    """Depths of wear along a pitch.

    Attributes:
        edges: (bins + 1,) float, arc length over that of a pitch, from its first node.
        depth: (bins,) float, >= 0 [m].
        smoothing: standard deviation of the Gaussian that smooths the depth along the arc [m].
        plate: thickness behind the largest distance of the liner from the axis, beyond which
            nothing is left to wear; None: not limited [m].
    """

    edges: np.ndarray
    depth: np.ndarray
    smoothing: float
    plate: float | None = None


@dataclass(frozen=True)
class Worn:
    """A worn liner.

    Attributes:
        outline: one pitch in the direction of rotation, x along the middle of a groove.
        radius: largest distance from the axis [m].
        height: of the lifters, largest less smallest distance from the axis [m].
        leading_angle: of the leading face of the highest lifter, between `FACE` of its height,
            from the radius through the middle of the pitch; nan of a drum [rad].
        removed: area of a pitch that is worn off [m^2].
        deepest: of the smoothed depths [m].
        is_through: whether the plate is worn through somewhere.
    """

    outline: Outline
    radius: float
    height: float
    leading_angle: float
    removed: float
    deepest: float
    is_through: bool

    @property
    def profile(self) -> _core.Profile:
        """Return the liner, as a campaign reads it from the file."""
        return profile_of(self.outline, Placing(self.radius, turns=COUNTER))[0]

    def text(self, about: str) -> str:
        """Return the file that `[liner] profile` of a campaign names.

        Args:
            about: one line.
        """
        rows = "".join(f"{x:.9g},{y:.9g}\n" for x, y in self.outline.points.tolist())
        return (
            f"# {about}\n# [mill] radius_m = {self.radius:.9g}\n"
            f'# [liner] turns = "{COUNTER}"\nx_m,y_m\n{rows}'
        )


def worn_liner(liner: _core.Profile, wear: Wear) -> Worn:
    """Return a liner after wear.

    The surface moves into the liner as a front: what is left is what no point of the surface
    reaches within its depth. So a lifter's edge is worn from both faces, the surface never crosses
    itself, and nothing is left of a lifter that both faces wear through. Derived here.

    Raises:
        CampaignError: no liner is left.
    """
    from shapely import MultiPoint, Polygon, unary_union
    from shapely.geometry import Point

    chain, depth = _samples(liner, wear)
    whole = liner.sectors < FEWEST_OPEN
    pitches = range(liner.sectors) if whole else range(-2, 3)
    points = np.concatenate([rotated(chain[:-1], k * liner.pitch) for k in pitches])
    depths = np.tile(depth[:-1], len(pitches))
    axis = np.zeros((0 if whole else 1, 2))
    grown = [Polygon(np.vstack([points, axis]))]
    discs = [
        np.array(Point(p).buffer(max(h, 1e-12), quad_segs=16).exterior.coords)
        for p, h in zip(points, depths, strict=True)
    ]
    following = [*discs[1:], discs[0]] if whole else discs[1:]
    for one, other in zip(discs, following, strict=False):
        grown.append(MultiPoint(np.vstack([one, other])).convex_hull)
    worn = unary_union(grown)
    is_through = False
    if wear.plate is not None:
        shell = Point(0.0, 0.0).buffer(liner.radius + wear.plate, quad_segs=4096)
        is_through = not shell.buffer(1e-9 * liner.radius).contains(worn)
        worn = worn.intersection(shell)
    outline = _pitch_of(worn, liner)
    low, high = reach(outline)
    return Worn(
        outline=outline,
        radius=high,
        height=high - low,
        leading_angle=_leading_angle(outline, liner.pitch),
        removed=_area(outline) - liner.area / liner.sectors,
        deepest=float(depth.max()),
        is_through=is_through,
    )


def _samples(liner: _core.Profile, wear: Wear) -> tuple[np.ndarray, np.ndarray]:
    """Return points along a pitch, the last one of the next pitch, (n + 1, 2), and the smoothed
    depth at each, (n + 1,) [m]."""
    flat, _ = flattened(outline_of(liner), CHORD_ERROR * liner.radius)
    steps = np.linalg.norm(np.diff(flat, axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(steps)])
    length = float(along[-1])
    width = 0.5 * float(np.diff(wear.edges).min()) * length
    if wear.smoothing > 0.0:
        width = min(width, wear.smoothing / FINEST)
    count = min(MOST_SAMPLES, math.ceil(length / width))
    even = np.linspace(0.0, length, count + 1)
    at = np.union1d(even, along)
    points = np.column_stack([np.interp(at, along, flat[:, k]) for k in (0, 1)])
    middles = 0.5 * (wear.edges[1:] + wear.edges[:-1])
    share = (even[:-1] + 0.5 * length / count) / length
    bin_of = np.clip(np.searchsorted(wear.edges, share, side="right") - 1, 0, len(middles) - 1)
    smooth = _smoothed(wear.depth[bin_of], wear.smoothing / (length / count))
    return points, np.interp(at / length, share, smooth, period=1.0)


def _smoothed(values: np.ndarray, width: float) -> np.ndarray:
    """Return periodic values averaged by a Gaussian of a width in samples; their sum stays."""
    from scipy.ndimage import gaussian_filter1d

    return gaussian_filter1d(values, width, mode="wrap") if width > 0.0 else values


def outline_of(liner: _core.Profile) -> Outline:
    """Return one pitch of a liner, from its first node to that of the next pitch."""
    nodes = np.array([node[:3] for node in liner.nodes])
    if len(nodes) == 1:  # a drum, in quarters
        quarters = np.array([0.0, 0.5, 1.0, 1.5, 2.0]) * np.pi
        points = np.vstack([rotated(nodes[:1, :2], angle) for angle in quarters.tolist()])
        bulges = np.append(np.full(4, math.tan(math.pi / 8.0)), 0.0)
    else:
        points = np.vstack([nodes[:, :2], rotated(nodes[:1, :2], liner.pitch)])
        chords = np.linalg.norm(np.diff(points, axis=0), axis=1)
        radii = nodes[:, 2]
        half = np.zeros(len(nodes))
        np.divide(0.5 * chords, np.abs(radii), out=half, where=radii != 0.0)
        bulges = np.append(np.sign(radii) * np.tan(0.5 * np.arcsin(np.minimum(half, 1.0))), 0.0)
    names = tuple(f"node {i + 1}" for i in range(len(points)))
    return Outline(WORN, points, bulges, names, closed=False)


def _pitch_of(cavity: Any, liner: _core.Profile) -> Outline:
    """Return one pitch of the surface of a cavity, from the middle of one groove to the next.

    Raises:
        CampaignError: the surface is not one line there.
    """
    from shapely import LineString, Polygon, line_merge

    pitch, far = liner.pitch, 2.0 * liner.radius
    surface = LineString(cavity.exterior.coords)
    if liner.sectors == 1:
        points = np.array(surface.simplify(THINNED * liner.radius).coords)
        points = points[:-1] if Polygon(points).exterior.is_ccw else points[:0:-1]
        points = np.vstack([points, points[:1]])
    else:
        arc = np.linspace(0.0, pitch, 33)
        circle = np.column_stack([np.cos(arc), np.sin(arc)])
        wedge = Polygon(np.vstack([0.01 * far * circle[::-1], far * circle]))
        found = surface.intersection(wedge)
        merged = line_merge(found) if found.geom_type != "LineString" else found
        if merged.geom_type != "LineString":
            raise CampaignError(
                WORN, "", "the middle of a groove is no single surface", "less wear: fewer hours"
            )
        points = np.array(merged.simplify(THINNED * liner.radius).coords)
        sweep = np.arctan2(points[[0, -1], 1], points[[0, -1], 0])
        points = points if sweep[1] > sweep[0] else points[::-1]
        # Both ends are the same point of the liner.
        middle = 0.5 * (points[0] + rotated(points[-1:], -pitch)[0])
        points[0] = middle
        points[-1] = rotated(middle[None, :], pitch)[0]
    points = _without_short_sides(points, SHORTEST * liner.radius)
    names = tuple(f"point {i + 1}" for i in range(len(points)))
    return Outline(WORN, points, np.zeros(len(points)), names, closed=False)


def _without_short_sides(points: np.ndarray, shortest: float) -> np.ndarray:
    """Return a chain without sides shorter than `shortest` between two corners, (n, 2) [m].

    The neighbours of such a side meet nearer than `shortest` to its ends, or it stays.
    """
    k = 1
    while k < len(points) - 2:
        sides = np.diff(points[k - 1 : k + 3], axis=0)
        meeting = _meeting(*points[k - 1 : k + 3])
        if np.linalg.norm(sides[1]) < shortest and meeting is not None:
            turns = [_turn(sides[0], sides[1]), _turn(sides[1], sides[2])]
            moved = max(
                np.linalg.norm(meeting - points[k]), np.linalg.norm(meeting - points[k + 1])
            )
            if min(turns) > TURN and moved < shortest:
                points = np.vstack([points[:k], meeting, points[k + 2 :]])
                k = max(1, k - 1)
                continue
        k += 1
    return points


def _turn(one: np.ndarray, other: np.ndarray) -> float:
    """Return the angle between two directions [rad]."""
    return abs(math.atan2(one[0] * other[1] - one[1] * other[0], float(one @ other)))


def _meeting(
    before: np.ndarray, begin: np.ndarray, end: np.ndarray, after: np.ndarray
) -> np.ndarray | None:
    """Return where the lines through the first two and the last two points meet, (2,) [m]."""
    one, other, across = begin - before, after - end, end - before
    cross = one[0] * other[1] - one[1] * other[0]
    if cross == 0.0:
        return None
    return before + one * (across[0] * other[1] - across[1] * other[0]) / cross


def _leading_angle(pitch: Outline, angle: float) -> float:
    """Return the angle of the leading face, behind the crest in the direction of rotation [rad].

    Args:
        angle: of the pitch, whose middle is that of the lifter [rad].
    """
    distance = np.linalg.norm(pitch.points, axis=1)
    crest = int(distance.argmin())
    face, points = distance[crest:], pitch.points[crest:]
    height = float(distance.max()) - float(face[0])
    if height < LEAST_HEIGHT * float(distance.max()):
        return math.nan
    low, high = (_at_distance(points, face, float(face[0]) + share * height) for share in FACE)
    radial = np.array([math.cos(0.5 * angle), math.sin(0.5 * angle)])
    along = high - low
    return math.atan2(float(radial[0] * along[1] - radial[1] * along[0]), float(radial @ along))


def _at_distance(points: np.ndarray, distance: np.ndarray, wanted: float) -> np.ndarray:
    """Return where a chain first is at a distance from the axis, (2,) [m]."""
    k = max(1, int(np.argmax(distance >= wanted)))
    share = (wanted - distance[k - 1]) / (distance[k] - distance[k - 1])
    return np.asarray(points[k - 1] + share * (points[k] - points[k - 1]))


def _area(pitch: Outline) -> float:
    """Return the area between a pitch of lines and the axis [m^2]."""
    begin, end = pitch.points[:-1], pitch.points[1:]
    return float(0.5 * (begin[:, 0] * end[:, 1] - begin[:, 1] * end[:, 0]).sum())
