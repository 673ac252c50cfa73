"""Triangle meshes of the mill's liner: from cross-section to STL, and checks before a run."""

from liner_mesh.build import build_liner_mesh, default_chord_error
from liner_mesh.curvature import curvature_deg
from liner_mesh.lint import LintReport, lint
from liner_mesh.mesh import LinerMesh
from liner_mesh.stl import read_stl, write_stl
from liner_mesh.vtp import write_vtp

__all__ = [
    "LinerMesh",
    "LintReport",
    "build_liner_mesh",
    "curvature_deg",
    "default_chord_error",
    "lint",
    "read_stl",
    "write_stl",
    "write_vtp",
]
