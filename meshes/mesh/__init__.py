"""Triangle meshes of the mill's liner: from cross-section to STL, and checks before a run."""

from millscale.mesh.build import build_liner_mesh, default_chord_error
from millscale.mesh.curvature import curvature_deg
from millscale.mesh.liner_mesh import LinerMesh
from millscale.mesh.lint import LintReport, lint
from millscale.mesh.stl import read_stl, write_stl
from millscale.mesh.vtp import write_vtp

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
