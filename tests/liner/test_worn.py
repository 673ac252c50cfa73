"""Worn outlines: depths against closed forms, edges, worn-off lifters, files that are read back."""

import math

import numpy as np
import pytest
from shapely import LineString, Point

from liner_files import families, shape_of, trapezoids
from millscale import _core
from millscale.liner.csv_table import read_csv
from millscale.liner.given import Source, liner_from_file
from millscale.liner.worn import Wear, outline_of, worn_liner

EVEN = np.linspace(0.0, 1.0, 51)


def even(depth, smoothing=0.0, plate=None):
    """The same wear everywhere."""
    return Wear(EVEN, np.full(50, depth), smoothing, plate)


def drum(radius=1.0):
    return _core.Lifters(radius, 0.0, 0.0, 0.0, 0)


def test_an_even_wear_of_a_drum_is_a_larger_drum():
    worn = worn_liner(drum(), even(0.03))
    assert worn.radius == pytest.approx(1.03, abs=2e-5)
    assert worn.removed == pytest.approx(math.pi * (1.03**2 - 1.0), rel=1e-3)
    assert worn.height < 1e-4


def test_the_pitch_of_an_outline_is_that_of_the_profile():
    for liner in (trapezoids(), shape_of(families()["hi-lo"]), drum()):
        outline = outline_of(liner)
        again = _core.Profile(list(liner.nodes), liner.sectors, 0.0)
        assert outline.pieces in (len(again.nodes), 4)
        turned = np.linalg.norm(outline.points, axis=1)
        assert turned[0] == pytest.approx(turned[-1])


@pytest.mark.parametrize("name", sorted(families()))
def test_an_even_wear_is_everywhere_as_deep(name):
    liner, depth = shape_of(families()[name]), 0.004
    worn = worn_liner(liner, even(depth))
    at_rest = _core.Profile(list(liner.nodes), liner.sectors, 0.0)
    # x and z in the cross-section of a point along and across the middle of groove 0.
    ends = worn.outline.points
    points = -np.vstack([ends, 0.5 * (ends[1:] + ends[:-1])])[:, ::-1]
    distance = at_rest.nearest(points).distance
    np.testing.assert_allclose(distance, -depth, atol=6e-5)
    assert worn.removed * liner.sectors == pytest.approx(worn.profile.area - liner.area, rel=1e-3)


@pytest.mark.parametrize("depth", [1e-4, 3e-4, 6e-4, 1e-3, 2e-3, 3e-3, 5e-3, 1e-2])
def test_the_fillet_of_a_worn_corner_is_no_groove(depth):
    """The front rounds a concave corner with the depth of wear."""
    liner = trapezoids()
    worn = worn_liner(liner, even(depth * liner.radius))
    assert worn.profile.narrowest_width > 0.95 * liner.narrowest_width


def test_wear_of_the_tops_lowers_the_lifters():
    liner = trapezoids()
    # The top is the first piece of the sector, and the rest of it are two faces and an arc.
    top = math.dist(liner.nodes[0][:2], liner.nodes[1][:2])
    face = math.dist(liner.nodes[1][:2], liner.nodes[2][:2])
    arc = 2.0 * math.asin(0.5 * math.dist(liner.nodes[2][:2], liner.nodes[3][:2]))
    share = top / (top + 2.0 * face + arc)
    edges = np.concatenate([np.linspace(0.0, share, 9)[:-1], np.linspace(share, 1.0, 60)])
    worn = worn_liner(liner, Wear(edges, np.repeat([0.02, 0.0], [8, 59]), 0.0))
    # Horns are left at the edges, because the faces do not wear.
    ray = LineString([(0.0, 0.0), (2.0 * math.cos(math.pi / 8), 2.0 * math.sin(math.pi / 8))])
    middle = LineString(worn.outline.points).intersection(ray).distance(Point(0.0, 0.0))
    assert middle == pytest.approx(0.92 + 0.02, abs=1e-4)
    assert worn.radius == pytest.approx(1.0, abs=1e-6)
    assert worn.deepest == 0.02


def test_the_plate_below_a_lifter_that_is_worn_off_is_the_thicker():
    worn = worn_liner(trapezoids(), even(0.1))
    foot = math.pi / 8 - math.asin(0.3)
    # The fronts of both faces meet in the middle of the lifter.
    share = np.linspace(0.0, 1.0, 10_001)
    along = 0.92 + share * (math.cos(foot) - 0.92)
    across = 0.03 + share * (math.sin(foot) - 0.03)
    ridge = (along + np.sqrt(0.1**2 - across**2)).max()
    assert worn.radius == pytest.approx(1.1, abs=1e-4)
    assert worn.height == pytest.approx(1.1 - ridge, abs=2e-4)


def test_a_plate_that_is_worn_through_ends_the_wear():
    worn = worn_liner(trapezoids(), even(0.02, plate=0.01))
    assert worn.is_through
    assert worn.radius == pytest.approx(1.01, abs=1e-4)
    assert not worn_liner(trapezoids(), even(0.005, plate=0.01)).is_through


def test_smoothing_keeps_the_volume():
    depth = np.zeros(200)
    depth[90:110] = 0.004
    edges = np.linspace(0.0, 1.0, 201)
    sharp, smooth = (worn_liner(drum(), Wear(edges, depth, width)) for width in (0.0, 0.3))
    assert smooth.removed == pytest.approx(sharp.removed, rel=0.005)
    assert smooth.deepest < 0.9 * sharp.deepest


@pytest.mark.parametrize("name", ["rib", "hi-lo", "ship-lap"])
def test_a_campaign_reads_the_file(tmp_path, name):
    liner = shape_of(families(3.0)[name], 3.0)
    worn = worn_liner(liner, even(0.01, smoothing=0.03))
    path = tmp_path / "worn.csv"
    path.write_text(worn.text("of a test"))
    assert read_csv(path).pieces == worn.outline.pieces
    source = Source(path, turns="counter-clockwise")
    given = liner_from_file(source, worn.radius, 0.0)
    assert given.shape.radius == pytest.approx(worn.radius, rel=1e-12)
    assert given.shape.area == pytest.approx(worn.profile.area, rel=1e-7)
    assert given.shape.sectors == liner.sectors


def test_no_wear_leaves_the_liner():
    liner = trapezoids()
    worn = worn_liner(liner, even(0.0))
    assert worn.removed == pytest.approx(0.0, abs=1e-4)
    assert worn.height == pytest.approx(0.08, abs=1e-4)
    assert math.degrees(worn.leading_angle) == pytest.approx(
        math.degrees(liner.face_angle), abs=0.1
    )
    assert math.isnan(worn_liner(drum(), even(0.01)).leading_angle)
    step = worn_liner(shape_of(families()["ship-lap"]), even(0.0))
    assert math.degrees(step.leading_angle) == pytest.approx(20.0, abs=0.5)
