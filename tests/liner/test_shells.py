"""Shells of triangles: linted, and their cross-section is the liner if they are prismatic."""

import struct

import numpy as np
import pytest

from liner_files import apart, families, shape_of, trapezoids
from millscale.cases.wall_panels import panels_of
from millscale.errors import CampaignError
from millscale.liner.given import Source, liner_from_file
from millscale.mesh import LinerMesh, write_stl
from millscale.mesh.shell import shell_faults

R = 1.0
LENGTH = 0.7


def inner(liner=None, error=1e-4):
    """Return the inner surface of a liner, open at its ends, along y."""
    return panels_of(liner or trapezoids(R), LENGTH, error, 3)


def closed_shell(liner=None):
    """Return a liner as a body: inner surface, outer surface and both ends."""
    one = inner(liner)
    rings = 4
    n = len(one.nodes) // rings
    out = one.nodes * [1.2, 1.0, 1.2]
    outer = one.triangles[:, ::-1] + len(one.nodes)
    i, j = np.arange(n), (np.arange(n) + 1) % n
    last, far = (rings - 1) * n, len(one.nodes)
    caps = [
        np.stack([i, j, far + j], axis=1), np.stack([i, far + j, far + i], axis=1),
        np.stack([last + i, far + last + j, last + j], axis=1),
        np.stack([last + i, far + last + i, far + last + j], axis=1),
    ]  # fmt: skip
    triangles = np.concatenate([one.triangles, outer, *caps])
    return LinerMesh(np.vstack([one.nodes, out]), triangles, np.full(len(triangles), -1))


def read(path, R=R, **more):
    return liner_from_file(Source(path, **{"unit": "mm", **more}), R, 0.0)


def stored(path, mesh, scale=1e3, swap=(0, 1, 2)):
    write_stl(path, LinerMesh(scale * mesh.nodes[:, swap], mesh.triangles, mesh.faces))
    return path


@pytest.mark.parametrize("make", [inner, closed_shell])
@pytest.mark.parametrize("swap", [(0, 1, 2), (0, 2, 1), (1, 0, 2)], ids="yzx")
def test_the_section_of_a_prism_is_the_liner(tmp_path, make, swap):
    given = read(stored(tmp_path / "a.stl", make(), swap=swap))
    assert apart(given.shape, trapezoids(R)) < 4e-4
    # Facets of the grooves are arcs again.
    assert given.shape.sectors == 8 or len(given.shape.nodes) <= 40
    assert "arcs and lines within" in given.warnings[0]


def test_inches_and_asymmetric_lifters(tmp_path):
    liner = shape_of(families(R)["worn"])
    path = stored(tmp_path / "a.stl", inner(liner), scale=1.0 / 0.0254)
    with pytest.raises(CampaignError, match=r"liner\.turns"):
        read(path, unit="in")
    # x to the right and z up: the mill turns from the bottom to the left.
    assert apart(read(path, unit="in", turns="clockwise").shape, liner) < 2e-3
    with pytest.raises(CampaignError, match="the numbers fit if their unit is in"):
        read(path, unit="mm", turns="clockwise")


def test_the_unit_is_asked_for(tmp_path):
    with pytest.raises(CampaignError, match=r"states no unit; accepted: liner\.unit, one of mm"):
        read(stored(tmp_path / "a.stl", inner()), unit=None)


def test_a_shell_that_changes_along_the_axis_is_refused(tmp_path):
    cone = inner()
    taper = 1.0 - 0.01 * cone.nodes[:, 1:2] * np.array([1.0, 0.0, 1.0])
    bent = LinerMesh(cone.nodes * taper, cone.triangles, cone.faces)
    with pytest.raises(CampaignError, match="not prismatic"):
        read(stored(tmp_path / "a.stl", bent))


def test_a_mill_off_the_axis_of_the_file_is_refused(tmp_path):
    mesh = inner()
    moved = LinerMesh(mesh.nodes + np.array([3.0, 0.0, 0.0]), mesh.triangles, mesh.faces)
    with pytest.raises(CampaignError, match="with the axis of the mill on an axis of the file"):
        read(stored(tmp_path / "a.stl", moved))


def without(mesh, *which):
    return LinerMesh(mesh.nodes, np.delete(mesh.triangles, which, axis=0), mesh.faces)


def turned(mesh, which):
    triangles = mesh.triangles.copy()
    triangles[which] = triangles[which, ::-1]
    return LinerMesh(mesh.nodes, triangles, mesh.faces)


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (lambda mesh: without(mesh, 40), "holes: "),
        (lambda mesh: turned(mesh, 40), "opposite normals"),
        (lambda mesh: LinerMesh(mesh.nodes, np.vstack([mesh.triangles, mesh.triangles[:1]]),
                                mesh.faces), "on the same three nodes"),
        (lambda mesh: LinerMesh(mesh.nodes, np.vstack([mesh.triangles, [[0, 0, 1]]]), mesh.faces),
         "without area"),
    ],
)  # fmt: skip
def test_a_shell_with_faults_is_refused_with_the_place(tmp_path, change, text):
    shell = change(closed_shell())
    assert any(text in fault for fault in shell_faults(shell))
    with pytest.raises(CampaignError, match=text) as error:
        read(stored(tmp_path / "a.stl", shell))
    assert "near x = " in str(error.value) and "\n" not in str(error.value)


def test_a_sound_shell_has_no_faults():
    assert shell_faults(closed_shell()) == [] == shell_faults(inner())


def binary(mesh, header):
    corners = (1e3 * mesh.corners).astype("<f4")
    rows = (struct.pack("<12fH", 0, 0, 0, *row.ravel(), 0) for row in corners)
    return header.ljust(80, b" ") + struct.pack("<I", len(corners)) + b"".join(rows)


@pytest.mark.parametrize("header", [b"solid facet", b"STL"])
def test_binary_files_are_read_whatever_their_header(tmp_path, header):
    (tmp_path / "a.stl").write_bytes(binary(closed_shell(), header))
    assert apart(read(tmp_path / "a.stl").shape, trapezoids(R)) < 4e-4


def test_files_cut_short_are_refused(tmp_path):
    text = stored(tmp_path / "good.stl", inner()).read_bytes()
    blob = binary(inner(), b"solid liner")
    for content in (b"", text[: len(text) // 2], blob[: len(blob) // 2], b"solid x\nendsolid x\n"):
        (tmp_path / "a.stl").write_bytes(content)
        with pytest.raises(CampaignError, match=r"a\.stl: .*accepted: a text or binary STL"):
            read(tmp_path / "a.stl")
