"""Distances and overlaps against their definitions."""

import itertools

import numpy as np
import pytest
from numpy.testing import assert_allclose

from millscale.analysis.shapes.comparison import (
    FARTHEST,
    HALF_CHORD,
    SPACING,
    curve_distances,
    distance_along_normal,
    overlap,
)


def naive_distances(first, second):
    """Every point against every segment."""

    def to_line(point, line):
        best = np.inf
        for a, b in itertools.pairwise(line):
            along = np.clip(np.dot(point - a, b - a) / np.dot(b - a, b - a), 0.0, 1.0)
            best = min(best, np.hypot(*(a + along * (b - a) - point)))
        return best

    def one_way(points_of, line):
        steps = np.linspace(0.0, 1.0, 400)
        points = [a + s * (b - a) for a, b in itertools.pairwise(points_of) for s in steps]
        weights = [np.hypot(*(b - a)) for a, b in itertools.pairwise(points_of) for _ in steps]
        distances = np.array([to_line(p, line) for p in points])
        return np.average(distances, weights=weights), distances.max()

    there, back = one_way(first, second), one_way(second, first)
    return 0.5 * (there[0] + back[0]), max(there[1], back[1])


def test_parallel_lines_are_as_far_apart_as_they_are():
    line = np.array([[0.0, 0.0], [1.0, 0.0]])
    assert_allclose(curve_distances([line], [line + np.array([0.0, 0.1])]), (0.1, 0.1), atol=1e-6)


def test_distance_is_symmetric_and_zero_to_itself():
    a, b = np.array([[0, 0], [1, 0.2], [1.5, 1]]), np.array([[0, 0.1], [0.7, 0.4]])
    assert curve_distances([a], [b]) == curve_distances([b], [a])
    assert curve_distances([a], [a]) == (0.0, 0.0)


def test_distances_are_those_of_the_definition():
    generator = np.random.default_rng(4)
    a, b = (np.cumsum(generator.uniform(-0.1, 0.3, (5, 2)), axis=0) for _ in range(2))
    assert_allclose(curve_distances([a], [b]), naive_distances(a, b), atol=2.0 * SPACING)


def test_a_longer_curve_is_seen_by_the_largest_distance():
    short, long = np.array([[0.0, 0.0], [1.0, 0.0]]), np.array([[0.0, 0.0], [1.5, 0.0]])
    mean, largest = curve_distances([short], [long])
    assert_allclose(largest, 0.5, atol=SPACING)
    assert_allclose(mean, 0.5 * (0.5 * 0.5 / 1.5 * 0.5), atol=SPACING)


def test_a_curve_may_have_several_lines():
    line = np.array([[0.0, 0.0], [1.0, 0.0]])
    halves = [line * 0.5, line * 0.5 + np.array([0.5, 0.0])]
    assert_allclose(curve_distances([line], halves), 0.0, atol=SPACING)


def test_empty_curve_is_refused():
    with pytest.raises(ValueError, match="without a line"):
        curve_distances([], [np.array([[0.0, 0.0], [1.0, 0.0]])])


def test_overlap_is_shared_over_covered():
    a, b = np.zeros((10, 10), bool), np.zeros((10, 10), bool)
    a[:4], b[2:6] = True, True
    assert overlap(a, b) == 20 / 60
    upper = np.zeros((10, 10), bool)
    upper[:3] = True
    assert overlap(a, b, upper) == 10 / 30
    assert overlap(a & False, b & False) is None


def arc(radius, begin=0.0, end=np.pi, points=400):
    """An arc about the origin, counter-clockwise from the right; the air is inside it."""
    turn = np.linspace(np.pi + begin, np.pi + end, points)[::-1]
    return radius * np.column_stack([np.cos(turn), np.sin(turn)])


@pytest.mark.parametrize("turned_round", [False, True])
def test_distance_along_the_normal_of_arcs_is_that_of_their_radii(turned_round):
    other = arc(0.9)[::-1] if turned_round else arc(0.9)
    along, distance = distance_along_normal([arc(1.0)], [other])
    inner = (along > HALF_CHORD) & (along < along[-1] - HALF_CHORD)
    # Both are polygons of 400 points: off their arcs by radius (pi / 400)^2 / 8 at most.
    assert_allclose(distance[inner], 0.1, atol=1e-4)
    assert_allclose(along[-1], np.pi, atol=1e-4)
    _, back = distance_along_normal([arc(0.9)], [arc(1.0)])
    assert_allclose(back[20:-20], -0.1, atol=1e-4)


def test_distance_along_the_normal_begins_at_the_toe_and_the_longest_line_counts():
    line = np.array([[-1.0, 1.0], [1.0, -1.0]])
    lifted = np.array([[-1.0, 1.0], [0.0, 0.0], [0.5, -0.3], [1.0, -0.8]])
    along, distance = distance_along_normal([line * 0.1, line], [lifted])
    assert_allclose(along[-1], np.hypot(2.0, 2.0))
    # The lifted half is that of the toe; its kink lies 0.2 / sqrt(2) above the reference.
    assert_allclose(np.nanmax(distance), 0.2 / np.sqrt(2.0), atol=2e-3)
    assert along[np.nanargmax(distance)] < 0.5 * along[-1]
    assert_allclose(distance[along > 0.55 * along[-1]], 0.0, atol=1e-12)


def test_no_distance_where_the_other_surface_is_absent_or_far():
    line = np.array([[1.0, 0.0], [-1.0, 0.0]])
    part = np.array([[0.2, 0.05], [-0.2, 0.05]])
    along, distance = distance_along_normal([line], [part, line + np.array([0.0, FARTHEST + 0.01])])
    near = np.abs(1.0 - along) < 0.19
    assert_allclose(distance[near], 0.05, atol=1e-12)
    assert np.isnan(distance[np.abs(1.0 - along) > 0.21]).all()
    assert np.isnan(distance_along_normal([line], [])[1]).all()
    with pytest.raises(ValueError, match="no normal"):
        distance_along_normal([], [line])
