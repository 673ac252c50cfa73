"""The cross-section of a liner as an SVG drawing, with the direction of rotation."""

from __future__ import annotations

import math

import numpy as np

from millscale import _core

WIDTH = 340.0
MARGIN = 8.0
# Chords of the drawing, relative to the radius.
CHORD_ERROR = 1e-4


def svg(liner: _core.Profile, title: str) -> str:
    """Return a quarter of the cross-section at rest, seen as in the report: the bottom turns to the
    left.

    Args:
        title: for readers of the picture's text.
    """
    nodes, _ = liner.polygon(CHORD_ERROR * liner.radius)
    scale = (WIDTH - 2.0 * MARGIN) / (math.sqrt(2.0) * liner.radius)
    # The eighth to each side of the bottom.
    left, top = -liner.radius / math.sqrt(2.0), -liner.radius / math.sqrt(2.0) + 0.12 * liner.radius
    points = np.column_stack(
        [MARGIN + (nodes[:, 0] - left) * scale, MARGIN + (top - nodes[:, 1]) * scale]
    )
    height = MARGIN * 2.0 + (top + liner.radius) * scale
    inside = " ".join(f"{x:.1f},{z:.1f}" for x, z in points.tolist())
    middle, low = 0.5 * WIDTH, MARGIN + 26.0
    arrow = f"M{middle + 34:.1f},{low:.1f} L{middle - 34:.1f},{low:.1f} m9,-5 l-9,5 l9,5"
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH:.0f}" height="{height:.0f}" '
        f'viewBox="0 0 {WIDTH:.0f} {height:.0f}" role="img">\n'
        f"<title>{title}</title>\n"
        f'<rect width="{WIDTH:.0f}" height="{height:.0f}" fill="#d9d4c7"/>\n'
        f'<polygon points="{inside}" fill="#fff" stroke="#444" stroke-width="1.2"/>\n'
        f'<path d="{arrow}" fill="none" stroke="#1f6fb4" stroke-width="1.4"/>\n'
        f'<text x="{middle:.0f}" y="{low - 8:.0f}" font-family="sans-serif" font-size="11" '
        'fill="#1f6fb4" text-anchor="middle">rotation</text>\n</svg>\n'
    )
