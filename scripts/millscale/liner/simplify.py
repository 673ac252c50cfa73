"""Few lines and arcs in place of many points, within a stated error."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.optimize import least_squares

from millscale.liner.outline import Outline, flattened

# An arc of less sagitta than this share of the tolerance is a line.
FLAT = 0.2
# An arc is taken in place of a line that fits if its largest distance is less by this factor.
BETTER = 0.7
# Pieces whose joints are refined together; more take long and gain little.
MOST_REFINED = 24
# An arc of less sagitta than this share of the tolerance becomes a line when joints have moved.
NO_ARC = 0.1
# Points on an outline, at least.
DENSE = 400
# Tried until no point is farther than the tolerance: near its ends a piece is longer than its run.
SHARES = (1.0, 0.8, 0.6, 0.4, 0.2)


def simplified(outline: Outline, tolerance: float) -> Outline:
    """Return an outline of lines and arcs that no point of the given one is farther from.

    From each joint the longest run of points is taken that one line or arc between two of the
    points fits. Then joints and arcs move to where the sum of squared distances is least, if the
    largest distance stays within the tolerance: the noise of a scan averages out. Derived here.

    Args:
        outline: of lines only; its points are what is fitted.
        tolerance: largest distance [m].

    Raises:
        CampaignError: no such outline was found.
    """
    dense = _dense(outline)
    for share in SHARES:
        found = _simplified(dense, share * tolerance)
        if reached_error(dense, found) <= tolerance:
            return found
    raise outline.refused(
        "", f"no lines and arcs found within {tolerance:g} m of the points", "a larger tolerance"
    )


def _dense(outline: Outline) -> Outline:
    """Return an outline of lines with more points on its long lines: an arc must be near them too,
    not only near their ends."""
    ends, n = outline.ends, outline.pieces
    lengths = np.linalg.norm(ends - outline.points[:n], axis=1)
    counts = np.ceil(lengths * DENSE / lengths.sum()).astype(int)
    points: list[np.ndarray] = []
    names: list[str] = []
    for begin, end, count, name in zip(
        outline.points[:n], ends, counts.tolist(), outline.names, strict=False
    ):
        shares = (np.arange(max(count, 1)) / max(count, 1))[:, None]
        points += list(begin + shares * (end - begin))
        names += [name] * max(count, 1)
    if not outline.closed:
        points.append(outline.points[-1])
        names.append(outline.names[-1])
    return replace(
        outline, points=np.array(points), bulges=np.zeros(len(points)), names=tuple(names)
    )


def reached_error(one: Outline, other: Outline) -> float:
    """Return the largest distance of a point of either outline from the other [m]."""
    chains = []
    for outline in (one, other):
        chain, _ = flattened(outline, 1e-6 * float(np.abs(outline.points).max()))
        chains.append(np.vstack([chain, chain[:1]]) if outline.closed else chain)
    return max(_farthest(chains[0], chains[1]), _farthest(chains[1], chains[0]))


def _farthest(chain: np.ndarray, other: np.ndarray) -> float:
    """Return the largest distance of the points of a chain, and of the middles between them, from
    another chain [m]."""
    from shapely import distance, linestrings, points

    places = np.concatenate([chain, 0.5 * (chain[1:] + chain[:-1])])
    return float(distance(points(places), linestrings(other)).max())


def _simplified(outline: Outline, tolerance: float) -> Outline:
    points = outline.points
    if outline.closed:
        # Begin at the sharpest corner: it is a joint in any case.
        first = int(np.argmax(_corner_angles(points)))
        order = np.roll(np.arange(len(points)), -first)
        points = np.vstack([points[order], points[order[:1]]])
    else:
        order = np.arange(len(points))
    joints, bulges = _runs(points, tolerance)
    corners, bulges = _refined(points, joints, bulges, tolerance)
    if outline.closed:
        joints, corners = joints[:-1], corners[:-1]
    else:
        bulges = np.append(bulges, 0.0)
    names = tuple(outline.names[order[j]] for j in joints)
    return replace(outline, points=corners, bulges=bulges, names=names)


def signed_distance(
    points: np.ndarray, begin: np.ndarray, end: np.ndarray, bulge: np.ndarray
) -> np.ndarray:
    """Return the distance of points from the line or circle of a piece each, > 0 to its left [m].

    With u along the chord and v to its left, from its middle, c half the chord and k the curvature
    2 b / (c (1 + b^2)), G = v (1 - b^2) / (1 + b^2) - k (u^2 + v^2 - c^2) / 2 vanishes on the
    circle, and the distance is 2 G / (1 + sqrt(1 - 2 k G)): no rounding where b is small. Derived
    here.

    Args:
        points, begin, end: (m, 2) float [m].
        bulge: (m,) float.
    """
    chord = end - begin
    half = 0.5 * np.linalg.norm(chord, axis=1)
    half = np.maximum(half, 1e-300)
    along = chord / (2.0 * half)[:, None]
    from_middle = points - 0.5 * (begin + end)
    u = (from_middle * along).sum(axis=1)
    v = along[:, 0] * from_middle[:, 1] - along[:, 1] * from_middle[:, 0]
    square = bulge * bulge
    curvature = 2.0 * bulge / (half * (1.0 + square))
    level = v * (1.0 - square) / (1.0 + square) - 0.5 * curvature * (u * u + v * v - half * half)
    root = np.sqrt(np.maximum(0.0, 1.0 - 2.0 * curvature * level))
    distance: np.ndarray = 2.0 * level / (1.0 + root)
    return distance


def _corner_angles(points: np.ndarray) -> np.ndarray:
    """Return by how much a closed chain turns at each point, (n,) float [rad]."""
    after = np.roll(points, -1, axis=0) - points
    before = np.roll(after, 1, axis=0)
    sine = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    turns: np.ndarray = np.abs(np.arctan2(sine, (before * after).sum(axis=1)))
    return turns


def _runs(points: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the points that are joints, (k + 1,) int, and the bulges between them, (k,) float."""
    joints, bulges = [0], []
    last = len(points) - 1
    while joints[-1] < last:
        begin = joints[-1]
        reach, fails = begin + 1, last + 1
        best = 0.0
        step = 1
        while reach < last and fails > reach + 1:
            # Double the run until it fails, then halve the interval.
            tried = min(begin + 1 + step, last) if fails > last else (reach + fails) // 2
            bulge = _fitted(points[begin : tried + 1], tolerance)
            if bulge is None:
                fails = tried
            else:
                reach, best, step = tried, bulge, 2 * step
        joints.append(reach)
        bulges.append(best)
    return np.array(joints), np.array(bulges)


def _fitted(run: np.ndarray, tolerance: float) -> float | None:
    """Return the bulge of the line or arc from the first to the last point that is nearest to the
    points between; None if one of them is farther than the tolerance."""
    begin, end, inner = run[0], run[-1], run[1:-1]
    chord = end - begin
    half = 0.5 * float(np.linalg.norm(chord))
    if len(inner) == 0:
        return 0.0
    if half == 0.0:
        return None
    along = chord / (2.0 * half)
    from_middle = inner - 0.5 * (begin + end)
    u = from_middle @ along
    v = along[0] * from_middle[:, 1] - along[1] * from_middle[:, 0]
    if np.abs(u).max() <= half + tolerance and np.abs(v).max() <= tolerance:
        flat = True
        if len(inner) < 3 or np.abs(v).max() <= FLAT * tolerance:
            return 0.0
    else:
        flat = False
    # The circle through both ends with its centre at (0, k): 2 v k = u^2 + v^2 - c^2.
    weight = float((v * v).sum())
    if weight > 0.0:
        centre = float((v * (u * u + v * v - half * half)).sum()) / (2.0 * weight)
        radius = float(np.hypot(centre, half))
        side = -1.0 if float((v * (half * half - u * u)).sum()) < 0.0 else 1.0
        apex = centre + side * radius
        bulge = -apex / half
        if abs(bulge) <= 1.0:
            off = np.abs(np.hypot(u, v - centre) - radius)
            within = np.abs(u).max() <= half + tolerance and off.max() <= tolerance
            if within and (not flat or off.max() <= BETTER * np.abs(v).max()):
                return bulge
    return 0.0 if flat else None


def _refined(
    points: np.ndarray, joints: np.ndarray, bulges: np.ndarray, tolerance: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return corners (k + 1, 2) [m] and bulges (k,) of least squared distances from the points.

    The first and the last corner stay. If the result is worse than the tolerance, or the run has
    only joints, nothing moves.
    """
    corners = points[joints]
    count = len(bulges)
    if count > MOST_REFINED or len(points) < 3 * count:
        return corners, bulges
    owner = np.clip(np.searchsorted(joints, np.arange(len(points)), side="right") - 1, 0, count - 1)
    scale = max(tolerance, 1e-12)

    def unpacked(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        moved = corners.copy()
        moved[1:-1] += scale * values[: 2 * (count - 1)].reshape(-1, 2)
        chords = np.linalg.norm(np.diff(corners, axis=0), axis=1)
        return moved, bulges + values[2 * (count - 1) :] * scale / np.maximum(chords, scale)

    def residuals(values: np.ndarray) -> np.ndarray:
        moved, bent = unpacked(values)
        distance = signed_distance(points, moved[owner], moved[owner + 1], bent[owner])
        # A weak pull towards the first place keeps joints of smooth transitions from sliding.
        return np.concatenate([distance / scale, 1e-2 * values])

    start = np.zeros(2 * (count - 1) + count)
    found = least_squares(residuals, start, max_nfev=12).x
    moved, bent = unpacked(found)
    chords = np.linalg.norm(np.diff(moved, axis=0), axis=1)
    bent[0.5 * np.abs(bent) * chords <= NO_ARC * tolerance] = 0.0
    distance = signed_distance(points, moved[owner], moved[owner + 1], bent[owner])
    worst = max(np.abs(distance).max(), _farthest(moved, points))
    if worst > tolerance or np.abs(bent).max(initial=0.0) > 1.0:
        return corners, bulges
    return moved, bent
