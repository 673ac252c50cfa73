import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from millscale.mesh import LinerMesh, build_liner_mesh, read_stl, write_stl
from millscale.mesh.stl import _BINARY_RECORD


@pytest.fixture
def mesh(physical):
    return build_liner_mesh(physical, 1.0 / 3.0, 5e-4, axial_divisions=2)


def write_binary(path, corners):
    records = np.zeros(len(corners), _BINARY_RECORD)
    records["corners"] = corners
    path.write_bytes(
        b"solid facet".ljust(80) + np.uint32(len(corners)).tobytes() + records.tobytes()
    )


def test_text_round_trip_keeps_every_bit(mesh, tmp_path):
    path = tmp_path / "liner.stl"
    write_stl(path, mesh)
    back = read_stl(path)
    assert_array_equal(back.corners, mesh.corners)
    assert len(back.nodes) == len(mesh.nodes)
    assert set(back.faces) == {-1}


def test_same_mesh_writes_the_same_bytes(mesh, tmp_path):
    for name in ("one.stl", "other.stl"):
        write_stl(tmp_path / name, mesh)
    assert (tmp_path / "one.stl").read_bytes() == (tmp_path / "other.stl").read_bytes()


def test_begins_with_solid_as_the_engine_expects_of_text(mesh, tmp_path):
    write_stl(tmp_path / "liner.stl", mesh)
    lines = (tmp_path / "liner.stl").read_text().splitlines()
    assert lines[0].split()[0] == "solid"
    assert len(lines) == 2 + 7 * len(mesh.triangles)


def test_text_in_upper_case_is_text(mesh, tmp_path):
    path = tmp_path / "liner.stl"
    write_stl(path, mesh)
    path.write_text(path.read_text().upper())
    assert_array_equal(read_stl(path).corners, mesh.corners)


def test_binary_files_are_read_in_their_precision(mesh, tmp_path):
    path = tmp_path / "binary.stl"
    write_binary(path, mesh.corners)
    back = read_stl(path)
    assert_allclose(back.corners, mesh.corners, rtol=6e-8, atol=1e-9)
    assert len(back.nodes) == len(mesh.nodes)


def test_corners_within_the_precision_become_one_node(mesh, tmp_path):
    noise = np.random.default_rng(3).uniform(-2e-9, 2e-9, mesh.corners.shape)
    separate = np.arange(3 * len(mesh.triangles)).reshape(-1, 3)
    noisy = LinerMesh((mesh.corners + noise).reshape(-1, 3), separate, mesh.faces)
    write_stl(tmp_path / "noisy.stl", noisy)
    back = read_stl(tmp_path / "noisy.stl")
    assert len(back.nodes) == len(mesh.nodes)
    assert_allclose(back.corners, mesh.corners, atol=1e-8)


@pytest.mark.parametrize(
    ("content", "text"),
    [
        (b"", "neither text STL nor binary"),
        (b"solid x\nfacet\nvertex 0 0\n", "multiple of 3"),
        (b"solid x\nfacet\nvertex 0 0 zero\nvertex 0 0 1\nvertex 0 1 1\nendsolid", "three numbers"),
        (b"solid x\nfacet\nvertex 0 0 0\nvertex 0 0 1\nvertex 0 1 1\n", "cut short: no endsolid"),
        (b"solid x\nfacet\nendsolid x\n", "no triangle"),
        (b"solid x\nfacet\nvertex 0 0 nan\nvertex 0 0 1\nvertex 0 1 1\nendsolid", "finite"),
        (b"\0" * 80 + b"\1\0\0\0" + b"\0" * 49, "1 triangles"),
    ],
)
def test_damaged_files_are_refused_with_the_cause(tmp_path, content, text):
    path = tmp_path / "broken.stl"
    path.write_bytes(content)
    with pytest.raises(ValueError, match=text) as error:
        read_stl(path)
    assert "broken.stl" in str(error.value)


def test_other_file_extensions_are_refused_because_the_engine_reads_them(mesh, tmp_path):
    with pytest.raises(ValueError, match=r"ending in \.stl"):
        write_stl(tmp_path / "liner.txt", mesh)
