import math
from itertools import pairwise

import pytest
from numpy.testing import assert_allclose

from millscale import _core
from millscale.mesh import build_liner_mesh, curvature_deg, default_chord_error, read_stl, write_stl
from millscale.mesh.curvature import curvature_range_deg


def chord_fold_deg(liner, chord_error):
    """Return the fold angle between two chords of a groove, from their number."""
    _, kinds = liner.polygon(chord_error)
    chords = (kinds == 0).sum() // liner.lifters
    return math.degrees(2.0 * math.asin(0.5 * liner.groove_width / liner.radius) / chords)


def test_lower_limit_is_the_fold_between_chords(table4_mill):
    mill, S = table4_mill
    for chord_error in (default_chord_error(0.02, S), 5e-5, 5e-6):
        lower, _ = curvature_range_deg(build_liner_mesh(mill, 1.0, chord_error))
        assert_allclose(lower, chord_fold_deg(mill, chord_error), rtol=1e-9)


def test_upper_limit_is_the_flattest_triangle_of_axis_long_panels(physical):
    profile, _ = physical.polygon(5e-4)
    shortest = min(math.dist(a, b) for a, b in pairwise(profile))
    _, upper = curvature_range_deg(build_liner_mesh(physical, 1.0, 5e-4))
    assert_allclose(upper, math.degrees(math.atan(shortest)), rtol=1e-9)


def test_value_separates_arc_panels_from_lifter_edges(table4_mill):
    mill, S = table4_mill
    for length in (1.0, 1.0 / S):
        mesh = build_liner_mesh(mill, length, default_chord_error(0.02, S))
        lower, upper = curvature_range_deg(mesh)
        assert lower < curvature_deg(mesh) < upper < 60.0


def test_flat_lifters_limit_the_value_by_their_edges():
    # Faces at 89 degrees from the centre line: the top's edges fold by 1 degree.
    liner = _core.Lifters.from_face_angle(1.0, 0.99, 0.1, math.radians(89.0), 3)
    mesh = build_liner_mesh(liner, 0.01, 1e-5)
    _, upper = curvature_range_deg(mesh)
    assert_allclose(upper, 1.0, rtol=1e-6)
    assert curvature_deg(mesh) < 1.0


def test_single_chord_grooves_need_no_lower_limit():
    liner = _core.Lifters(1.0, 0.9, 0.05, 0.1, 25)
    mesh = build_liner_mesh(liner, 0.1, 0.01)
    lower, upper = curvature_range_deg(mesh)
    assert lower == 0.0
    assert curvature_deg(mesh) == 0.5 * upper


def test_a_mill_longer_than_its_radius_needs_axial_divisions(physical):
    # A chord folds by c / R and its axis-long triangle has the angle c / L.
    long_panels = build_liner_mesh(physical, 4.0, 5e-5)
    with pytest.raises(ValueError, match="use more axial divisions"):
        curvature_deg(long_panels)
    curvature_deg(build_liner_mesh(physical, 4.0, 5e-5, axial_divisions=2))


def test_unknown_faces_give_no_value(physical, tmp_path):
    write_stl(tmp_path / "liner.stl", build_liner_mesh(physical, 1.0, 5e-4))
    with pytest.raises(ValueError, match="faces"):
        curvature_deg(read_stl(tmp_path / "liner.stl"))
