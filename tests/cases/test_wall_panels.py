import math

import numpy as np
import pytest

from millscale import _core
from millscale.cases.wall_panels import distance, first_contact_below, panels_of
from millscale.errors import CampaignError
from millscale.mesh import build_liner_mesh, curvature_deg, lint
from millscale.mesh.curvature import curvature_range_deg
from millscale.mesh.panels import panel_range_deg
from millscale.runs.liner import liner_of
from paper_campaign import MULTI_BALL, cases


@pytest.mark.parametrize("divisions", [1, 3])
def test_panels_are_those_of_the_mesh(tmp_path, divisions):
    wall = {"wall": {"kind": "mesh", "axial_divisions": divisions}}
    for case in cases(tmp_path, **MULTI_BALL, **wall)[::3]:
        wall, length = case.wall, case.mill.simulated_length_m
        mesh = build_liner_mesh(liner_of(case.mill), length, wall.chord_error_m, divisions)
        assert wall.triangles == len(mesh.triangles)
        assert wall.curvature_deg == pytest.approx(curvature_deg(mesh), rel=1e-9)
        panels = panels_of(liner_of(case.mill), length, wall.chord_error_m, divisions)
        assert lint(panels, liner_of(case.mill), length, wall.chord_error_m).ok
        # The same corners, whatever the order and the diagonals.
        rounded = [np.unique(np.round(x.nodes, 9), axis=0) for x in (mesh, panels)]
        np.testing.assert_allclose(*rounded, rtol=0.0, atol=2e-9)


def test_a_plain_drum_is_one_surface(tmp_path):
    case = cases(tmp_path, liner=None, wall__kind="mesh")[0]
    nodes, _ = _core.Lifters(3.9, 0.0, 0.0, 0.0, 0).polygon(case.wall.chord_error_m)
    assert case.wall.curvature_deg > 360.0 / len(nodes)


def test_chord_error_is_given_for_the_physical_mill(tmp_path):
    found = cases(tmp_path, wall__chord_error_m=2e-3)
    assert [case.wall.chord_error_m for case in found[:2]] == [2e-3, 2e-3 / 2.6]


def test_meshes_of_all_scaled_mills_are_similar(tmp_path):
    found = cases(tmp_path, scaling__S=[1.0, 1.3, 2.6])
    assert len({case.wall.triangles for case in found}) == 1


def test_axial_divisions_multiply_the_triangles(tmp_path):
    one, three = (cases(tmp_path, wall__axial_divisions=n)[0].wall.triangles for n in (1, 3))
    assert three == 3 * one


# A common industrial mill, 4.7 m by 7.2 m, and a drum 80 balls wide.
LONG = {"mill__radius_m": 2.35, "mill__length_m": 7.2, "liner": None}
SLENDER = {
    "mill__radius_m": 0.12,
    "mill__length_m": 0.36,
    "liner": None,
    "ball__radius_m": 0.0015,
    "scaling__S": [4.0],
    "single_ball": None,
    "multi_ball": {"filling": 0.3, "slice_diameters": 10.0, "rotation_angle_rad": 1.0},
}
# Lifters whose tops are a thousandth of the mill's radius.
SHARP = {
    "mill__radius_m": 1.0,
    "liner": {
        "lifters": 20,
        "lifter_top_radius_m": 0.93,
        "lifter_top_width_m": 0.001,
        "face_angle_deg": 30.0,
    },
    "ball__radius_m": 0.03,
    "scaling__S": [1.0],
}


@pytest.mark.parametrize("mill", [LONG, SLENDER, SHARP])
def test_an_analytic_wall_needs_no_panels_that_the_engine_takes(tmp_path, mill):
    for case in cases(tmp_path, **mill):
        assert case.wall.curvature_deg is None
        assert case.wall.axial_divisions == 1


@pytest.mark.parametrize("mill", [LONG, SLENDER, SHARP])
def test_the_program_finds_axial_divisions_that_the_engine_takes(tmp_path, mill):
    for case in cases(tmp_path, **mill, wall__kind="mesh"):
        wall, length = case.wall, case.mill.simulated_length_m
        args = length, wall.chord_error_m
        panels = panels_of(liner_of(case.mill), *args, wall.axial_divisions)
        report = lint(panels, liner_of(case.mill), *args)
        assert report.ok, report.problems
        assert wall.curvature_deg == pytest.approx(report.curvature_deg, rel=1e-9)
        assert wall.triangles == len(panels.triangles)
        # One division fewer is refused.
        if wall.axial_divisions > 1:
            fewer = panels_of(liner_of(case.mill), *args, wall.axial_divisions - 1)
            assert not lint(fewer, liner_of(case.mill), *args).ok


@pytest.mark.parametrize(("given", "accepted"), [(1, False), (10, False), (40, True), (400, False)])
def test_axial_divisions_that_do_not_fit_are_refused_with_some_that_do(tmp_path, given, accepted):
    mill = {**SHARP, "mill__length_m": 0.36, "single_ball__step_s": "advised"}
    wall = {"wall": {"kind": "mesh", "axial_divisions": given}}
    if accepted:
        assert cases(tmp_path, **mill, **wall)[0].wall.axial_divisions == given
        return
    with pytest.raises(CampaignError, match=f"got {given}, S = 1: the folds") as refused:
        cases(tmp_path, **mill, **wall)
    works = int(refused.value.accepted.split(",")[0])
    wall = {"wall": {"kind": "mesh", "axial_divisions": works}}
    assert cases(tmp_path, **mill, **wall)[0].wall.axial_divisions == works


@pytest.mark.parametrize("mill", [LONG, SHARP, {}])
@pytest.mark.parametrize("divisions", [1, 2, 7, 40])
def test_the_range_of_curvature_needs_no_mesh(tmp_path, mill, divisions):
    case = cases(tmp_path, **mill)[0]
    length, error = case.mill.simulated_length_m, case.wall.chord_error_m
    of_mesh = curvature_range_deg(panels_of(liner_of(case.mill), length, error, divisions))
    profile, kinds = liner_of(case.mill).polygon(error)
    assert panel_range_deg(profile, kinds, length / divisions) == pytest.approx(of_mesh, rel=1e-9)


def test_distance_from_a_square_is_that_of_sides_and_corners():
    square = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    points = np.array([[0.0, 0.0], [0.5, 0.0], [2.0, 0.0], [2.0, 2.0], [1.0, 1.0]])
    assert distance(square, points) == pytest.approx([1.0, 0.5, 1.0, math.sqrt(2.0), 0.0])


@pytest.mark.parametrize("phase_deg", [0.0, 1.7, 3.6, 7.2, 11.0])
@pytest.mark.parametrize("S", [1.0, 2.6, 40.0])
def test_the_first_contact_below_is_where_a_disc_let_down_stops(phase_deg, S):
    liner = _core.Lifters(3.9, 3.61, 0.25, 0.635, 25, math.radians(phase_deg)).scaled(S)
    nodes, _ = liner.polygon(5e-4 / S)
    z = first_contact_below(nodes, 0.02)
    # The path down is free, and the disc is in contact at its end, to rounding of the mill's size.
    way = np.linspace(0.0, z, 2001)
    gaps = distance(nodes, np.column_stack([np.zeros_like(way), way]))
    assert gaps[:-1].min() > 0.02 - 1e-12
    assert gaps[-1] == pytest.approx(0.02, abs=1e-12)


def test_nothing_below_is_an_error():
    with pytest.raises(ValueError, match="no part of the polygon"):
        first_contact_below(np.array([[-1.0, 1.0], [1.0, 1.0], [0.0, 2.0]]), 0.02)


def test_a_drawing_of_too_many_panels_is_coarser_and_stops_nothing(tmp_path):
    fine = {"wall": {"chord_error_m": 1e-6, "axial_divisions": 1000}}
    wall = cases(tmp_path, **fine)[0].wall
    assert 1_000_000 < wall.triangles <= 2_000_000
    assert wall.chord_error_m == 1e-6 and 1 < wall.axial_divisions < 1000
