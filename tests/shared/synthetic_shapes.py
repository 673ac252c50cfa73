"""Charges of known surface and curtains of known profile, over R - a."""

from __future__ import annotations

import numpy as np

_TURN = np.linspace(0.0, 2.0 * np.pi, 721)
CIRCLE = np.column_stack([np.cos(_TURN), np.sin(_TURN)])
FRACTION = 0.55


def packed_bed(
    radius: float, length: float, tilt: float, height: float, seed: int = 1
) -> tuple[np.ndarray, np.ndarray]:
    """Return balls of solid fraction FRACTION in the unit circle below a flat surface.

    One ball at a random place in each cell of a cubic grid, and only those whose centre is below
    the surface: evenly dense up to it, so that half the fraction lies on it.

    Args:
        radius, length: over R - a.
        tilt: of the surface against x, positive rising with x [rad].
        height: of the surface from the axis, over R - a.

    Returns:
        (n, 3) float [x, y, z], and (n,) ball volume over length.
    """
    volume = 4.0 / 3.0 * np.pi * radius**3
    spacing = (volume / FRACTION) ** (1.0 / 3.0)
    slabs = max(1, round(length / spacing))
    thick = length / slabs
    side = np.sqrt(volume / FRACTION / thick)
    axis = np.arange(-1.05, 1.05, side)
    corners = np.stack(
        np.meshgrid(axis, np.arange(slabs) * thick, axis, indexing="ij"), axis=-1
    ).reshape(-1, 3)
    generator = np.random.default_rng(seed)
    places = corners + generator.uniform(size=corners.shape) * (side, thick, side)
    up = -np.sin(tilt) * places[:, 0] + np.cos(tilt) * places[:, 2]
    inside = (np.hypot(places[:, 0], places[:, 2]) < 1.0) & (up < height)
    places = places[inside]
    return places, np.full(len(places), volume / length)
