"""The mesh of a liner and the quantities its checks need."""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

GROOVE, LEADING, TOP, TRAILING = range(4)
UNKNOWN = -1


@dataclass(frozen=True)
class LinerMesh:
    """Triangles of a liner, the axial direction along y.

    Attributes:
        nodes: (n, 3) float, x y z [m].
        triangles: (m, 3) int, nodes of each triangle; counter-clockwise seen from the cavity.
        faces: (m,) int, 0 groove, 1 leading face, 2 top, 3 trailing face, -1 not known.
    """

    nodes: np.ndarray
    triangles: np.ndarray
    faces: np.ndarray

    @cached_property
    def corners(self):
        """Corner coordinates of the triangles, (m, 3, 3) float [m]; not to be written to."""
        return self.nodes[self.triangles]

    @cached_property
    def area_vectors(self):
        """Normals as long as twice the areas, (m, 3) float [m^2]; not to be written to."""
        a, b, c = np.moveaxis(self.corners, 1, 0)
        return _cross(b - a, c - a)


@dataclass(frozen=True)
class SharedEdges:
    """Edges between two triangles.

    Attributes:
        nodes: (k, 2) int.
        triangles: (k, 2) int, the two neighbours.
        opposed: (k,) bool, run through in opposite directions: the neighbours are oriented alike.
    """

    nodes: np.ndarray
    triangles: np.ndarray
    opposed: np.ndarray


def normals(mesh):
    """Unit normals of the triangles, (m, 3) float; zero where a triangle has no area."""
    cross = mesh.area_vectors
    length = np.linalg.norm(cross, axis=1, keepdims=True)
    return np.divide(cross, length, out=np.zeros_like(cross), where=length > 0.0)


def areas(mesh):
    """Areas of the triangles, (m,) float [m^2]."""
    return 0.5 * np.linalg.norm(mesh.area_vectors, axis=1)


def _cross(one, other):
    """Cross products of rows, (m, 3) float: numpy's own is slow on many small arrays."""
    x, y, z = one.T
    u, v, w = other.T
    return np.stack([y * w - z * v, z * u - x * w, x * v - y * u], axis=1)


def smallest_angles_deg(mesh):
    """Smallest angle of each triangle, (m,) float [degrees]; 0 for a degenerate one."""
    corners = mesh.corners
    sides = corners[:, (1, 2, 0)] - corners
    lengths = np.linalg.norm(sides, axis=2)
    # The smallest angle lies opposite the shortest side; its sine is small and so is well resolved.
    shortest = lengths.argmin(axis=1)
    rows = np.arange(len(corners))
    others = lengths[rows, (shortest + 1) % 3] * lengths[rows, (shortest + 2) % 3]
    sine = np.divide(2.0 * areas(mesh), others, out=np.zeros(len(corners)), where=others > 0.0)
    return np.degrees(np.arcsin(np.minimum(sine, 1.0)))


def directed_edges(mesh):
    """Edges in their triangles' direction, (3 m, 2) int; row i belongs to triangle i mod m."""
    return _directed(mesh.triangles)


def _directed(t):
    return np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]])


def edge_counts(mesh):
    """Undirected edges, (k, 2) int, and the number of triangles on each, (k,) int."""
    return np.unique(np.sort(directed_edges(mesh), axis=1), axis=0, return_counts=True)


def shared_edges(mesh):
    """Edges that exactly two triangles share, as SharedEdges; not to be written to."""
    triangles = np.ascontiguousarray(mesh.triangles, dtype=np.int64)
    return _shared_edges(triangles.tobytes())


@lru_cache(maxsize=8)
def _shared_edges(triangles):
    """The same from the bytes of the triangles: meshes of one campaign differ in their nodes."""
    t = np.frombuffer(triangles, dtype=np.int64).reshape(-1, 3)
    directed = _directed(t)
    undirected = np.sort(directed, axis=1)
    order = np.lexsort((undirected[:, 1], undirected[:, 0]))
    _, first, count = np.unique(undirected[order], axis=0, return_index=True, return_counts=True)
    one, other = order[first[count == 2]], order[first[count == 2] + 1]
    size = len(t)
    return SharedEdges(
        nodes=undirected[one],
        triangles=np.stack([one % size, other % size], axis=1),
        opposed=directed[one, 0] == directed[other, 1],
    )


def folds_deg(mesh, edges):
    """Angle between the planes of the neighbours at shared edges, (k,) float, 0 to 90 [degrees].

    As the engine sees it: normals are compared without their sign.
    """
    n = normals(mesh)
    one, other = n[edges.triangles[:, 0]], n[edges.triangles[:, 1]]
    sine = np.linalg.norm(_cross(one, other), axis=1)
    cosine = np.abs(np.einsum("ij,ij->i", one, other))
    return np.degrees(np.arctan2(sine, cosine))
