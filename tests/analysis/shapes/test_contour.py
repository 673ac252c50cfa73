"""Surface contours of charges whose surface is known."""

import numpy as np
import pytest
from matplotlib.path import Path as Polygon
from numpy.testing import assert_allclose

from millscale.analysis.shapes.comparison import points_along
from millscale.analysis.shapes.contour import first_gaps, surface_contour
from millscale.analysis.shapes.solid_fraction import Grid, solid_fraction, value_at
from synthetic_shapes import CIRCLE, packed_bed

A = 0.0133  # ball radius over R - a of the paper's S = 2.6
LENGTH = 0.26  # and its length


def test_fraction_is_the_sum_of_kernels_over_the_balls():
    generator = np.random.default_rng(3)
    centres, areas = generator.uniform(-0.9, 0.9, (400, 2)), generator.uniform(1, 3, 400)
    grid = Grid()
    field = solid_fraction(centres, areas, grid)
    nodes = generator.integers(0, grid.nodes.size, (60, 2))
    at = grid.nodes[nodes]
    distance = np.sum((at[:, None] - centres) ** 2, axis=2)
    w = grid.resolution
    naive = np.sum(areas * np.exp(-0.5 * distance / w**2), axis=1) / (2.0 * np.pi * w**2)
    # Sharing a ball among four nodes adds step^2 / 6 to the kernel's variance w^2: 1.9 % here, and
    # so as much of the kernel's peak.
    assert_allclose(field[nodes[:, 1], nodes[:, 0]], naive, atol=0.02 * 3.0 / (2 * np.pi * w**2))
    assert_allclose(field.sum() * grid.step**2, areas.sum(), rtol=1e-12)
    assert_allclose(value_at(field, at, grid), field[nodes[:, 1], nodes[:, 0]])


SQUARE = 0.5 * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
AROUND = np.linspace(0.0, 2.0 * np.pi, 1000)
WAVES = (0.9 + 0.05 * np.cos(25.0 * AROUND)) * np.array([np.cos(AROUND), np.sin(AROUND)])


@pytest.mark.parametrize(
    "outline",
    [
        CIRCLE,
        SQUARE,
        np.array([0.3, 0.0]) + SQUARE,
        np.array([0.7, -0.6]) + SQUARE,  # also past the edge of the grid
        WAVES.T,
        np.vstack([SQUARE, 1.5 * SQUARE[::-1]]),  # around the origin, with a hole there
        np.array([3.0, 0.0]) + SQUARE,
    ],
)
def test_nodes_inside_an_outline_are_those_that_a_search_of_all_nodes_finds(outline):
    grid = Grid(0.05)
    nodes = np.column_stack(
        [np.tile(grid.nodes, grid.nodes.size), np.repeat(grid.nodes, grid.nodes.size)]
    )
    naive = Polygon(outline).contains_points(nodes).reshape(grid.nodes.size, -1)
    np.testing.assert_array_equal(grid.inside(outline), naive)


@pytest.mark.parametrize("tilt", [0.0, 0.6])
def test_flat_surface_of_a_half_full_drum_is_found_to_a_quarter_of_a_ball(tilt):
    places, areas = packed_bed(A, LENGTH, tilt, height=-0.1)
    contour = surface_contour(places[:, [0, 2]], areas, CIRCLE, Grid())
    points = points_along(contour.lines)
    points = points[np.hypot(*points.T) < 0.9]  # at the wall the kernel's cover is estimated
    height = points @ np.array([-np.sin(tilt), np.cos(tilt)])
    # The bed's balls are jittered by a third of their spacing, 0.8 a, and the kernel holds 30.
    assert abs(height.mean() + 0.1) < 0.25 * A
    assert height.std() < 0.5 * A
    assert 1.75 < np.ptp(points @ np.array([np.cos(tilt), np.sin(tilt)])) <= 1.8
    assert_allclose(contour.bulk_fraction, 0.55, rtol=0.04)


def test_error_of_the_contour_falls_with_the_number_of_balls():
    off, radii = [], np.array([0.02, 0.014, 0.007])
    for radius in radii:
        places, areas = packed_bed(radius, 0.26, 0.0, height=0.0)
        lines = surface_contour(places[:, [0, 2]], areas, CIRCLE, Grid()).lines
        points = points_along(lines)
        off.append(np.sqrt(np.mean(points[np.abs(points[:, 0]) < 0.85][:, 1] ** 2)))
    assert off[0] > 1.4 * off[1] > 2.0 * off[2]
    # With n balls in the kernel's area the level is off by n^-1/2 of the bed's fraction at most,
    # that of balls without order: by sqrt(2 pi / n) w on the line, where n = 0.55 L 4 pi w^2 / V.
    n = 0.55 * 0.26 * 4.0 * np.pi * 0.02**2 / (4.0 / 3.0 * np.pi * radii**3)
    assert np.all(np.array(off) < 0.5 * np.sqrt(2.0 * np.pi / n) * 0.02)


def test_curved_surface_moves_by_the_kernel_s_known_bias():
    # A bed outside a circle of radius c around the axis: bed toe to toe all around the wall.
    places, areas = packed_bed(0.006, 0.2, 0.0, height=1.2)
    c = 0.5
    keep = np.hypot(places[:, 0], places[:, 2]) > c
    wide = Grid(0.06)
    lines = surface_contour(places[keep][:, [0, 2]], areas[keep], CIRCLE, wide).lines
    assert len(lines) == 1
    radius = np.hypot(*points_along(lines).T).mean()
    bias = wide.resolution**2 / (2.0 * c)  # 3.6e-3, to first order
    assert_allclose(radius - c, -bias, atol=0.3 * bias)


def test_falling_balls_heaps_and_voids_do_not_make_a_surface():
    places, areas = packed_bed(A, LENGTH, 0.0, height=-0.1)
    clean = surface_contour(places[:, [0, 2]], areas, CIRCLE, Grid())
    generator = np.random.default_rng(5)
    rain = generator.uniform([-0.6, 0.2], [0.6, 0.7], (150, 2))
    heap = generator.uniform([0.55, 0.5], [0.68, 0.6], (150, 2))
    void = np.hypot(places[:, 0], places[:, 2] + 0.5) < 0.1
    centres = np.vstack([places[~void][:, [0, 2]], rain, heap])
    weights = np.append(areas[~void], np.full(300, areas[0]))
    busy = surface_contour(centres, weights, CIRCLE, Grid())
    assert len(busy.lines) == len(clean.lines) == 1
    assert_allclose(
        points_along(busy.lines)[:, 1].mean(), points_along(clean.lines)[:, 1].mean(), atol=1e-3
    )


def test_second_method_agrees_to_a_ball_radius():
    places, _areas = packed_bed(A, LENGTH, 0.3, height=-0.2)
    rain = np.random.default_rng(1).uniform([-0.5, 0.0, 0.1], [0.5, LENGTH, 0.6], (60, 3))
    points = first_gaps(np.vstack([places, rain]), A, LENGTH, lifter_tops=0.99)
    height = points @ np.array([-np.sin(0.3), np.cos(0.3)])
    assert abs(np.median(height) + 0.2) < A
    assert len(points) > 30


def test_no_ball_has_no_surface():
    with pytest.raises(ValueError, match="no balls"):
        surface_contour(np.empty((0, 2)), np.empty(0), CIRCLE, Grid())
