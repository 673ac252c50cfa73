"""VTK PolyData of the liner, for looking at it in ParaView. The only module that needs pyvista."""

from pathlib import Path

import numpy as np


def write_vtp(path, mesh):
    """Writes a .vtp file; cell array `face`: 0 groove, 1 leading face, 2 top, 3 trailing face.

    Args:
        path: file to write, ending in .vtp.
        mesh: LinerMesh.
    """
    import pyvista

    path = Path(path)
    if path.suffix != ".vtp":
        raise ValueError(f"{path}: VTK PolyData files end in .vtp")
    cells = np.insert(mesh.triangles, 0, 3, axis=1).ravel()
    surface = pyvista.PolyData(mesh.nodes, cells)
    surface.cell_data["face"] = mesh.faces
    surface.save(path, binary=True)
