"""Liners of ball mills that are not of equal trapezoidal lifters, of radius 1.5 m."""

import numpy as np

from millscale import _core

RADIUS = 1.5
GROOVE, LEADING, TOP, TRAILING = range(4)


def turned(point, angle):
    """Return a point, turned in the direction of rotation [rad]."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * point[0] - s * point[1], s * point[0] + c * point[1]])


def _foot(corner, slope, side):
    """Return where a face from a corner of a lifter's top meets the circle of the liner."""
    along = np.array([np.cos(slope), side * np.sin(slope)])
    b = corner @ along
    return corner + (-b + np.sqrt(b * b + RADIUS**2 - corner @ corner)) * along


def lifter(angle, height, width, leading, trailing, arc=RADIUS):
    """Return the nodes of a lifter on the circle, and of the groove before it.

    Args:
        angle: of its middle from the sector's centre line [rad].
        height, width: of its top [m].
        leading, trailing: angles of its faces from its middle [rad].
        arc: radius of the groove; 0: a flat groove [m].
    """
    top = [np.array([RADIUS - height, side * 0.5 * width]) for side in (-1.0, 1.0)]
    points = [_foot(top[0], trailing, -1.0), *top, _foot(top[1], leading, 1.0)]
    rows = zip(points, (0.0, 0.0, 0.0, arc), (TRAILING, TOP, LEADING, GROOVE), strict=True)
    return [(*turned(point, angle).tolist(), radius, face, 0) for point, radius, face in rows]


def hi_lo(arc=RADIUS, phase=-0.25):
    """Return a liner of a high and a low lifter in each of 10 sectors."""
    nodes = lifter(-0.2, 0.16, 0.08, 0.2, 0.3, arc) + lifter(0.08, 0.07, 0.1, 0.5, 0.25, arc)
    return _core.Profile(nodes, 10, phase)


def worn(arc=RADIUS):
    """Return worn lifters: the leading face at 47 degrees, 116 mm high in a mill of 3.9 m."""
    scale = RADIUS / 3.9
    leading, trailing = np.radians([47.0, 20.0])
    nodes = lifter(0.0, 0.058 * scale * 2.0, 0.2 * scale, leading, trailing, arc)
    return _core.Profile(nodes, 20, 0.0)


def ship_lap():
    """Return slopes that end at a face which drops to the next slope."""
    sectors, half = 16, np.pi / 16
    low, high = turned([RADIUS, 0.0], -half), turned([RADIUS - 0.09, 0.0], half - 0.02)
    nodes = [(*low.tolist(), 0.0, GROOVE, 0), (*high.tolist(), 0.0, LEADING, 0)]
    return _core.Profile(nodes, sectors, 0.0)


def wave(sectors=16):
    """Return crests and valleys of arcs with smooth joints."""
    half = np.pi / sectors
    low, crest = np.array([1.3, 0.0]), turned([RADIUS + 0.1, 0.0], half)
    r = 0.5 * np.linalg.norm(low - crest)
    before = 0.5 * (low + np.array([crest[0], -crest[1]]))
    nodes = [(*before.tolist(), r, GROOVE, 0), (*(0.5 * (low + crest)).tolist(), -r, TOP, 0)]
    return _core.Profile(nodes, sectors, 0.0)


def all_around(liner):
    """Return the same outline, given all around in one sector."""
    nodes = []
    for k in range(liner.sectors):
        for radial, tangential, arc, face, _ in liner.nodes:
            point = turned([radial, tangential], k * liner.pitch)
            nodes.append((*point.tolist(), arc, face, 0))
    last = liner.nodes[-1][4]  # its lifter is the first of the first sector
    nodes[-1] = (*nodes[-1][:4], last)
    return _core.Profile(nodes, 1, liner.phase)


FAMILIES = {"hi-lo": hi_lo, "worn": worn, "ship-lap": ship_lap, "wave": wave}
