"""Figures and charges for the interactive page: what its script draws instead of the images.

A chart holds the same lines as the image of its figure, so a figure is drawn in one place. A view
holds the balls of a case at several mill angles. All is one packed text, which the page unpacks.
"""

from __future__ import annotations

import base64
import gzip
import importlib.util
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.contour import ContourSet
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from millscale.analysis.finished import Charge
from millscale.analysis.shapes.cross_section import liner_outline
from millscale.analysis.shapes.snapshots import class_of_each, snapshots_near
from millscale.report.ball_classes import colours_of_classes, names_of_classes
from millscale.runs.case_file import Case
from millscale.runs.dumps import Dump, read_dump
from millscale.runs.untrusted import RunFolderError

# A line of more points is thinned: the page has fewer pixels.
MOST_POINTS = 700
MOST_FRAMES = 13
# Balls times frames in all views of a page: seven or eight bytes each.
MOST_BALLS = 400_000
_DASHES = {"-": "solid", "--": "dash", ":": "dot", "-.": "dashdot"}
_SYMBOLS = {
    "o": "circle",
    "s": "square",
    "^": "triangle-up",
    "x": "x",
    ".": "circle",
    "D": "diamond",
}

VELOCITY = ("vx", "vy", "vz")

Chart = dict[str, Any]


def packed(content: Any) -> str:
    """Return JSON types as compressed text."""
    return packed_bytes(json.dumps(content, separators=(",", ":"), allow_nan=False).encode())


def packed_bytes(content: bytes) -> str:
    """Return bytes as compressed base64."""
    return base64.b64encode(gzip.compress(content, 9, mtime=0)).decode()


def plotting_script() -> str:
    """Return the script of plotly as compressed text; empty where the package is not installed,
    so that the page shows its images."""
    found = importlib.util.find_spec("plotly")
    if found is None or not found.submodule_search_locations:
        return ""
    script = Path(found.submodule_search_locations[0]) / "package_data" / "plotly.min.js"
    return packed_bytes(script.read_bytes())


def chart_of(figure: Figure) -> Chart | None:
    """Return the panels and lines of a figure that has been drawn; None of pictures and bars."""
    axes = [a for a in figure.axes if a.get_visible()]
    if any(a.images or a.containers for a in axes):
        return None
    panels = [_panel(a) for a in axes]
    if not any(panel["lines"] for panel in panels):
        return None
    places = [a.get_position() for a in axes]
    columns = len({round(place.x0, 1) for place in places})
    width, height = figure.get_size_inches()
    return {"panels": panels, "columns": columns, "aspect": round(float(height / width), 3)}


def _panel(axes: Axes) -> dict[str, Any]:
    lines = [_line(line, axes) for line in sorted(axes.lines, key=Line2D.get_zorder)]
    for collection in axes.collections:
        if isinstance(collection, ContourSet):
            lines += _contours(collection)
    return {
        "title": axes.get_title(),
        "x": _axis(axes, "x"),
        "y": _axis(axes, "y"),
        "equal": axes.get_aspect() == 1.0,
        "bands": _bands(axes),
        "lines": [line for line in lines if line],
    }


def _bands(axes: Axes) -> list[dict[str, Any]]:
    """Return the bands of `axvspan` that have a name, from bottom to top of a panel."""
    found = []
    for patch in axes.patches:
        if patch.get_gid() and isinstance(patch, Rectangle):
            ends = np.array([patch.get_x(), patch.get_x() + patch.get_width()])
            begin, end = _rounded(ends)
            colour = to_hex(patch.get_facecolor())
            found.append({"name": patch.get_gid(), "x0": begin, "x1": end, "color": colour})
    return found


def _axis(axes: Axes, name: str) -> dict[str, Any]:
    label = getattr(axes, f"get_{name}label")() or getattr(axes.figure, f"get_sup{name}label")()
    low, high = getattr(axes, f"get_{name}lim")()
    is_log = getattr(axes, f"get_{name}scale")() == "log"
    ends = np.log10([low, high]) if is_log else np.array([low, high])
    return {"title": label, "log": is_log, "range": [float(f"{x:.5g}") for x in ends]}


def _line(line: Line2D, axes: Axes) -> dict[str, Any] | None:
    x, y = (np.asarray(v, float) for v in (line.get_xdata(), line.get_ydata()))
    # A rule across the panel: one of its coordinates is a share of the axis.
    if line.get_transform() != axes.transData:
        low, high = axes.get_xlim() if y[0] == y[-1] else axes.get_ylim()
        x, y = (np.array([low, high]), y) if y[0] == y[-1] else (x, np.array([low, high]))
    if not x.size:
        return None
    every = -(-x.size // MOST_POINTS)
    style, mark = line.get_linestyle(), line.get_marker()
    has_line, has_mark = style not in ("None", "none", " ", ""), mark in _SYMBOLS
    label = str(line.get_label())
    return {
        "x": _rounded(x[::every]),
        "y": _rounded(y[::every]),
        "name": "" if label.startswith("_") else label,
        "color": to_hex(line.get_color()),
        "dash": _DASHES.get(style, "dash") if isinstance(style, str) else "dash",
        "width": float(line.get_linewidth()),
        "mode": "+".join(["lines"] * has_line + ["markers"] * has_mark) or "lines",
        "symbol": _SYMBOLS.get(mark, "circle"),
        "size": float(line.get_markersize()),
    }


def _contours(found: ContourSet) -> list[dict[str, Any]]:
    colour, name = to_hex(found.get_edgecolor()[0]), found.get_gid() or ""
    lines = []
    for path in found.get_paths():
        for polygon in path.to_polygons(closed_only=False):
            x, y = np.asarray(polygon, float).T
            lines.append(
                {"x": _rounded(x), "y": _rounded(y), "name": name, "color": colour, "dash": "solid",
                 "width": 1.5, "mode": "lines", "symbol": "circle", "size": 4.0}
            )  # fmt: skip
    return lines


def _rounded(values: np.ndarray) -> list[float | None]:
    """Return numbers with five digits; None for what is not a number."""
    return [float(f"{x:.5g}") if np.isfinite(x) else None for x in values.tolist()]


def views_of(charges: Sequence[Charge]) -> dict[str, dict[str, Any]]:
    """Return the balls of charges at mill angles, by id, until the page would be too large."""
    found, balls = {}, 0
    for charge in charges:
        frames = min(MOST_FRAMES, (MOST_BALLS - balls) // max(charge.balls, 1))
        if frames < 2:
            break
        try:
            found[charge.id] = view_of(charge, frames)
        except RunFolderError:
            continue  # without dumps, or without velocities in them
        balls += charge.balls * frames
    return found


def view_of(charge: Charge, frames: int) -> dict[str, Any]:
    """Return the balls of a charge near evenly spaced mill angles, and its liner at rest.

    Positions are shares of R in 16 bits, speeds shares of the largest in 8 bits, both base64. Of
    several classes, `classes` holds name, colour and radius of each, and a frame the class of each
    ball.

    Raises:
        RunFolderError: a dump is missing or damaged, has no velocities, or balls of no class.
    """
    mill = charge.case.mill
    R, speed_scale = mill.radius_m, mill.omega_rad_s * mill.radius_m
    angles = np.linspace(0.0, charge.result.rotation_angle_rad, frames)
    snapshots = snapshots_near(charge.folder, angles.tolist())
    dumps = [read_dump(snapshot.path) for snapshot in snapshots]
    if any(name not in dump.columns for dump in dumps for name in VELOCITY):
        raise RunFolderError(snapshots[0].path, "has no velocities", "run the case again")
    speeds = [
        np.linalg.norm(np.column_stack([dump[x] for x in VELOCITY]), axis=1) / speed_scale
        for dump in dumps
    ]
    top = max(float(np.percentile(speed, 99.5)) for speed in speeds) or 1.0
    middle = 0.5 * mill.simulated_length_m
    return {
        "angles": [round(snapshot.mill_angle, 4) for snapshot in snapshots],
        "top": round(top, 4),
        "ball": round(charge.case.ball.radius_m / R, 6),
        "classes": _classes(charge.case),
        "half": round(middle / R, 5),
        "liner": [_rounded(v) for v in (liner_outline(charge.case, 0.0) / R).T],
        "frames": [
            {
                "places": _bytes((dump.positions - (0.0, middle, 0.0)) / (1.2 * R) * 32767, "<i2"),
                "speeds": _bytes(np.minimum(speed / top, 1.0) * 255, "u1"),
            }
            | _kinds(charge.case, dump, snapshot.path)
            for dump, speed, snapshot in zip(dumps, speeds, snapshots, strict=True)
        ],
    }


def _classes(case: Case) -> list[dict[str, Any]]:
    """Return the classes of balls; none if all balls are of one."""
    ball = case.ball
    names, colours = names_of_classes(ball), colours_of_classes(ball)
    return [
        {"name": name, "color": colour, "ball": round(one.radius_m / case.mill.radius_m, 6)}
        for one, name, colour in zip(ball.classes, names, colours, strict=True)
    ]


def _kinds(case: Case, dump: Dump, path: Path) -> dict[str, str]:
    if not case.ball.classes:
        return {}
    try:
        kinds = class_of_each(dump, len(case.ball.classes))
    except ValueError as error:
        raise RunFolderError(path, str(error), "run the case again") from None
    return {"kinds": _bytes(kinds, "u1")}


def _bytes(values: np.ndarray, kind: str) -> str:
    limits = np.iinfo(kind)
    whole = np.clip(np.round(values), limits.min, limits.max).astype(kind)
    return base64.b64encode(whole.tobytes()).decode()
