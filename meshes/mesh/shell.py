"""Faults of a shell of triangles that a person gives: holes, branches, turned or flat triangles."""

import numpy as np

from millscale.mesh.liner_mesh import areas, edge_counts, shared_edges

# Share of the longest side squared: a triangle of less area is flat.
SLIVER = 1e-9
# The rim of an open end: its edges lie in one plane across an axis, within this share of the size.
RIM = 1e-6


def shell_faults(mesh):
    """Return what makes a shell unfit as the surface of a liner, one sentence each.

    A shell is closed, or open at two plane ends across x, y or z.

    Args:
        mesh: LinerMesh.
    """
    faults = []
    corners = mesh.corners
    t = np.sort(mesh.triangles, axis=1)
    _, inverse, count = np.unique(t, axis=0, return_inverse=True, return_counts=True)
    twice = np.flatnonzero(count[inverse.ravel()] > 1)
    if len(twice):
        faults.append(
            f"{len(twice)} triangles on the same three nodes, first {_at(corners, twice)}"
        )
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    slivers = np.flatnonzero(areas(mesh) <= SLIVER * longest**2)
    if len(slivers):
        faults.append(f"{len(slivers)} triangles without area, first {_at(corners, slivers)}")
    edges, count = edge_counts(mesh)
    branches = np.flatnonzero(count > 2)
    if len(branches):
        place = _shown(mesh.nodes[edges[branches[0]]].mean(axis=0))
        faults.append(f"{len(branches)} edges with more than two triangles, first near {place}")
    rim = edges[count == 1]
    holes = rim[~_in_end_planes(mesh, rim)]
    if len(holes):
        place = _shown(mesh.nodes[holes[0]].mean(axis=0))
        faults.append(f"holes: {len(holes)} edges with one triangle, first near {place}")
    shared = shared_edges(mesh)
    turned = shared.triangles[~shared.opposed]
    if len(turned):
        place = _at(corners, turned[:, 0])
        faults.append(f"{len(turned)} neighbours with opposite normals, first {place}")
    return faults


def _in_end_planes(mesh, edges):
    """Whether each edge lies in a plane at an end of the mesh, (k,) bool, for the axis with the
    most of them."""
    nodes = mesh.nodes
    size = np.ptp(nodes, axis=0).max()
    best = np.zeros(len(edges), dtype=bool)
    for k in range(3):
        along = nodes[:, k][edges]
        low = (along - nodes[:, k].min() <= RIM * size).all(axis=1)
        high = (nodes[:, k].max() - along <= RIM * size).all(axis=1)
        if (low | high).sum() > best.sum():
            best = low | high
    return best


def _at(corners, which):
    return f"near {_shown(corners[which[0]].mean(axis=0))}"


def _shown(place):
    return "x = {:.4g}, y = {:.4g}, z = {:.4g} m".format(*place.tolist())
