"""The liner as panels: how many triangles, and which of them are one surface to the engine."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from millscale import _core
from millscale.campaign.campaign import Campaign
from millscale.cases.law import PlannedMill
from millscale.errors import CampaignError
from millscale.mesh import LinerMesh, default_chord_error
from millscale.mesh.curvature import between_deg
from millscale.mesh.panels import fewest_divisions, fits, panel_range_deg
from millscale.runs.case_file import Wall

# A text file of so many takes half a gigabyte.
MOST_TRIANGLES = 2_000_000


def wall_part(campaign: Campaign, planned: PlannedMill) -> Wall:
    """Return the part `wall` of a case.json.

    Of an analytic wall the triangles are for looking only: the engine sees none, so none is too
    slender, there is no `curvature_deg`, and there are as many as a picture bears.

    Raises:
        CampaignError: too many panels for a mesh wall, or panels too slender for the engine.
    """
    wall, shape = campaign.wall, shape_of(planned.liner)
    error, length = chord_error(campaign, planned), planned.simulated_length
    panels = _panels(shape, error)
    if wall.kind == "mesh":
        divisions = _divisions(campaign, planned, *panels)
        limits = panel_range_deg(*panels, length / divisions)
        curvature = between_deg(*limits)
    else:
        curvature = None
        while 2 * len(panels[0]) > MOST_TRIANGLES:
            error *= 4.0
            panels = _panels(shape, error)
        divisions = min(wall.axial_divisions or 1, MOST_TRIANGLES // (2 * len(panels[0])))
    triangles = 2 * len(panels[0]) * divisions
    if triangles > MOST_TRIANGLES:
        raise CampaignError(
            campaign.file,
            "wall.chord_error_m" if divisions == 1 else "wall.axial_divisions",
            f"makes {triangles:,} triangles at S = {planned.S:g}",
            f"<= {MOST_TRIANGLES:,}: a larger chord_error_m or fewer axial_divisions",
        )
    return Wall(
        kind=wall.kind,
        chord_error_m=error,
        axial_divisions=divisions,
        triangles=triangles,
        curvature_deg=curvature,
    )


def _divisions(
    campaign: Campaign, planned: PlannedMill, profile: np.ndarray, kinds: np.ndarray
) -> int:
    """Return the panels along the axis of a mesh that the engine reads: as given, or the fewest it
    takes."""
    length, given = planned.simulated_length, campaign.wall.axial_divisions
    if given is not None and fits(*panel_range_deg(profile, kinds, length / given)):
        return given
    fewest = fewest_divisions(profile, kinds, length)
    if given is None and fewest is not None:
        return fewest
    lower, upper = panel_range_deg(profile, kinds, length / (given or 1))
    if fewest is None:
        key, works = "wall.chord_error_m", "a smaller chord_error_m"
    else:
        key, works = "wall.axial_divisions", f"{fewest}, or no such key"
    raise CampaignError(
        campaign.file,
        key,
        f"{f'got {given}' if given else 'no axial_divisions fit'}, S = {planned.S:g}: the folds "
        f"between chords of a groove, {lower:.3g} degrees, do not lie below those at lifter edges "
        f"and the angles of triangles, {upper:.3g}",
        f'{works}; or wall.kind = "analytic"',
    )


class Shape(NamedTuple):
    """What a liner is made from: arguments of `_core.Profile`, in its order."""

    nodes: tuple[tuple[float, float, float, int, int], ...]
    sectors: int
    phase: float


def shape_of(liner: _core.Profile) -> Shape:
    return Shape(tuple(liner.nodes), liner.sectors, liner.phase)


# Schemes share their liners, and large campaigns have thousands.
@lru_cache(maxsize=1 << 16)
def resting_height(shape: Shape, error: float, clear: float) -> float:
    """Return the height at which a disc let down from the axis stops on the panels of a liner [m].

    Args:
        error: largest gap between arcs and panels [m].
        clear: radius of the disc [m].
    """
    return first_contact_below(_panels(shape, error)[0], clear)


@lru_cache(maxsize=256)
def _panels(shape: Shape, error: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the polygon of a liner, (n, 2) float [m], and the face of each edge, (n,) int."""
    return _core.Profile(list(shape.nodes), shape.sectors, shape.phase).polygon(error)


def chord_error(campaign: Campaign, planned: PlannedMill) -> float:
    """Return the largest gap between arcs and panels [m]; it shrinks with the mill, so meshes are
    similar."""
    if campaign.wall.chord_error is None:
        return default_chord_error(campaign.ball.radius, planned.S)
    return campaign.wall.chord_error / planned.S


def panels_of(liner: _core.Profile, length: float, error: float, axial_divisions: int) -> LinerMesh:
    """Return the triangles gmsh would make, without it: two for each panel and division.

    Args:
        length: of the liner along the axis [m].
        error: largest gap between arcs and panels [m].
    """
    profile, kinds = liner.polygon(error)
    n, rings = len(profile), axial_divisions + 1
    nodes = np.empty((rings, n, 3))
    nodes[:, :, 0], nodes[:, :, 2] = profile.T
    nodes[:, :, 1] = np.linspace(0.0, length, rings)[:, None]
    return LinerMesh(
        nodes=nodes.reshape(-1, 3),
        triangles=_strips(n, axial_divisions),
        faces=np.tile(kinds, 2 * axial_divisions),
    )


@lru_cache(maxsize=64)
def _strips(n: int, divisions: int) -> np.ndarray:
    """Return the triangles between rings of n nodes, (2 n divisions, 3) int, read-only."""
    one = np.arange(n)
    other = (one + 1) % n
    near = np.stack([one, one + n, other + n], axis=1)
    far = np.stack([one, other + n, other], axis=1)
    strip = np.concatenate([near, far])
    triangles = np.concatenate([strip + n * i for i in range(divisions)])
    triangles.flags.writeable = False
    return triangles


def distance(nodes: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return the distance of points from a closed polygon [m], (m,) float.

    Args:
        nodes: (n, 2) float, the polygon [m].
        points: (m, 2) float [m].
    """
    edges = np.roll(nodes, -1, axis=0) - nodes
    offsets = points[:, None, :] - nodes[None, :, :]
    along = (offsets * edges).sum(axis=2) / (edges * edges).sum(axis=1)
    nearest = offsets - np.clip(along, 0.0, 1.0)[:, :, None] * edges
    distances: np.ndarray = np.linalg.norm(nearest, axis=2).min(axis=1)
    return distances


def first_contact_below(nodes: np.ndarray, clear: float) -> float:
    """Return the height of the first point under the axis that is `clear` from a polygon [m].

    On the way down from (0, 0) a disc of that radius is stopped by a corner within reach of the
    vertical, at z + sqrt(clear^2 - x^2), or by an edge, `clear` above it along its normal; the
    first of them is the highest. Exact to rounding.

    Args:
        nodes: (n, 2) float, closed around the axis, farther than `clear` from it [m].
        clear: distance [m].

    Raises:
        ValueError: nothing of the polygon lies under the axis.
    """
    ends = np.roll(nodes, -1, axis=0)
    near = (np.minimum(nodes[:, 0], ends[:, 0]) < clear) & (
        np.maximum(nodes[:, 0], ends[:, 0]) > -clear
    )
    low = near & (np.minimum(nodes[:, 1], ends[:, 1]) < 0.0)
    stops: list[float] = []
    for (x, z), (to_x, to_z) in zip(nodes[low].tolist(), ends[low].tolist(), strict=True):
        if abs(x) < clear:
            stops.append(z + math.sqrt(clear * clear - x * x))
        length = math.hypot(to_x - x, to_z - z)
        slope_x, slope_z = (to_x - x) / length, (to_z - z) / length
        if slope_x != 0.0:
            # On the vertical, at that distance from the edge's line, on its upper side.
            height = z + (clear / abs(slope_x)) - x * slope_z / slope_x
            along = -x * slope_x + (height - z) * slope_z
            if 0.0 <= along <= length:
                stops.append(height)
    if not stops:
        raise ValueError("no part of the polygon lies under the axis")
    return max(stops)
