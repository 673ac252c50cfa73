import numpy as np
import pytest
from numpy.testing import assert_array_equal

from millscale.mesh import build_liner_mesh, write_vtp


def test_round_trip_keeps_geometry_and_faces(physical, tmp_path):
    pyvista = pytest.importorskip("pyvista")
    mesh = build_liner_mesh(physical, 1.0, 5e-4)
    write_vtp(tmp_path / "liner.vtp", mesh)
    surface = pyvista.read(tmp_path / "liner.vtp")
    assert_array_equal(np.asarray(surface.points), mesh.nodes)
    assert_array_equal(surface.faces.reshape(-1, 4)[:, 1:], mesh.triangles)
    assert_array_equal(surface.cell_data["face"], mesh.faces)


def test_other_endings_are_refused(physical, tmp_path):
    with pytest.raises(ValueError, match="vtp"):
        write_vtp(tmp_path / "liner.vtk", build_liner_mesh(physical, 1.0, 5e-4))
