"""The cross-section of a liner that is given as a closed shell of triangles, an STL file."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from millscale.errors import CampaignError
from millscale.liner.lengths import ACCEPTED, LENGTHS
from millscale.liner.outline import Outline
from millscale.liner.simplify import reached_error, simplified
from millscale.mesh.engine_limits import NODE_PRECISION_M
from millscale.mesh.liner_mesh import LinerMesh, areas, normals
from millscale.mesh.shell import shell_faults
from millscale.mesh.stl import read_stl

# Plane of a section by the axis of the mill: x to the right and y up, as indices of coordinates.
PLANES = {"x": (1, 2), "y": (0, 2), "z": (0, 1)}
# A triangle is along the axis, or across it, if the cosine of its normal with the axis is less
# than this, or as near to 1.
ALONG = 1e-3
# Share of the area that may be neither.
STRAY = 1e-3
# Sections that are compared, as shares of the length between the ends.
SECTIONS = (0.5, 0.02, 0.2, 0.35, 0.65, 0.8, 0.98)
# Relative to the radius: facets are fitted by arcs and lines within this.
FITTED = 2e-4
# Relative to the radius: sections that differ by more are not of a prism.
PRISMATIC = 5e-4


def read_shell(path: Path, unit: str | None, radius: float) -> tuple[Outline, tuple[str, ...]]:
    """Return the inner outline of a prismatic shell around the axis, and warnings.

    Args:
        unit: of the file, which does not state one.
        radius: R of the mill [m].

    Raises:
        CampaignError: not a sound shell, no unit, or not prismatic.
    """
    if unit is None:
        raise CampaignError(
            path, "", "an STL file states no unit", f"liner.unit, one of {ACCEPTED}"
        )
    metres = LENGTHS[unit]
    try:
        mesh = read_stl(path, precision=NODE_PRECISION_M / metres)
    except (ValueError, OSError) as problem:
        cause = str(problem).removeprefix(f"{path}: ")
        accepted = "a text or binary STL file of triangles; export it again"
        raise CampaignError(path, "", cause, accepted) from None
    mesh = replace(mesh, nodes=metres * mesh.nodes)
    faults = shell_faults(mesh)
    if faults:
        accepted = "a closed shell, or the inner surface with open ends alone"
        raise CampaignError(path, "", faults[0], f"{accepted}; repair it where it was drawn")
    axis = _axis(path, mesh)
    sections = [_section(path, mesh, axis, share, metres) for share in SECTIONS]
    error = FITTED * radius
    _check_prismatic(path, sections, max(PRISMATIC * radius, error), axis)
    outline = simplified(sections[0], error)
    reached = reached_error(sections[0], outline)
    return outline, (f"liner: arcs and lines within {reached:.2g} m of the section of {path.name}",)


def _axis(path: Path, mesh: LinerMesh) -> str:
    """Return the axis along which all triangles run, but those of the ends."""
    area, normal = areas(mesh), np.abs(normals(mesh))
    strays = {}
    for k, axis in enumerate("xyz"):
        beside = (normal[:, k] > ALONG) & (normal[:, k] < 1.0 - ALONG)
        side = normal[:, k] <= ALONG
        strays[axis] = float(area[beside].sum() / area.sum()) if side.any() else 1.0
    spans = [_spans_axis(mesh, axis) for axis in "xyz"]
    best = min("xyz", key=lambda axis: (not spans["xyz".index(axis)], strays[axis]))
    if strays[best] > STRAY:
        raise CampaignError(
            path,
            "",
            f"not prismatic: {strays[best]:.1%} of its area is neither along nor across the "
            f"{best} axis",
            "a liner with the same cross-section all along the axis x, y or z of the file",
        )
    return best


def _spans_axis(mesh: LinerMesh, axis: str) -> bool:
    """Return whether the coordinate axis lies inside the box around the shell."""
    plane = mesh.nodes[:, PLANES[axis]]
    return bool((plane.min(axis=0) < 0.0).all() and (plane.max(axis=0) > 0.0).all())


def _section(path: Path, mesh: LinerMesh, axis: str, share: float, metres: float) -> Outline:
    """Return the innermost loop around the axis where a plane cuts the shell."""
    k = "xyz".index(axis)
    along = mesh.nodes[:, k]
    low, high = float(along.min()), float(along.max())
    # Not through a node: an edge then has one end on each side.
    height = low + share * (high - low)
    while np.isclose(along, height, rtol=0.0, atol=1e-9 * (high - low)).any():
        height += 1e-6 * (high - low)
    above = along > height
    links: dict[tuple[int, int], list[tuple[int, int]]] = {}
    for triangle in mesh.triangles[above[mesh.triangles].any(axis=1)].tolist():
        cut = [
            (min(a, b), max(a, b))
            for a, b in zip(triangle, triangle[1:] + triangle[:1], strict=True)
            if above[a] != above[b]
        ]
        if len(cut) == 2:
            links.setdefault(cut[0], []).append(cut[1])
            links.setdefault(cut[1], []).append(cut[0])
    loops = _loops(links)
    around = []
    for loop in loops:
        a, b = mesh.nodes[[edge[0] for edge in loop]], mesh.nodes[[edge[1] for edge in loop]]
        part = ((height - a[:, k]) / (b[:, k] - a[:, k]))[:, None]
        points = (a + part * (b - a))[:, PLANES[axis]]
        after = np.roll(points, -1, axis=0)
        turn = np.arctan2(
            points[:, 0] * after[:, 1] - points[:, 1] * after[:, 0], (points * after).sum(axis=1)
        ).sum()
        if abs(abs(float(turn)) - math.tau) < 1e-6:
            around.append(points)
    if not around:
        raise CampaignError(
            path,
            "",
            f"no closed line around the {axis} axis of the file where it is cut at {axis} = "
            f"{height / metres:.6g}",
            "the whole circumference, with the axis of the mill on an axis of the file",
        )
    inner = min(around, key=lambda points: float(np.linalg.norm(points, axis=1).min()))
    names = tuple(f"section {axis} = {height / metres:.6g}" for _ in inner)
    return Outline(path, inner, np.zeros(len(inner)), names, closed=True, unit=metres)


def _loops(
    links: dict[tuple[int, int], list[tuple[int, int]]],
) -> list[list[tuple[int, int]]]:
    """Return the closed loops of a graph whose nodes have two links each."""
    left, loops = dict(links), []
    while left:
        start = next(iter(left))
        loop, before, here = [], None, start
        while here in left:
            loop.append(here)
            onwards = left.pop(here)
            before, here = here, next((x for x in onwards if x != before and x in left), start)
        if len(loop) > 2:
            loops.append(loop)
    return loops


def _check_prismatic(path: Path, sections: list[Outline], most: float, axis: str) -> None:
    """Refuse a shell whose sections differ."""
    middle = sections[0]
    for other in sections[1:]:
        apart = reached_error(other, middle)
        if apart > most:
            raise CampaignError(
                path,
                other.names[0],
                f"not prismatic: this section differs from the one in the middle by {apart:.3g} m",
                f"a liner with the same cross-section all along its {axis} axis, within "
                f"{most:.2g} m; liner.profile takes one section of another liner",
            )
