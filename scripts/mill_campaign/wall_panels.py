"""The liner as panels: how many triangles, and which of them are one surface to the engine."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any, NamedTuple

import mill_core
import numpy as np

from liner_mesh import LinerMesh, curvature_deg, default_chord_error
from mill_campaign.config import Campaign
from mill_campaign.errors import CampaignError
from mill_campaign.law import Model


def wall_part(campaign: Campaign, model: Model) -> dict[str, Any]:
    """The part `wall` of a case.json.

    Raises:
        CampaignError: the panels are too slender for the engine.
    """
    wall, shape = campaign.wall, shape_of(model.liner)
    error = chord_error(campaign, model)
    try:
        triangles, curvature = _counted(shape, model.simulated_length, error, wall.axial_divisions)
    except ValueError as cause:
        raise CampaignError(
            campaign.file,
            "wall.axial_divisions",
            f"got {wall.axial_divisions}, S = {model.S:g}: {str(cause).partition('. ')[0]}",
            "more axial divisions, so that triangles are less slender, or a smaller chord_error_m",
        ) from None
    return {
        "kind": wall.kind,
        "chord_error_m": error,
        "axial_divisions": wall.axial_divisions,
        "triangles": triangles,
        "curvature_deg": curvature,
    }


class Shape(NamedTuple):
    """What a liner is made from: arguments of `mill_core.Liner`, in its order."""

    radius: float
    lifter_top_radius: float
    lifter_top_width: float
    groove_width: float
    lifters: int
    phase: float


def shape_of(liner: mill_core.Liner) -> Shape:
    return Shape(
        liner.radius,
        liner.lifter_top_radius,
        liner.lifter_top_width,
        liner.groove_width,
        liner.lifters,
        liner.phase,
    )


# Schemes share their liners, and large campaigns have thousands.
@lru_cache(maxsize=1 << 16)
def resting_height(shape: Shape, error: float, clear: float) -> float:
    """Height at which a disc let down from the axis stops on the panels of a liner [m].

    Args:
        error: largest gap between arcs and panels [m].
        clear: radius of the disc [m].
    """
    nodes, _ = mill_core.Liner(*shape).polygon(error)
    return first_contact_below(nodes, clear)


@lru_cache(maxsize=1 << 16)
def _counted(shape: Shape, length: float, error: float, divisions: int) -> tuple[int, float]:
    """Number of panels of a liner and the engine's `curvature` [degrees]."""
    panels = panels_of(mill_core.Liner(*shape), length, error, divisions)
    return len(panels.triangles), curvature_deg(panels)


def chord_error(campaign: Campaign, model: Model) -> float:
    """Largest gap between arcs and panels [m]; it shrinks with the mill, so meshes are similar."""
    if campaign.wall.chord_error is None:
        return default_chord_error(campaign.ball.radius, model.S)
    return campaign.wall.chord_error / model.S


def panels_of(
    liner: mill_core.Liner, length: float, error: float, axial_divisions: int
) -> LinerMesh:
    """The triangles gmsh would make, without it: two for each panel and division.

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
    """Nodes of the triangles between rings of n nodes, (2 n divisions, 3) int; not to write to."""
    one = np.arange(n)
    other = (one + 1) % n
    near = np.stack([one, one + n, other + n], axis=1)
    far = np.stack([one, other + n, other], axis=1)
    strip = np.concatenate([near, far])
    triangles = np.concatenate([strip + n * i for i in range(divisions)])
    triangles.flags.writeable = False
    return triangles


def distance(nodes: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Distance of points from a closed polygon [m], (m,) float.

    Args:
        nodes: (n, 2) float, the polygon [m].
        points: (m, 2) float [m].
    """
    edges = np.roll(nodes, -1, axis=0) - nodes
    offsets = points[:, None, :] - nodes[None, :, :]
    along = (offsets * edges).sum(axis=2) / (edges * edges).sum(axis=1)
    nearest = offsets - np.clip(along, 0.0, 1.0)[:, :, None] * edges
    return np.linalg.norm(nearest, axis=2).min(axis=1)


def first_contact_below(nodes: np.ndarray, clear: float) -> float:
    """Height of the first point under the axis that is `clear` from a polygon [m].

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
    stops = []
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
