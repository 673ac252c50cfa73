"""Pictures of a charge, after Figs. 9 and 10, and its files for ParaView.

`picture_process` draws the pictures in a child process.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
import pyvista as pv

from millscale.analysis.shapes.cross_section import turned
from millscale.analysis.shapes.snapshots import (
    Snapshot,
    class_of_each,
    first_dump,
    starts_on_rising_side,
)
from millscale.report.ball_classes import colours_of_classes
from millscale.runs.case_folder import LINER, RunFolderError, load_case
from millscale.runs.dumps import Dump, read_dump
from millscale.runs.untrusted import check_regular
from millscale.runs.writing import writing_by_name

RISING, FALLING = "#c8322b", "#2458b3"  # colours by the starting side, x < 0 and x >= 0
WALL = "#9aa3ad"
WALL_THICKNESS = 0.03  # drawn, over the mill radius
PIXELS = 720


def liner_section(stl: Path) -> np.ndarray:
    """Return the closed cross-section of a liner mesh at rest, (n, 2) float [x, z] in m, by polar
    angle.

    Raises:
        RunFolderError: the file is missing or holds no mesh around the axis.
    """
    check_regular(stl, "millscale run FILE --runs DIR --only ID")
    mesh = pv.read(stl)
    if mesh.n_cells == 0:
        raise RunFolderError(stl, "no triangles: cut short?", "delete it and run the case again")
    y = 0.5 * (mesh.bounds[2] + mesh.bounds[3])
    section = mesh.slice(normal="y", origin=(0.0, y, 0.0)).clean(tolerance=1e-9)
    segments = section.lines.reshape(-1, 3)[:, 1:]
    return section.points[_loop(segments)][:, [0, 2]]


def draw_charge(
    dump: Dump, colours: Sequence[str], kinds: np.ndarray, section: np.ndarray, mill_angle: float
) -> pv.Plotter:
    """Return a view along the mill axis: x to the right, z up, the mill turning clockwise.

    Args:
        dump: balls to draw.
        colours: of the kinds of balls.
        kinds: (n,) int, kind of each ball from 0 on.
        section: of `liner_section`.
        mill_angle: by which the liner is turned [rad].
    """
    plotter = pv.Plotter(off_screen=True, window_size=(PIXELS, PIXELS))
    plotter.background_color = "white"
    radius = float(np.hypot(*section.T).max())
    _add_wall(plotter, turned(section, mill_angle), radius, float(dump["y"].max()))
    for kind, colour in enumerate(colours):
        chosen = kinds == kind
        if chosen.any():
            _add_balls(plotter, dump.positions[chosen], dump["radius"][chosen], colour)
    plotter.camera.position = (0.0, float(dump["y"].min()) - 4.0 * radius, 0.0)
    plotter.camera.focal_point = (0.0, 0.0, 0.0)
    plotter.camera.up = (0.0, 0.0, 1.0)
    plotter.camera.parallel_projection = True
    plotter.camera.parallel_scale = 1.06 * radius
    plotter.reset_camera_clipping_range()
    return plotter


def save(plotter: pv.Plotter, path: Path) -> None:
    """Write a PNG; it appears complete or not at all."""
    with writing_by_name(path) as part:
        plotter.screenshot(part)
    plotter.close()


def ball_points(dump: Dump, rising: np.ndarray) -> pv.PolyData:
    """Return the balls of a dump as points.

    Point data: every column of the dump but the positions, `velocity` (n, 3), and `rising`, 1 for
    balls that started on the rising side.

    Args:
        rising: (n,) bool.
    """
    cloud = pv.PolyData(dump.positions)
    velocity = [dump.columns[name] for name in ("vx", "vy", "vz") if name in dump.columns]
    if len(velocity) == 3:
        cloud["velocity"] = np.column_stack(velocity)
    for name, values in dump.columns.items():
        if name not in ("x", "y", "z", "vx", "vy", "vz"):
            cloud[name] = values
    cloud["rising"] = rising.astype(np.uint8)
    return cloud


def turned_liner(liner: Path, mill_angle: float) -> pv.PolyData:
    """Return a liner mesh, turned by the mill angle [rad], with its data.

    Raises:
        RunFolderError: the mesh is missing.
    """
    check_regular(liner, "millscale run FILE --runs DIR --only ID")
    mesh = pv.read(liner)
    mesh.points[:, [0, 2]] = turned(mesh.points[:, [0, 2]], mill_angle)
    return mesh


def save_balls(dump: Dump, rising: np.ndarray, path: Path) -> None:
    """Write `ball_points` for ParaView (VTK PolyData)."""
    _save_whole(ball_points(dump, rising), path)


def save_liner(liner: Path, mill_angle: float, path: Path) -> None:
    """Write `turned_liner` for ParaView (VTK PolyData)."""
    _save_whole(turned_liner(liner, mill_angle), path)


def _save_whole(mesh: pv.PolyData, path: Path) -> None:
    with writing_by_name(path) as part:
        mesh.save(part)


def _add_balls(plotter: pv.Plotter, centres: np.ndarray, radii: np.ndarray, colour: str) -> None:
    """Add balls as shaded points of their true radii: one point each, not hundreds of triangles."""
    cloud = pv.PolyData(centres)
    cloud["radius"] = radii
    actor = plotter.add_mesh(
        cloud,
        color=colour,
        style="points_gaussian",
        emissive=False,
        render_points_as_spheres=True,
        ambient=0.4,
    )
    actor.mapper.scale_array = "radius"
    actor.mapper.scale_factor = 1.0


def _add_wall(plotter: pv.Plotter, section: np.ndarray, radius: float, y: float) -> None:
    """Add the wall as a band from the section outward: its panels are not visible edge on."""
    outer = section * ((1.0 + WALL_THICKNESS) * radius / np.hypot(*section.T))[:, None]
    count = len(section)
    points = np.insert(np.vstack([section, outer]), 1, y, axis=1)
    i = np.arange(count)
    j = (i + 1) % count
    quads = np.column_stack([np.full(count, 4), i, j, j + count, i + count])
    plotter.add_mesh(pv.PolyData(points, quads.ravel()), color=WALL, lighting=False)


def _loop(segments: np.ndarray) -> list[int]:
    """Return the order of the ends of the segments (m, 2) of one closed line."""
    neighbours: dict[int, list[int]] = {}
    for a, b in segments.tolist():
        neighbours.setdefault(a, []).append(b)
        neighbours.setdefault(b, []).append(a)
    start = int(segments[0, 0])
    loop, before, now = [start], start, neighbours[start][0]
    while now != start:
        loop.append(now)
        following = [n for n in neighbours[now] if n != before]
        if not following:
            raise ValueError(f"the liner's cross-section is open at point {now}")
        before, now = now, following[0]
    return loop


def draw_all(folder: Path, pictures: Iterable[tuple[Path, Snapshot]]) -> None:
    """Draw dumps of a case, each into its PNG: balls coloured by class, or by their starting side
    if all are of one class.

    Raises:
        ValueError: a file is missing or damaged.
    """
    section, first = liner_section(folder / LINER), first_dump(folder)
    ball = load_case(folder).ball
    colours = colours_of_classes(ball) or [FALLING, RISING]
    for path, snapshot in pictures:
        dump = read_dump(snapshot.path)
        if ball.classes:
            kinds = class_of_each(dump, len(ball.classes))
        else:
            kinds = starts_on_rising_side(dump, first)
        save(draw_charge(dump, colours, kinds, section, snapshot.mill_angle), path)
