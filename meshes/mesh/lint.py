"""Checks of a mesh before the engine reads it: shape, orientation, and the engine's own limits."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from millscale.mesh import engine_limits
from millscale.mesh.curvature import curvature_deg
from millscale.mesh.liner_mesh import (
    UNKNOWN,
    areas,
    edge_counts,
    normals,
    shared_edges,
    smallest_angles_deg,
)


@dataclass(frozen=True)
class LintReport:
    """Result of `lint`. The mesh is fit for use if `ok`.

    Attributes:
        nodes, triangles: counts.
        y_min_m, y_max_m: axial extent [m].
        smallest_angle_deg: of any triangle [degrees].
        deviation_m: largest distance of a node from the liner [m]; None without a liner.
        chord_error_m: largest distance of a triangle from the liner [m]; None without one.
        curvature_deg: value for the engine's keyword; None if none fits, faces are not known, or
            the mesh is not for the engine.
        problems: what makes the mesh unfit, one sentence each.
        warnings: what the engine will complain about, or what could not be checked.
    """

    nodes: int
    triangles: int
    y_min_m: float
    y_max_m: float
    smallest_angle_deg: float
    deviation_m: float | None
    chord_error_m: float | None
    curvature_deg: float | None
    problems: tuple[str, ...]
    warnings: tuple[str, ...]

    @property
    def ok(self):
        return not self.problems


def lint(mesh, liner=None, length=None, chord_error=None, for_engine=True):
    """Checks a mesh, of this package or read from a user's file.

    Args:
        mesh: LinerMesh.
        liner: _core.Profile it should follow; None skips what needs one.
        length: the mill's axial length, y = 0 to length [m]; None accepts any extent.
        chord_error: largest distance accepted between triangles and liner [m]; None accepts any.
        for_engine: whether the engine will read it; its limits of angles do not bind pictures.

    Returns:
        LintReport.
    """
    problems, warnings = [], []
    problems += _broken_triangles(mesh)
    problems += _open_or_inconsistent(mesh)
    problems += _extent(mesh, length)
    deviation = chord = None
    if liner is not None:
        mesh = _with_faces(mesh, liner)
        deviation, chord = _distances(mesh, liner)
        problems += _off_liner(deviation, chord, chord_error, liner.radius)
    angle = float(smallest_angles_deg(mesh).min())
    curvature = None
    if for_engine:
        limits, warned = _engine_angles(angle)
        problems += limits
        warnings += warned
        curvature = _curvature(mesh, problems, warnings)
    y = mesh.nodes[:, 1]
    return LintReport(
        nodes=len(mesh.nodes),
        triangles=len(mesh.triangles),
        y_min_m=float(y.min()),
        y_max_m=float(y.max()),
        smallest_angle_deg=angle,
        deviation_m=deviation,
        chord_error_m=chord,
        curvature_deg=curvature,
        problems=tuple(problems),
        warnings=tuple(warnings),
    )


def _curvature(mesh, problems, warnings):
    """Value for the engine's keyword; None, with a line in one of the lists, if there is none."""
    if (mesh.faces == UNKNOWN).any():
        warnings.append("curvature not determined: without a liner lifter edges are not known")
    elif not problems:
        try:
            return curvature_deg(mesh)
        except ValueError as error:
            problems.append(str(error))
    return None


def _listed(indices):
    """The first few of many indices, for a message."""
    shown = ", ".join(str(i) for i in indices[:5])
    return shown if len(indices) <= 5 else f"{shown}, ... ({len(indices)} in all)"


def _broken_triangles(mesh):
    """Degenerate and repeated triangles, and nodes the engine would merge."""
    problems = []
    t = np.sort(mesh.triangles, axis=1)
    flat = np.flatnonzero((t[:, 0] == t[:, 1]) | (t[:, 1] == t[:, 2]) | (areas(mesh) == 0.0))
    if len(flat):
        problems.append(f"degenerate triangles without area: {_listed(flat)}")
    _, inverse, count = np.unique(t, axis=0, return_inverse=True, return_counts=True)
    twice = np.flatnonzero(count[inverse.ravel()] > 1)
    if len(twice):
        problems.append(f"triangles on the same three nodes: {_listed(twice)}")
    close = cKDTree(mesh.nodes).query_pairs(engine_limits.NODE_PRECISION_M, p=np.inf)
    if close:
        first = min(close)
        problems.append(
            f"nodes closer than the engine's precision of {engine_limits.NODE_PRECISION_M:g} m, "
            f"which it takes for one: {len(close)} pairs, first {first[0]} and {first[1]}"
        )
    return problems


def _open_or_inconsistent(mesh):
    """Open or branching surfaces, ends that do not match, normals that disagree or point out."""
    problems = []
    edges, count = edge_counts(mesh)
    if (count > 2).any():
        problems.append(f"edges with more than two triangles: {int((count > 2).sum())}")
    rim = edges[count == 1]
    y = mesh.nodes[:, 1]
    near = np.all(y[rim] - y.min() <= engine_limits.NODE_PRECISION_M, axis=1)
    far = np.all(y.max() - y[rim] <= engine_limits.NODE_PRECISION_M, axis=1)
    inner = rim[~(near | far)]
    if len(inner):
        place = mesh.nodes[inner[0]].mean(axis=0)
        problems.append(
            f"not closed in cross-section: {len(inner)} open edges between the ends, first near "
            f"x = {place[0]:.4g}, y = {place[1]:.4g}, z = {place[2]:.4g} m"
        )
    problems += _ends(mesh, rim[near], rim[far])
    shared = shared_edges(mesh)
    turned = shared.triangles[~shared.opposed]
    if len(turned):
        problems.append(
            f"neighbours with opposite normals: {len(turned)} edges, first between triangles "
            f"{turned[0, 0]} and {turned[0, 1]}"
        )
    elif not problems and _enclosed_volume(mesh) < 0.0:
        problems.append(
            "normals point out of the mill: the order of every triangle must be reversed"
        )
    return problems


def _ends(mesh, near, far):
    """Both ends must have the same nodes for the axis to be periodic."""
    one, other = (mesh.nodes[np.unique(edges)][:, [0, 2]] for edges in (near, far))
    if len(one) == 0 or len(one) != len(other):
        return [f"ends do not match: {len(one)} and {len(other)} nodes on them"]
    gap = float(cKDTree(one).query(other)[0].max())
    if gap > engine_limits.NODE_PRECISION_M:
        return [f"ends do not match: nodes on them differ by up to {gap:.3g} m"]
    return []


def _enclosed_volume(mesh):
    """Enclosed volume from the flux of position through the side [m^3], > 0 for inward normals."""
    middle = mesh.corners.mean(axis=1)
    n = normals(mesh)
    flux = middle[:, 0] * n[:, 0] + middle[:, 2] * n[:, 2]
    return -0.5 * float(np.sum(areas(mesh) * flux))


def _extent(mesh, length):
    y = mesh.nodes[:, 1]
    if length is None or (y.min() == 0.0 and y.max() == length):
        return []
    return [
        f"axial extent is {y.min():.17g} to {y.max():.17g} m; the box is periodic from 0 to "
        f"{length:.17g} m, and the mesh must end exactly there"
    ]


def _with_faces(mesh, liner):
    """Faces of the liner nearest to the triangles' middles, where they are not known."""
    if not (mesh.faces == UNKNOWN).any():
        return mesh
    middle = np.ascontiguousarray(mesh.corners.mean(axis=1)[:, [0, 2]])
    return replace(mesh, faces=liner.nearest(middle).face)


def _distances(mesh, liner):
    """Largest distances from the liner of nodes, and of middles of triangle sides [m]."""
    corners = mesh.corners[:, :, [0, 2]]
    middles = 0.5 * (corners + np.roll(corners, -1, axis=1)).reshape(-1, 2)
    nodes = np.ascontiguousarray(mesh.nodes[:, [0, 2]])
    return tuple(float(np.abs(liner.nearest(p).distance).max()) for p in (nodes, middles))


def _off_liner(deviation, chord, chord_error, radius):
    problems = []
    # Files in single precision are good to 1e-7 of the radius.
    if deviation > 1e-6 * radius:
        problems.append(f"nodes up to {deviation:.3g} m off the liner")
    if chord_error is not None and chord > chord_error * (1.0 + 1e-9):
        problems.append(
            f"triangles up to {chord:.3g} m off the liner, accepted are {chord_error:g} m"
        )
    return problems


def _engine_angles(angle):
    hard, soft = engine_limits.SMALLEST_ANGLE_HARD_DEG, engine_limits.SMALLEST_ANGLE_SOFT_DEG
    if angle < hard:
        return [
            f"smallest angle of a triangle is {angle:.4g} degrees, the engine stops below "
            f"{hard:.4g}: use more axial divisions or a larger chord error"
        ], []
    if angle < soft:
        return [], [
            f"smallest angle of a triangle is {angle:.4g} degrees, the engine warns below "
            f"{soft:g}: more axial divisions or a larger chord error avoid it"
        ]
    return [], []
