import math

import mill_core
import numpy as np
import pytest
from paper_campaign import MULTI_BALL, cases

from liner_mesh import build_liner_mesh, curvature_deg, lint
from mill_campaign.charge import liner_of
from mill_campaign.wall_panels import distance, first_contact_below, panels_of


@pytest.mark.parametrize("divisions", [1, 3])
def test_panels_are_those_of_the_mesh(tmp_path, divisions):
    for case in cases(tmp_path, **MULTI_BALL, wall__axial_divisions=divisions)[::3]:
        wall, length = case["wall"], case["mill"]["simulated_length_m"]
        mesh = build_liner_mesh(liner_of(case), length, wall["chord_error_m"], divisions)
        assert wall["triangles"] == len(mesh.triangles)
        assert wall["curvature_deg"] == pytest.approx(curvature_deg(mesh), rel=1e-9)
        panels = panels_of(liner_of(case), length, wall["chord_error_m"], divisions)
        assert lint(panels, liner_of(case), length, wall["chord_error_m"]).ok
        # The same corners, whatever the order and the diagonals.
        rounded = [np.unique(np.round(x.nodes, 9), axis=0) for x in (mesh, panels)]
        np.testing.assert_allclose(*rounded, rtol=0.0, atol=2e-9)


def test_a_plain_drum_is_one_surface(tmp_path):
    case = cases(tmp_path, liner=None)[0]
    nodes, _ = mill_core.Liner(3.9, 0.0, 0.0, 0.0, 0).polygon(case["wall"]["chord_error_m"])
    assert case["wall"]["curvature_deg"] > 360.0 / len(nodes)


def test_chord_error_is_given_for_the_physical_mill(tmp_path):
    found = cases(tmp_path, wall__chord_error_m=2e-3)
    assert [case["wall"]["chord_error_m"] for case in found[:2]] == [2e-3, 2e-3 / 2.6]


def test_meshes_of_all_models_are_similar(tmp_path):
    found = cases(tmp_path, scaling__S=[1.0, 1.3, 2.6])
    assert len({case["wall"]["triangles"] for case in found}) == 1


def test_axial_divisions_multiply_the_triangles(tmp_path):
    one, three = (cases(tmp_path, wall__axial_divisions=n)[0]["wall"]["triangles"] for n in (1, 3))
    assert three == 3 * one


def test_distance_from_a_square_is_that_of_sides_and_corners():
    square = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    points = np.array([[0.0, 0.0], [0.5, 0.0], [2.0, 0.0], [2.0, 2.0], [1.0, 1.0]])
    assert distance(square, points) == pytest.approx([1.0, 0.5, 1.0, math.sqrt(2.0), 0.0])


@pytest.mark.parametrize("phase_deg", [0.0, 1.7, 3.6, 7.2, 11.0])
@pytest.mark.parametrize("S", [1.0, 2.6, 40.0])
def test_the_first_contact_below_is_where_a_disc_let_down_stops(phase_deg, S):
    liner = mill_core.Liner(3.9, 3.61, 0.25, 0.635, 25, math.radians(phase_deg)).scaled(S)
    nodes, _ = liner.polygon(5e-4 / S)
    z = first_contact_below(nodes, 0.02)
    # The whole way down is free, and at its end the disc touches, to rounding of the mill's size.
    way = np.linspace(0.0, z, 2001)
    gaps = distance(nodes, np.column_stack([np.zeros_like(way), way]))
    assert gaps[:-1].min() > 0.02 - 1e-12
    assert gaps[-1] == pytest.approx(0.02, abs=1e-12)


def test_nothing_below_is_an_error():
    with pytest.raises(ValueError, match="no part of the polygon"):
        first_contact_below(np.array([[-1.0, 1.0], [1.0, 1.0], [0.0, 2.0]]), 0.02)
