"""From the cross-section to a conforming, structured triangulation, through gmsh."""

import math
from contextlib import contextmanager

import numpy as np

from millscale.mesh.liner_mesh import LinerMesh


def default_chord_error(ball_radius: float, S: float = 1.0) -> float:
    """Chord error of the groove arcs that is small against everything else in the contact [m].

    2.5 % of the ball radius, over S: 0.5 mm for the paper's ball in the physical mill, as much as
    the rounding of its Table 4 and less than the overlap in an impact of 1 m/s (0.7 mm). Over S, so
    that the polygons of all scaled mills are similar and scales are compared, not meshes.

    Args:
        ball_radius: [m].
        S: physical / scaled mill radius, >= 1.
    """
    return 0.025 * ball_radius / S


def build_liner_mesh(liner, length, chord_error, axial_divisions=1):
    """Triangulates the liner from y = 0 to y = length.

    Every edge of the liner's polygon becomes a strip of axial_divisions rectangles of two triangles
    each; strips share their nodes, and both ends have the same nodes, as a periodic axis needs.

    Args:
        liner: _core.Profile.
        length: axial length of the mill [m].
        chord_error: largest distance between a groove arc and its chords [m].
        axial_divisions: rectangles along the axis.

    Returns:
        LinerMesh, normals into the cavity, triangles in the polygon's order.
    """
    if not (math.isfinite(length) and length > 0.0):
        raise ValueError(f"length: must be > 0 m, got {length}")
    if axial_divisions != int(axial_divisions) or axial_divisions < 1:
        raise ValueError(f"axial_divisions: must be a whole number >= 1, got {axial_divisions}")
    profile, kinds = liner.polygon(chord_error)
    with _gmsh_model("liner") as gmsh:
        strips = _add_strips(gmsh, profile, length, int(axial_divisions))
        gmsh.model.mesh.generate(2)
        return _collect(gmsh, strips, kinds)


@contextmanager
def _gmsh_model(name):
    """A gmsh model of our own; leaves gmsh as it was found."""
    import gmsh

    running = gmsh.isInitialized()
    if not running:
        # No command line, no configuration files of the user, no signal handlers.
        gmsh.initialize([], readConfigFiles=False, run=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.add(name)
        yield gmsh
    finally:
        if running:
            gmsh.model.remove()
        else:
            gmsh.finalize()


def _add_strips(gmsh, profile, length, axial_divisions):
    """Adds one transfinite surface per polygon edge; returns their tags in the polygon's order."""
    geo = gmsh.model.geo
    near = [geo.addPoint(x, 0.0, z) for x, z in profile.tolist()]
    far = [geo.addPoint(x, length, z) for x, z in profile.tolist()]
    n = len(profile)
    axial = [geo.addLine(near[i], far[i]) for i in range(n)]
    across_near = [geo.addLine(near[i], near[(i + 1) % n]) for i in range(n)]
    across_far = [geo.addLine(far[i], far[(i + 1) % n]) for i in range(n)]
    strips = []
    for i in range(n):
        # Counter-clockwise seen from the cavity.
        loop = [axial[i], across_far[i], -axial[(i + 1) % n], -across_near[i]]
        strips.append(geo.addPlaneSurface([geo.addCurveLoop(loop)]))
    for curve in across_near + across_far:
        geo.mesh.setTransfiniteCurve(curve, 2)
    for curve in axial:
        geo.mesh.setTransfiniteCurve(curve, axial_divisions + 1)
    for strip in strips:
        geo.mesh.setTransfiniteSurface(strip)
    geo.synchronize()
    return strips


def _collect(gmsh, strips, kinds):
    """The model's nodes and triangles as LinerMesh."""
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    index = np.zeros(int(tags.max()) + 1, dtype=np.int64)
    index[tags] = np.arange(len(tags))
    triangle = gmsh.model.mesh.getElementType("triangle", 1)
    triangles, faces = [], []
    for strip, kind in zip(strips, kinds, strict=True):
        _, nodes = gmsh.model.mesh.getElementsByType(triangle, strip)
        triangles.append(index[nodes].reshape(-1, 3))
        faces.append(np.full(len(nodes) // 3, kind, dtype=np.int64))
    return LinerMesh(
        nodes=coordinates.reshape(-1, 3),
        triangles=np.concatenate(triangles),
        faces=np.concatenate(faces),
    )
