"""Initial positions, velocities and radii of the balls of a hard case."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.optimize

from millscale.validate.cases import Case, Mill

JUST_APART = 1.02  # distance of centres over the sum of radii in a heap
SOLID = 0.6  # of a bed
SMALL_SHARE = 0.05  # of the volume, where there are two sizes
LEADING = 1  # kind of a polygon's edge
BLOW, SHOT = 5.0, 10.0  # [m/s]
DEEP = 0.1  # overlap over radius
# The ball that is shot into the bed appears when the bed is at rest.
SETTLING = 0.3  # [s]


@dataclass(frozen=True)
class Balls:
    """Positions and velocities, (n, 3), and radii, (n,), SI; `late` balls appear after SETTLING."""

    position: np.ndarray
    velocity: np.ndarray
    radius: np.ndarray
    late: Balls | None = None


def balls_of(case: Case, mill: Mill, seed: int) -> Balls:
    """Return the balls of a case at its start."""
    return {
        "heap": _heap,
        "edge": _on_edge,
        "corner": _into_corner,
        "wedge": _wedged,
        "bed": _shot_into_bed,
        "overlapping": _overlapping,
    }[case.scene](case, mill, seed)


def _resting(position, radius) -> Balls:
    position = np.atleast_2d(position)
    return Balls(position, 0.0 * position, np.broadcast_to(radius, len(position)).astype(float))


def _heap(case: Case, mill: Mill, seed: int) -> Balls:
    """Return a grid of balls with small random shifts, smaller balls above larger ones."""
    random = np.random.default_rng(seed)
    area = np.pi * mill.radius**2
    volume = case.filling * SOLID * area * mill.length
    shares = (1.0,) if len(mill.radii) == 1 else (1.0 - SMALL_SHARE, SMALL_SHARE)
    places, sizes, floor = [], [], -mill.radius
    for radius, share in zip(mill.radii, shares, strict=True):
        count = max(1, round(share * volume / (4.0 / 3.0 * np.pi * radius**3)))
        grid = _grid(mill, radius, floor)
        if len(grid) < count:
            raise ValueError(f"{case.name}: {count} balls of {radius} m need {len(grid)} places")
        shake = 0.4 * (JUST_APART - 1.0) * radius
        places.append(grid[:count] + random.uniform(-shake, shake, (count, 3)))
        sizes.append(np.full(count, radius))
        floor = places[-1][:, 2].max() + radius
    return _resting(np.concatenate(places), np.concatenate(sizes))


def _grid(mill: Mill, radius: float, floor: float) -> np.ndarray:
    """Return places in the cavity above `floor`, (n, 3), the lowest first."""
    step = 2.0 * radius * JUST_APART
    along = max(1, int(mill.length / step))
    axis = np.arange(-mill.radius, mill.radius, step)
    x, y, z = np.meshgrid(axis, (np.arange(along) + 0.5) * mill.length / along, axis)
    places = np.column_stack([x.ravel(), y.ravel(), z.ravel()])
    places[:, 2] += max(0.0, floor + JUST_APART * radius - places[:, 2].min())
    section = np.ascontiguousarray(places[:, [0, 2]])
    inside = np.hypot(*section.T) < mill.lifter_top_radius
    clear = np.zeros(len(places), bool)
    near = mill.liner.nearest(np.ascontiguousarray(section[inside]))
    clear[inside] = near.distance > JUST_APART * radius
    clear &= places[:, 2] >= floor + (JUST_APART - 1e-9) * radius
    return places[clear][np.argsort(places[clear][:, 2], kind="stable")]


def _lowest_lifter(mill: Mill):
    """Return top corner and foot of a lifter, and the normals of its top and leading face."""
    nodes, kinds = mill.liner.polygon(1e-4)
    faces = np.flatnonzero(kinds == LEADING)
    face = int(faces[np.argmin(nodes[faces, 1])])
    corner, foot = nodes[face], nodes[(face + 1) % len(nodes)]
    beside = nodes[face - 1]
    return corner, foot, _inward(beside, corner), _inward(corner, foot)


def _inward(a, b):
    along = (b - a) / np.linalg.norm(b - a)
    normal = np.array([along[1], -along[0]])
    return normal if normal @ (a + b) < 0.0 else -normal


def _thrown_at(mill: Mill, point, towards, speed) -> Balls:
    """Return a ball that flies at a point of the section, 0.01 radii before contact."""
    towards = towards / np.linalg.norm(towards)
    radius = mill.radii[0]

    def clearance(distance):
        p = np.atleast_2d(point - distance * towards)
        return mill.liner.nearest(p).distance[0] - 1.01 * radius

    distance = scipy.optimize.brentq(clearance, 0.5 * radius, 6.0 * radius)
    x, z = point - distance * towards
    ball = _resting([[x, 0.5 * mill.length, z]], radius)
    velocity = speed * np.array([[towards[0], 0.0, towards[1]]])
    return Balls(ball.position, velocity, ball.radius)


def _on_edge(case: Case, mill: Mill, seed: int) -> Balls:
    corner, _, top, face = _lowest_lifter(mill)
    # Not through the middle of the edge, which would reverse the velocity of the ball.
    return _thrown_at(mill, corner, -(1.2 * top + face), BLOW)


def _into_corner(case: Case, mill: Mill, seed: int) -> Balls:
    _, foot, _, face = _lowest_lifter(mill)
    return _thrown_at(mill, foot, -(face - 1.1 * foot / np.linalg.norm(foot)), BLOW)


def _wedged(case: Case, mill: Mill, seed: int) -> Balls:
    """Return a ball in the corner, and another that flies at it from the open side."""
    first = _into_corner(case, mill, seed)
    direction = first.velocity[0] / BLOW
    behind = first.position[0] - 2.02 * mill.radii[0] * direction
    position = np.array([first.position[0], behind])
    velocity = np.array([0.0 * direction, BLOW * direction])
    return Balls(position, velocity, np.full(2, mill.radii[0]))


def _shot_into_bed(case: Case, mill: Mill, seed: int) -> Balls:
    bed = _heap(case, mill, seed)
    top = bed.position[:, 2].max() + 8.0 * mill.radii[0]
    late = Balls(
        np.array([[0.0, 0.5 * mill.length, top]]),
        np.array([[0.0, 0.0, -SHOT]]),
        np.array([mill.radii[0]]),
    )
    return Balls(bed.position, bed.velocity, bed.radius, late)


def _overlapping(case: Case, mill: Mill, seed: int) -> Balls:
    """Return a block of balls in the air that all overlap, also across the periodic boundary."""
    step = (2.0 - DEEP) * mill.radii[0]
    count = round(mill.length / step)
    if count < 1 or abs(count * step - mill.length) > 1e-9:
        raise ValueError(f"{case.name}: the slice must be a whole number of {step} m")
    index = np.arange(4) - 1.5
    x, y, z = np.meshgrid(index * step, (np.arange(count) + 0.5) * step, index * step)
    return _resting(np.column_stack([x.ravel(), y.ravel(), z.ravel()]), mill.radii[0])
