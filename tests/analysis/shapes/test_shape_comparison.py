"""Distances and overlaps against their definitions."""

import itertools

import numpy as np
import pytest
from numpy.testing import assert_allclose

from millscale.analysis.shapes.comparison import SPACING, curve_distances, overlap


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
