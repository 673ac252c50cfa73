"""The engine's keyword `curvature`: which neighbouring triangles are one surface."""

import math

import numpy as np

from millscale.mesh.engine_limits import CURVATURE_MAX_DEG
from millscale.mesh.liner_mesh import (
    GROOVE,
    UNKNOWN,
    LinerMesh,
    folds_deg,
    shared_edges,
    smallest_angles_deg,
)

# Flat pieces fold by rounding only, and any curvature covers that.
UNRESOLVED_DEG = 1e-4


def curvature_deg(mesh: LinerMesh) -> float:
    """Angle for `curvature` [degrees] that tells arc panels from lifter edges.

    Between neighbours that fold by less, the engine carries the shear history over and counts one
    contact. So it must exceed the fold between the chords of a groove, stay below the fold at every
    lifter edge, and, as the engine demands, below the smallest angle of any triangle (and 60). The
    value is the geometric mean of the limits, or half the upper one if there is no lower one.

    Raises ValueError if no value fits, or if the faces of the mesh are not known.
    """
    lower, upper = curvature_range_deg(mesh)
    if not lower * (1.0 + 1e-6) < upper:
        smallest = float(smallest_angles_deg(mesh).min())
        raise ValueError(
            f"curvature: no value lies above the fold between the chords of a groove "
            f"({lower:.4g} degrees) and below {upper:.4g} degrees, the least of the folds at the "
            f"lifter edges, 60 degrees and the smallest angle of a triangle ({smallest:.4g}). "
            "Triangles too long and thin: use more axial divisions. "
            "Chords that fold like lifter edges: use a smaller chord error"
        )
    return between_deg(lower, upper)


def between_deg(lower: float, upper: float) -> float:
    """The value taken between two limits, which fit [degrees]."""
    return math.sqrt(lower * upper) if lower > 0.0 else 0.5 * upper


def curvature_range_deg(mesh: LinerMesh) -> tuple[float, float]:
    """Open interval (lower, upper) of values for `curvature` [degrees]."""
    if (mesh.faces == UNKNOWN).any():
        raise ValueError("curvature: the faces of the mesh are not known; lint it with its liner")
    edges = shared_edges(mesh)
    folds = folds_deg(mesh, edges)
    one, other = mesh.faces[edges.triangles].T
    same = one == other
    within_groove = folds[same & (one == GROOVE)]
    lower = float(within_groove.max(initial=0.0))
    lower = lower if lower > UNRESOLVED_DEG else 0.0
    upper = np.concatenate([folds[~same], smallest_angles_deg(mesh), [CURVATURE_MAX_DEG]])
    return lower, float(upper.min())
