import signal

import gmsh
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from millscale.mesh import build_liner_mesh, default_chord_error
from millscale.mesh.liner_mesh import areas, normals

LENGTH = 0.7


@pytest.mark.parametrize("divisions", [1, 3])
def test_every_polygon_edge_becomes_a_strip(liner, divisions):
    profile, kinds = liner.polygon(1e-3)
    mesh = build_liner_mesh(liner, LENGTH, 1e-3, divisions)
    assert mesh.triangles.shape == (2 * divisions * len(profile), 3)
    assert mesh.nodes.shape == ((divisions + 1) * len(profile), 3)
    assert_array_equal(mesh.faces, np.repeat(kinds, 2 * divisions))


def test_nodes_lie_on_the_polygon_and_reach_both_ends_exactly(liner):
    profile, _ = liner.polygon(1e-3)
    mesh = build_liner_mesh(liner, LENGTH, 1e-3)
    assert set(mesh.nodes[:, 1]) == {0.0, LENGTH}
    for end in (0.0, LENGTH):
        nodes = mesh.nodes[mesh.nodes[:, 1] == end][:, [0, 2]]
        assert sorted(map(tuple, nodes)) == sorted(map(tuple, profile))


@pytest.mark.parametrize("divisions", [1, 4])
def test_surface_is_perimeter_times_length(liner, divisions):
    profile, kinds = liner.polygon(1e-3)
    edges = np.linalg.norm(np.roll(profile, -1, axis=0) - profile, axis=1)
    mesh = build_liner_mesh(liner, LENGTH, 1e-3, divisions)
    for kind in range(4):
        expected = edges[kinds == kind].sum() * LENGTH
        assert_allclose(areas(mesh)[mesh.faces == kind].sum(), expected, rtol=1e-12)


def test_normals_point_into_the_cavity_along_the_liners_own(liner):
    chord_error = 1e-4 * liner.radius
    mesh = build_liner_mesh(liner, LENGTH, chord_error)
    middles = np.ascontiguousarray(mesh.corners.mean(axis=1)[:, [0, 2]])
    found = normals(mesh)
    own = liner.nearest(middles).normal
    # A chord's normal deviates from the arc's by at most half the chord's angle.
    flat = mesh.faces != 0
    assert_allclose(found[:, 1], 0.0, atol=1e-14)
    cosine = np.einsum("ij,ij->i", found[:, [0, 2]], own)
    assert_allclose(cosine[~flat], 1.0, atol=2.0 * chord_error / liner.radius)
    outwards = liner.nearest(middles[flat] + 1e-6 * found[flat][:, [0, 2]])
    assert_allclose(outwards.distance, 1e-6, rtol=1e-6)


def test_same_input_gives_the_same_mesh(physical):
    one, other = (build_liner_mesh(physical, LENGTH, 5e-4) for _ in range(2))
    assert_array_equal(one.nodes, other.nodes)
    assert_array_equal(one.triangles, other.triangles)


def test_default_chord_error_gives_all_scaled_mills_similar_meshes(table4_mill, physical):
    mill, S = table4_mill
    reference = build_liner_mesh(physical, 1.0, default_chord_error(0.02))
    mesh = build_liner_mesh(mill, 1.0 / S, default_chord_error(0.02, S))
    assert_array_equal(mesh.triangles, reference.triangles)
    assert_allclose(mesh.nodes * S, reference.nodes, atol=1e-14)


def test_an_interrupt_keeps_its_handler_while_gmsh_works(physical, monkeypatch):
    generate, seen = gmsh.model.mesh.generate, []
    before = signal.signal(signal.SIGINT, signal.default_int_handler)

    def watch(dimension):
        seen.append(signal.getsignal(signal.SIGINT))
        generate(dimension)

    monkeypatch.setattr(gmsh.model.mesh, "generate", watch)
    try:
        build_liner_mesh(physical, LENGTH, 5e-4)
    finally:
        signal.signal(signal.SIGINT, before)
    assert seen == [signal.default_int_handler]


def test_gmsh_is_left_as_it_was_found(physical):
    build_liner_mesh(physical, LENGTH, 5e-4)
    assert not gmsh.isInitialized()

    gmsh.initialize([], readConfigFiles=False, interruptible=False)
    try:
        gmsh.model.add("of somebody else")
        build_liner_mesh(physical, LENGTH, 5e-4)
        assert gmsh.isInitialized()
        assert gmsh.model.getCurrent() == "of somebody else"
    finally:
        gmsh.finalize()


def test_gmsh_is_closed_after_an_error(physical, monkeypatch):
    def fail(*_):
        raise RuntimeError("no surface today")

    monkeypatch.setattr(gmsh.model.geo, "addPlaneSurface", fail)
    with pytest.raises(RuntimeError):
        build_liner_mesh(physical, LENGTH, 5e-4)
    assert not gmsh.isInitialized()


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ((0.0, 5e-4), "length: must be > 0 m, got 0.0"),
        ((float("nan"), 5e-4), "length"),
        ((1.0, 0.0), "chord error"),
        ((1.0, 3.9), "chord error"),
        ((1.0, 5e-4, 0), "axial_divisions: must be a whole number >= 1, got 0"),
        ((1.0, 5e-4, 1.5), "axial_divisions"),
    ],
)
def test_impossible_input_is_refused(physical, arguments, text):
    with pytest.raises(ValueError, match=text):
        build_liner_mesh(physical, *arguments)
