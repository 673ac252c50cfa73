"""A liner's panels without their mesh: strips of rectangles, each of two triangles."""

import math

import numpy as np

from millscale.mesh.curvature import UNRESOLVED_DEG
from millscale.mesh.engine_limits import CURVATURE_MAX_DEG, SMALLEST_ANGLE_HARD_DEG
from millscale.mesh.liner_mesh import GROOVE


def panel_range_deg(profile: np.ndarray, kinds: np.ndarray, length: float) -> tuple[float, float]:
    """`curvature_range_deg` of the panels of a liner, from its polygon.

    Args:
        profile: (n, 2) float, closed polygon of the liner [m].
        kinds: (n,) int, face of each edge.
        length: of a panel along the axis [m].
    """
    edges = np.roll(profile, -1, axis=0) - profile
    widths = np.linalg.norm(edges, axis=1)
    after = np.roll(edges, -1, axis=0)
    sine = np.abs(edges[:, 0] * after[:, 1] - edges[:, 1] * after[:, 0])
    # The engine compares normals without their sign.
    cosine = np.abs((edges * after).sum(axis=1))
    folds = np.degrees(np.arctan2(sine, cosine))
    same = kinds == np.roll(kinds, -1)
    lower = float(folds[same & (kinds == GROOVE)].max(initial=0.0))
    lower = lower if lower > UNRESOLVED_DEG else 0.0
    short, long = np.minimum(widths, length), np.maximum(widths, length)
    angles = np.degrees(np.arctan2(short, long))
    return lower, float(min([*folds[~same], angles.min(), CURVATURE_MAX_DEG]))


def fewest_divisions(profile: np.ndarray, kinds: np.ndarray, length: float) -> int | None:
    """Fewest panels along the axis with which the engine takes the mesh; None if none do.

    A triangle of a panel of width w and length h has the smallest angle arctan(min(w, h) / max(w,
    h)), which must exceed the fold between the chords of a groove and the engine's least angle. So
    the narrowest panel bounds h from above; `fits` is whether the widest then bears it.

    Args:
        profile, kinds: as of `panel_range_deg`.
        length: of the liner along the axis [m].
    """
    narrowest = np.linalg.norm(np.roll(profile, -1, axis=0) - profile, axis=1).min()
    lower, _ = panel_range_deg(profile, kinds, length)
    steepest = math.tan(math.radians(max(lower * (1.0 + 1e-6), SMALLEST_ANGLE_HARD_DEG)))
    divisions = max(1, math.floor(length * steepest / narrowest) + 1)
    return divisions if fits(*panel_range_deg(profile, kinds, length / divisions)) else None


def fits(lower: float, upper: float) -> bool:
    """Return whether a value of `curvature` lies between its limits and the engine takes it."""
    return lower * (1.0 + 1e-6) < upper and upper >= SMALLEST_ANGLE_HARD_DEG
