"""Contacts of the analytic wall, compared with the triangles of the mesh of the same polygon."""

from dataclasses import dataclass

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from millscale import _core
from millscale.mesh import build_liner_mesh

BALLS = 100_000
RADIUS = 0.02  # of the balls [m]
CHORD_ERROR = 5e-4
LENGTH = 0.3
OMEGA = np.array([0.0, 1.6, 0.0])  # of the mill [rad/s]
ROUNDING = 8 * np.finfo(float).eps  # of a distance, over the largest coordinate
GROOVE, LEADING, TOP, TRAILING = range(4)

LINERS = {
    "paper": _core.Lifters(1.5, 3.61 / 2.6, 0.25 / 2.6, 0.635 / 2.6, 25, phase=0.1),
    "few": _core.Lifters(1.0, 0.7, 0.2, 0.9, 5, phase=-1.0),
    "two": _core.Lifters.from_face_angle(1.0, 0.5, 0.3, 0.2, 2),
    "drum": _core.Lifters(1.5, 0.0, 0.0, 0.0, 0),
}


@dataclass(frozen=True)
class Touches:
    """Ball, surface (0, 1, ..: groove 0, lifter 0, groove 1, ..), overlap, contact point (m, 3)."""

    ball: np.ndarray
    surface: np.ndarray
    overlap: np.ndarray
    point: np.ndarray
    normal: np.ndarray


def surfaces(liner, face, sector):
    """Number of the groove, or of the lifter, as of a polygon's edges or of touches."""
    return 2 * sector + (face != GROOVE)


def strip_surfaces(liner, mesh):
    """Return the surface of each triangle. A lifter's top begins a sector, its trailing side ends
    it."""
    _, kinds = liner.polygon(CHORD_ERROR)
    sector = np.maximum(np.cumsum(kinds == TOP) - 1, 0)
    sector = (sector + (kinds == TRAILING)) % max(liner.lifters, 1)
    return np.repeat(surfaces(liner, kinds, sector), 2)


def random_centres(liner, seed):
    """(n, 3) centres in the cavity, their surfaces up to a radius in the wall, and some farther."""
    random = np.random.default_rng(seed)
    nodes, _ = liner.polygon(CHORD_ERROR)
    edge = np.roll(nodes, -1, axis=0) - nodes
    length = np.hypot(*edge.T)
    i = random.choice(len(nodes), size=8 * BALLS, p=length / length.sum())
    inward = np.column_stack([-edge[:, 1], edge[:, 0]]) / length[:, None]
    inward *= np.sign(-np.sum(inward * nodes, axis=1))[:, None]  # no face leans over the groove
    height = RADIUS * random.uniform(1e-3, 1.1, len(i))
    aside = RADIUS * random.uniform(-1.0, 1.0, len(i))  # around the edges too
    section = nodes[i] + (random.uniform(size=len(i)) + aside / length[i])[:, None] * edge[i]
    section += height[:, None] * inward[i]
    near = liner.nearest(np.ascontiguousarray(section)).distance
    section = section[near > 1e-3 * RADIUS + CHORD_ERROR][:BALLS]
    assert len(section) == BALLS
    y = random.uniform(2 * RADIUS, LENGTH - 2 * RADIUS, BALLS)
    return np.column_stack([section[:, 0], y, section[:, 1]])


def closest_on_triangles(p, a, b, c):
    """Points of triangles closest to points, and whether they lie inside, not on an edge.

    All (m, 3). By projection on the plane and, where that falls outside, on the three edges.
    """
    n = np.cross(b - a, c - a)
    n /= np.linalg.norm(n, axis=1)[:, None]
    foot = p - np.sum((p - a) * n, axis=1)[:, None] * n
    inside = np.ones(len(p), bool)
    best, least = np.empty_like(p), np.full(len(p), np.inf)
    for u, v in ((a, b), (b, c), (c, a)):
        inside &= np.sum(np.cross(v - u, foot - u) * n, axis=1) >= 0.0
        along = np.sum((p - u) * (v - u), axis=1) / np.sum((v - u) ** 2, axis=1)
        q = u + np.clip(along, 0.0, 1.0)[:, None] * (v - u)
        distance = np.linalg.norm(p - q, axis=1)
        closer = distance < least
        best[closer], least[closer] = q[closer], distance[closer]
    return np.where(inside[:, None], foot, best), inside


def mesh_touches(liner, centres):
    """Return the contacts with the triangles, computed from the definition.

    Returns the touches, and per ball whether its nearest point lies on a convex edge. A ball over
    the inside of triangles touches, of each groove and lifter, the nearest; one whose nearest point
    is on an edge touches that.
    """
    mesh = build_liner_mesh(liner, LENGTH, CHORD_ERROR)
    surface, corners = strip_surfaces(liner, mesh), mesh.corners
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    height = centres @ normal.T - np.sum(corners[:, 0] * normal, axis=1)
    ball, triangle = np.nonzero(np.abs(height) < RADIUS)
    p = centres[ball]
    q, inside = closest_on_triangles(p, *corners[triangle].transpose(1, 0, 2))
    # The diagonal of a strip is not an edge of the liner: its two triangles are one rectangle.
    distance = np.linalg.norm(p - q, axis=1)
    over = np.zeros((len(centres), len(mesh.triangles) // 2), bool)
    over[ball[inside], triangle[inside] // 2] = True
    inside |= over[ball, triangle // 2]
    near = distance < RADIUS
    ball, surface, q, distance, inside = (
        column[near] for column in (ball, surface[triangle], q, distance, inside)
    )
    order = np.lexsort((distance, ball))
    ball, surface, q, distance, inside = (
        column[order] for column in (ball, surface, q, distance, inside)
    )
    touching, first = np.unique(ball, return_index=True)
    at_edge = np.zeros(len(centres), bool)
    at_edge[touching] = ~inside[first]
    counted = inside | at_edge[ball]
    group = np.where(at_edge[ball], -1, surface)[counted]  # of an edge only the nearest point
    _, first = np.unique(np.column_stack([ball[counted], group]), axis=0, return_index=True)
    ball, surface, q, distance = (column[counted][first] for column in (ball, surface, q, distance))
    normals = (centres[ball] - q) / distance[:, None]
    return Touches(ball, surface, RADIUS - distance, q, normals), at_edge


def wall_touches(liner, centres, chord_error=CHORD_ERROR):
    """Return the contacts with the analytic wall."""
    section = np.ascontiguousarray(centres[:, [0, 2]])
    found = liner.contacts(section, RADIUS, chord_error)
    surface = surfaces(liner, found.face, found.sector)
    order = np.lexsort((surface, found.ball))
    normal = np.zeros((len(order), 3))
    normal[:, [0, 2]] = found.normal[order]
    overlap, ball = found.overlap[order], found.ball[order]
    point = centres[ball] - (RADIUS - overlap)[:, None] * normal
    return Touches(ball, surface[order], overlap, point, normal)


@pytest.fixture(scope="module", params=LINERS)
def both(request):
    """Return contacts with triangles and wall, and balls whose nearest point is on an edge."""
    liner = LINERS[request.param]
    centres = random_centres(liner, seed=1)
    mesh, at_edge = mesh_touches(liner, centres)
    return liner, centres, mesh, wall_touches(liner, centres), at_edge


def test_mesh_and_wall_have_contacts_with_the_same_balls_and_surfaces(both):
    _, _, mesh, wall, _ = both
    barely = mesh.overlap < 1e-12  # within rounding of contact
    assert barely.sum() < 3
    pairs = [
        {(b, s) for b, s, o in zip(t.ball, t.surface, t.overlap, strict=True) if o > 1e-12}
        for t in (mesh, wall)
    ]
    assert pairs[0] == pairs[1]
    assert len(pairs[0]) > 0.8 * BALLS


def test_overlap_normal_and_velocity_are_those_of_the_triangles(both):
    liner, centres, mesh, wall, _ = both
    assert_array_equal(mesh.ball, wall.ball)
    # A distance of about a radius is known to rounding of the coordinates, and the overlap is what
    # it leaves of the radius: relative to a small overlap that rounding is more.
    assert_allclose(wall.overlap, mesh.overlap, rtol=1e-10, atol=ROUNDING * liner.radius)
    # The triangles' normal comes from centre and foot, so its rounding grows over a small distance.
    resolved = RADIUS - mesh.overlap > 1e-2 * RADIUS
    assert_allclose(wall.normal[resolved], mesh.normal[resolved], rtol=0.0, atol=1e-10)

    ball_velocity = np.random.default_rng(2).normal(size=centres.shape)

    def relative(touches):
        return ball_velocity[touches.ball] - np.cross(OMEGA, touches.point)

    size = np.linalg.norm(relative(mesh), axis=1)
    off = np.linalg.norm(relative(wall) - relative(mesh), axis=1)
    assert (off / size).max() < 1e-10


def test_a_convex_edge_gives_one_contact_at_the_exact_nearest_point(both):
    liner, _, mesh, wall, at_edge = both
    if liner.lifters == 0:
        assert not at_edge.any()
        return
    assert at_edge.sum() > 100
    for touches in (mesh, wall):
        assert np.bincount(touches.ball)[np.flatnonzero(at_edge)].max() == 1
    edges = liner.polygon(CHORD_ERROR)
    corner = edges[0][(edges[1] == LEADING) | (np.roll(edges[1], 1) == TRAILING)]
    points = wall.point[at_edge[wall.ball]][:, [0, 2]]
    gap = np.linalg.norm(points[:, None] - corner[None], axis=2).min(axis=1)
    assert gap.max() < ROUNDING * liner.radius


def test_a_concave_corner_gives_two_contacts(both):
    liner, _, _, wall, _ = both
    twice = np.bincount(wall.ball) == 2
    assert np.bincount(wall.ball).max() == (2 if liner.lifters else 1)
    if liner.lifters:
        assert twice.sum() > 100
        kinds = wall.surface[twice[wall.ball]].reshape(-1, 2) % 2
        assert_array_equal(np.sort(kinds, axis=1), np.tile([0, 1], (twice.sum(), 1)))


@pytest.mark.parametrize("name", LINERS)
def test_polygon_and_arc_differ_by_the_sagitta(name):
    liner = LINERS[name]
    nodes, kinds = liner.polygon(CHORD_ERROR)
    chord = np.linalg.norm(np.roll(nodes, -1, axis=0) - nodes, axis=1)[kinds == GROOVE][0]
    half = np.arcsin(0.5 * chord / liner.radius)
    sagitta = liner.radius * (1.0 - np.cos(half))
    assert 0.25 * CHORD_ERROR < sagitta <= CHORD_ERROR

    # Balls at one distance from the axis: over the middle of each chord, and half way to its end.
    middle = (0.5 * (nodes + np.roll(nodes, -1, axis=0)))[kinds == GROOVE]
    middle /= np.hypot(*middle.T)[:, None]
    distance = liner.radius - 0.7 * RADIUS
    for turn in (0.0, 0.5 * half):
        c, s = np.cos(turn), np.sin(turn)
        section = distance * middle @ np.array([[c, s], [-s, c]])
        centres = np.insert(section, 1, 0.1, axis=1)
        polygon, arc = (wall_touches(liner, centres, error) for error in (CHORD_ERROR, None))
        on_groove = [t.overlap[t.surface % 2 == 0] for t in (polygon, arc)]
        # R - d on the arc, R cos(half) - d cos(turn) on the chord.
        expected = sagitta - distance * (1.0 - np.cos(turn))
        assert_allclose(on_groove[0] - on_groove[1], expected, rtol=1e-9)


def test_chords_that_fold_like_corners_are_refused():
    with pytest.raises(ValueError, match=r"gives chords that fold by 2\.09.* < pi/3"):
        LINERS["drum"].contacts(np.zeros((1, 2)), RADIUS, chord_error=1.4)
    with pytest.raises(ValueError, match="chord error: must be > 0"):
        LINERS["drum"].contacts(np.zeros((1, 2)), RADIUS, chord_error=-1.0)
