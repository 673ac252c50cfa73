"""A charge and its liner in 3-D."""

from __future__ import annotations

import pyvista as pv

WALL = "#7a828b"

TITLES = {"speed": "speed [m/s]", "radius": "radius [m]", "rising": "started rising"}


def charge_view(charge: pv.MultiBlock, colour: str) -> pv.Plotter:
    """Return a view of the blocks `balls` and `liner` along the axis and from above; z is up.

    Args:
        colour: name of the point data that colours the balls.

    Raises:
        ValueError: the balls have no such data.
    """
    balls = charge["balls"]
    if colour not in balls.point_data:
        known = ", ".join(sorted(balls.point_data.keys()))
        raise ValueError(f"colour: got {colour!r}; accepted: {known}")
    plotter = pv.Plotter()
    plotter.background_color = "white"
    plotter.add_mesh(charge["liner"], color=WALL, opacity=0.35)
    # Spheres of a few triangles each: widgets of notebooks draw no sized points.
    ball = pv.Sphere(radius=1.0, theta_resolution=10, phi_resolution=8)
    spheres = balls.glyph(scale="radius", orient=False, geom=ball, factor=1.0)
    plotter.add_mesh(
        spheres,
        scalars=colour,
        cmap="viridis",
        scalar_bar_args={"title": TITLES.get(colour, colour), "color": "black"},
    )
    radius = 0.5 * (balls.bounds[1] - balls.bounds[0])
    plotter.camera.position = (-1.2 * radius, balls.bounds[2] - 4.5 * radius, 1.2 * radius)
    plotter.camera.focal_point = charge["liner"].center
    plotter.camera.up = (0.0, 0.0, 1.0)
    plotter.reset_camera()
    return plotter
