"""Contours extrapolated along their normals: arcs of known radii."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from millscale.prediction import contour
from millscale.prediction.contour import displacements, predict_contour
from millscale.prediction.extrapolation import Group, Noise, extrapolate, scale_function
from millscale.runs.untrusted import RunFolderError

RADIUS, SLOPE, EXPONENT, SEED = 0.7, 0.02, 0.5, 5e-4


def arc(radius, points=400):
    turn = np.linspace(-2.0, 0.5, points)
    return radius * np.column_stack([np.cos(turn), np.sin(turn)])


def radius_of(S, seed=0):
    return RADIUS - SLOPE * float(scale_function(S, EXPONENT)) + SEED * seed


@pytest.fixture
def charges(monkeypatch):
    """Charges whose contours are arcs, two seeds at each S."""
    monkeypatch.setattr(contour, "mean_contour", lambda x: arc(radius_of(x.S, x.seed)))

    def some(*ratios, seeds=(-1, 1)):
        return [Charge(S=S, seed=seed) for S in ratios for seed in seeds]

    return some


class Charge(SimpleNamespace):
    __hash__ = object.__hash__


def test_the_displacement_of_two_arcs_is_the_difference_of_their_radii():
    base = arc(0.7)[50:-50]
    normals = base / np.linalg.norm(base, axis=1)[:, None]
    assert_allclose(displacements(base, normals, arc(0.65, 4000)), -0.05, atol=1e-6)
    assert_allclose(displacements(base, -normals, arc(0.72, 4000)), -0.02, atol=1e-6)


def test_a_line_that_is_not_crossed_has_no_displacement():
    base, normals = np.array([[0.0, 0.0]]), np.array([[0.0, 1.0]])
    beside = np.array([[1.0, -1.0], [1.0, 1.0]])
    far = np.array([[-1.0, 0.4], [1.0, 0.4]])
    assert np.isnan(displacements(base, normals, beside)).all()
    assert np.isnan(displacements(base, normals, far)).all()


def test_the_surface_of_the_physical_mill_lies_within_its_interval(charges):
    found = predict_contour(charges(1.7, 2.6), charges(1.0))
    radii = np.linalg.norm(found.points, axis=1)
    assert (np.abs(radii - RADIUS) <= found.half_widths + 1e-4).all()
    assert found.inside == 1.0
    assert found.check[0] < 0.3 * found.nearest[0]
    assert found.nearest[0] == pytest.approx(RADIUS - radius_of(1.7), rel=0.05)


def test_a_surface_outside_its_interval_is_outside(charges, monkeypatch):
    some, physical = charges(1.7, 2.6), charges(1.0)
    away = 1.5 * predict_contour(some).half_widths.mean()
    lines = {x: arc(radius_of(x.S, x.seed) + away * (x.S == 1.0)) for x in (*some, *physical)}
    monkeypatch.setattr(contour, "mean_contour", lines.__getitem__)
    assert predict_contour(some, physical).inside < 0.05


def test_more_noise_widens_the_interval(charges, monkeypatch):
    narrow = predict_contour(charges(1.7, 2.6)).half_widths.mean()
    monkeypatch.setattr(contour, "mean_contour", lambda x: arc(radius_of(x.S, 10 * x.seed)))
    assert predict_contour(charges(1.7, 2.6)).half_widths.mean() > 3.0 * narrow


def test_the_shift_of_each_run_is_its_displacement_towards_the_largest_S(charges):
    found = predict_contour(charges(1.7, 2.6))
    assert [group.S for group in found.shifts] == [1.7, 2.6]
    for group in found.shifts:
        expected = [radius_of(1.7) - radius_of(group.S, seed) for seed in (-1, 1)]
        assert_allclose(group.values, expected, atol=1e-5)
    assert found.noise.deviation == pytest.approx(math.sqrt(2.0) * SEED, rel=0.02)


def test_lengths_of_the_document_are_metres(charges):
    found = predict_contour(charges(1.7, 2.6))
    content = found.document(3.88)
    radius = math.hypot(*content["points_m"][0])
    assert radius == pytest.approx(3.88 * RADIUS, rel=0.01)
    assert content["distance_from_left_out"] is None


def test_a_single_seed_takes_its_noise_from_quarters_of_its_window(charges, monkeypatch):
    """Quarters whose radii have a standard deviation of 4e-3: the mean of four has half of it."""

    offsets = np.array([-3.0, -1.0, 1.0, 3.0])
    radii = radius_of(1.7) + 4e-3 * offsets / np.std(offsets, ddof=1)
    monkeypatch.setattr(contour, "block_contours", lambda _: [arc(radius) for radius in radii])
    found = predict_contour(charges(1.7, 2.6, seeds=(0,)))
    groups = [Group(S, (radius_of(S),)) for S in (1.7, 2.6)]
    by_hand = extrapolate(groups, Noise(2e-3, 6.0)).half_width
    assert found.half_widths.mean() == pytest.approx(by_hand, rel=0.02)


def test_a_window_with_few_dumps_has_no_quarters(monkeypatch):
    monkeypatch.setattr(contour, "_snapshots", lambda _: [None] * 7)
    with pytest.raises(RunFolderError, match="7 dumps in the steady window, 8 are needed"):
        contour.block_contours(SimpleNamespace(folder="x"))
