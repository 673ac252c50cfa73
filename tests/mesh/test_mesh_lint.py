from dataclasses import replace

import numpy as np
import pytest

from millscale import _core
from millscale.mesh import build_liner_mesh, default_chord_error, lint, read_stl, write_stl

LENGTH, CHORD_ERROR = 1.0, 5e-4


@pytest.fixture(scope="module")
def mesh(physical):
    return build_liner_mesh(physical, LENGTH, CHORD_ERROR)


def problems(mesh, *arguments):
    report = lint(mesh, *arguments)
    assert report.ok == (report.problems == ())
    return "\n".join(report.problems)


def with_triangles(mesh, triangles):
    return replace(mesh, triangles=triangles, faces=mesh.faces[: len(triangles)])


@pytest.mark.parametrize("divisions", [1, 3])
def test_meshes_of_this_package_are_clean(liner, divisions):
    chord_error = 1e-4 * liner.radius
    mesh = build_liner_mesh(liner, 0.5 * liner.radius, chord_error, divisions)
    report = lint(mesh, liner, 0.5 * liner.radius, chord_error)
    assert report.problems == ()
    assert report.warnings == ()
    assert report.deviation_m < 1e-14 * liner.radius
    assert 0.5 * chord_error < report.chord_error_m <= chord_error


def test_all_mills_of_table_4_are_clean_down_to_small_chord_errors(table4_mill):
    mill, S = table4_mill
    for chord_error in (default_chord_error(0.02, S), 5e-6):
        for length in (1.0, 1.0 / S):
            report = lint(build_liner_mesh(mill, length, chord_error), mill, length, chord_error)
            assert report.problems == ()
            assert report.curvature_deg > 0.0


def test_report_of_the_physical_mill(mesh, physical):
    report = lint(mesh, physical, LENGTH, CHORD_ERROR)
    assert (report.nodes, report.triangles) == (450, 450)
    assert (report.y_min_m, report.y_max_m) == (0.0, 1.0)


def test_a_missing_triangle_is_found(mesh):
    assert "not closed in cross-section" in problems(with_triangles(mesh, mesh.triangles[1:]))


def test_a_missing_strip_is_found(mesh):
    text = problems(with_triangles(mesh, mesh.triangles[2:]))
    assert "not closed in cross-section: 2 open edges" in text


def test_a_repeated_triangle_is_found(mesh):
    extra = replace(
        mesh,
        triangles=np.vstack([mesh.triangles, mesh.triangles[7]]),
        faces=np.append(mesh.faces, mesh.faces[7]),
    )
    text = problems(extra)
    assert "same three nodes: 7, 450" in text
    assert "more than two triangles" in text


def test_a_turned_triangle_is_found(mesh):
    triangles = mesh.triangles.copy()
    triangles[5] = triangles[5, ::-1]
    # Two of its sides are shared, the third lies on an end.
    assert "opposite normals: 2 edges" in problems(with_triangles(mesh, triangles))


def test_an_inside_out_mesh_is_found(mesh):
    assert "normals point out" in problems(with_triangles(mesh, mesh.triangles[:, ::-1]))


def test_a_degenerate_triangle_is_found(mesh):
    triangles = mesh.triangles.copy()
    triangles[11, 1] = triangles[11, 0]
    assert "without area: 11" in problems(with_triangles(mesh, triangles))


def test_nodes_the_engine_would_merge_are_found(mesh):
    nodes = np.vstack([mesh.nodes, mesh.nodes[0] + 5e-9])
    assert "precision of 1e-08 m" in problems(replace(mesh, nodes=nodes))


def test_ends_that_do_not_match_are_found(mesh, physical):
    nodes = mesh.nodes.copy()
    far = nodes[:, 1] == LENGTH
    nodes[far, 0] += 1e-3
    text = problems(replace(mesh, nodes=nodes), physical)
    assert "ends do not match" in text
    assert "off the liner" in text


def test_axial_extent_must_be_the_boxs(mesh, physical):
    moved = replace(mesh, nodes=mesh.nodes + np.array([0.0, 1e-12, 0.0]))
    assert "axial extent" in problems(moved, physical, LENGTH)
    assert "axial extent" in problems(mesh, physical, 0.99)


def test_a_mesh_coarser_than_requested_is_found(mesh, physical):
    assert "off the liner, accepted are 0.0001 m" in problems(mesh, physical, LENGTH, 1e-4)


def test_needles_are_judged_by_the_engines_limits(physical):
    # Chords of 0.1 m over an axis of 15 m: 0.4 degrees; over 150 m: 0.04 degrees.
    warned = lint(build_liner_mesh(physical, 15.0, CHORD_ERROR), physical)
    assert any("warns below 0.5" in text for text in warned.warnings)
    stopped = problems(build_liner_mesh(physical, 150.0, CHORD_ERROR), physical)
    assert "the engine stops below 0.0573" in stopped


def test_curvature_without_a_value_is_a_problem(physical):
    assert "curvature: no value" in problems(build_liner_mesh(physical, 4.0, 5e-5), physical)


def test_a_users_file_is_checked_with_or_without_a_liner(mesh, physical, tmp_path):
    write_stl(tmp_path / "liner.stl", mesh)
    user = read_stl(tmp_path / "liner.stl")
    with_liner = lint(user, physical, LENGTH, CHORD_ERROR)
    assert with_liner.ok
    assert with_liner.curvature_deg == lint(mesh, physical).curvature_deg
    without = lint(user)
    assert without.ok
    assert without.deviation_m is None
    assert without.curvature_deg is None
    assert "lifter edges are not known" in without.warnings[0]


def test_single_precision_is_good_enough_for_a_users_file(mesh, physical):
    nodes = mesh.nodes.astype(np.float32).astype(float)
    assert lint(replace(mesh, nodes=nodes), physical, LENGTH, 1.01 * CHORD_ERROR).ok


def test_a_users_file_of_another_mill_is_found(mesh, tmp_path):
    other = _core.Lifters(3.9, 3.6, 0.25, 0.635, 25)
    assert "off the liner" in problems(mesh, other)
