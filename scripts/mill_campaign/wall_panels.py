"""The liner as panels: how many triangles, and which of them are one surface to the engine."""

from __future__ import annotations

from typing import Any

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
    wall = campaign.wall
    error = chord_error(campaign, model)
    panels = panels_of(model.liner, model.simulated_length, error, wall.axial_divisions)
    try:
        curvature = curvature_deg(panels)
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
        "triangles": len(panels.triangles),
        "curvature_deg": curvature,
    }


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
    n = len(profile)
    rings = [
        np.insert(profile, 1, y, axis=1) for y in np.linspace(0.0, length, axial_divisions + 1)
    ]
    one = np.arange(n)
    other = (one + 1) % n
    near = np.stack([one, one + n, other + n], axis=1)
    far = np.stack([one, other + n, other], axis=1)
    strip = np.concatenate([near, far])
    return LinerMesh(
        nodes=np.concatenate(rings),
        triangles=np.concatenate([strip + n * i for i in range(axial_divisions)]),
        faces=np.tile(kinds, 2 * axial_divisions),
    )


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
