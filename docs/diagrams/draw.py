"""Draws the diagrams of the documentation: python docs/diagrams/draw.py writes the SVG files."""

from __future__ import annotations

import math
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch

from millscale import _core

FOLDER = Path(__file__).parent
# Text as text, and the same bytes from each run.
STYLE = {"svg.fonttype": "none", "svg.hashsalt": "millscale", "font.size": 9}
LINER, BALL, MARK, GREY = "#444", "#1f77b4", "#b03a2e", "#777"
# The paper's mill, drawn with larger lifters than it has, so that their symbols fit.
RADIUS, TOP, TOP_WIDTH, GROOVE, LIFTERS = 3.9, 3.3, 0.45, 1.05, 16


def place(angle: float, radius: float) -> tuple[float, float]:
    """Return the point at a polar angle from the bottom, positive in the direction of rotation."""
    return -radius * math.sin(angle), -radius * math.cos(angle)


def blank(width: float, height: float) -> tuple[Figure, Axes]:
    figure = Figure(figsize=(width, height), layout="constrained")
    axes = figure.subplots()
    axes.set_aspect("equal")
    axes.axis("off")
    return figure, axes


def arrow(axes: Axes, begin, end, colour=MARK, style="<->", bend=0.0) -> None:
    axes.add_patch(
        FancyArrowPatch(
            begin,
            end,
            arrowstyle=style,
            mutation_scale=10,
            color=colour,
            lw=1.1,
            shrinkA=0,
            shrinkB=0,
            connectionstyle=f"arc3,rad={bend}",
        )
    )


def outline(scale: float = 1.0) -> np.ndarray:
    """Return the corners of the liner (n, 2) [m], arcs as chords within 5 mm."""
    liner = _core.Lifters(RADIUS, TOP, TOP_WIDTH, GROOVE, LIFTERS, 0.0)
    points, _ = liner.polygon(0.005)
    return scale * np.vstack([points, points[:1]])


def geometry() -> Figure:
    """The mill's cross-section with the frame, the lengths and the angles."""
    figure, axes = blank(6.2, 5.6)
    axes.plot(*outline().T, color=LINER, lw=1.4)
    axes.plot(0, 0, "+", color=LINER)
    axes.annotate("mill axis, y", (0, 0), (0.12, 0.12), color=LINER)
    arrow(axes, (0, 0), place(math.radians(-67.5), RADIUS), style="->")
    axes.text(*place(math.radians(-72), 2.3), "R", color=MARK, ha="center")
    arrow(axes, (0, 0), place(math.radians(-101.25), TOP), style="->")
    axes.text(*place(math.radians(-107), 1.9), "r", color=MARK, ha="center")
    # Widths of a lifter's top, and of a groove at the bottom.
    half = GROOVE / 2.0
    arrow(axes, (-half, -RADIUS - 0.22), (half, -RADIUS - 0.22))
    axes.text(0, -RADIUS - 0.62, "D2", color=MARK, ha="center")
    angle = math.radians(360 / LIFTERS / 2)
    across = np.array([-math.cos(angle), math.sin(angle)]) * TOP_WIDTH / 2.0
    middle = np.array(place(angle, TOP - 0.16))
    arrow(axes, middle - across, middle + across)
    axes.text(*place(angle, TOP - 0.55), "D1", color=MARK, ha="center")
    # A ball on the rising side, its polar angle and its angle from the vertical.
    at = place(math.radians(90), RADIUS - 0.25)
    axes.add_patch(mpl.patches.Circle(at, 0.25, facecolor=BALL, alpha=0.6))
    axes.text(at[0] + 0.36, at[1] - 0.1, "ball of radius a", color=BALL)
    for begin, name, radius in ((0.0, "psi", 1.0), (math.pi, "alpha", 1.35)):
        turn = np.linspace(begin, math.radians(128), 60)
        axes.plot(*np.array([place(t, radius) for t in turn]).T, color=GREY, lw=1)
        axes.text(*place(turn[30], radius + 0.25), name, color=GREY, ha="center")
    axes.plot(*zip((0, 0), place(math.radians(128), 2.9), strict=True), color=GREY, lw=1, ls="--")
    axes.plot((0, 0), (-1.2, 1.6), color=GREY, lw=1, ls="--")
    # Rotation, gravity and axes.
    arrow(axes, place(math.radians(25), 4.6), place(math.radians(60), 4.6), LINER, "->", -0.15)
    axes.text(*place(math.radians(43), 5.1), "omega", color=LINER, ha="center")
    arrow(axes, (4.6, 3.4), (4.6, 2.4), LINER, "->")
    axes.text(4.75, 2.8, "g", color=LINER)
    arrow(axes, (4.2, -4.2), (5.2, -4.2), LINER, "->")
    arrow(axes, (4.2, -4.2), (4.2, -3.2), LINER, "->")
    axes.text(5.25, -4.3, "x", color=LINER)
    axes.text(4.1, -3.1, "z", color=LINER)
    return figure


def scheme() -> Figure:
    """The physical mill and a scaled mill of S = 2: the same balls, half the radius."""
    figure, axes = blank(7.0, 4.0)
    rng = np.random.default_rng(1)
    for x, S, title in ((0.0, 1.0, "physical mill, S = 1"), (7.4, 2.0, "scaled mill, S = 2")):
        axes.plot(*np.add(outline(1 / S), (x, 0.0)).T, color=LINER, lw=1.2)
        radius = RADIUS / S
        for row in np.arange(0.35, 0.9 * radius, 0.27):
            half = 0.78 * math.sqrt(max(radius**2 - (radius - row) ** 2, 0.0))
            for along in np.arange(-half, half, 0.27):
                # The surface stands at 35 degrees, higher on the rising side.
                px, pz = along, -radius + row + 0.1 / S
                if pz > -0.35 * radius - 0.7 * px or math.hypot(px, pz) > 0.84 * radius:
                    continue
                shift = 0.03 * rng.standard_normal(2)
                centre = (x + px + shift[0], pz + shift[1])
                axes.add_patch(mpl.patches.Circle(centre, 0.13, facecolor=BALL, alpha=0.55))
        axes.text(x, RADIUS + 0.35, title, ha="center", weight="bold")
    arrow(axes, (4.2, 0.0), (5.2, 0.0), LINER, "->")
    words = (
        "same balls, same Froude number\n"
        "radius R / S, length L / S\n\n"
        "constant gravity:\n  omega sqrt(S), energy of a ball E / S\n"
        "constant speed:\n  g / S, energy of a ball E / S^2"
    )
    axes.text(9.7, 0.0, words, va="center")
    axes.set_xlim(-4.2, 15.6)
    return figure


def data_flow() -> Figure:
    """The stages of a campaign and the files between them."""
    figure, axes = blank(7.4, 4.8)
    boxes = {
        "campaign.toml": (0, 6),
        "case.json": (0, 4.5),
        "liner.stl": (-2.6, 3),
        "charge.data": (0, 3),
        "decks *.in": (2.6, 3),
        "series.csv, dump/": (0, 1.5),
        "result.json": (0, 0),
        "report/index.html": (-3.5, -1.5),
        "speed-against-error.json": (0, -1.5),
        "physical mill, interval": (3.8, -1.5),
    }
    for name, (x, y) in boxes.items():
        width = 0.24 + 0.125 * len(name)
        box = FancyBboxPatch((x - width / 2, y - 0.22), width, 0.44, boxstyle="round,pad=0.08")
        box.set(facecolor="#eef3f8", edgecolor=LINER, lw=0.9)
        axes.add_patch(box)
        axes.text(x, y, name, ha="center", va="center")
    links = (
        ("campaign.toml", "case.json", "law, limits, cost"),
        ("case.json", "liner.stl", "gmsh"),
        ("case.json", "charge.data", "packing"),
        ("case.json", "decks *.in", "templates"),
        ("liner.stl", "series.csv, dump/", ""),
        ("charge.data", "series.csv, dump/", "mpirun liggghts_mill"),
        ("decks *.in", "series.csv, dump/", ""),
        ("series.csv, dump/", "result.json", "analysis"),
        ("result.json", "report/index.html", "report"),
        ("result.json", "speed-against-error.json", "study"),
        ("result.json", "physical mill, interval", "predict"),
    )
    for begin, end, name in links:
        a, b = np.array(boxes[begin], float), np.array(boxes[end], float)
        a[1] -= 0.32
        b[1] += 0.32
        arrow(axes, a, b, GREY, "->")
        if name:
            words = axes.text(*((a + b) / 2), name, color="#555", ha="center", va="center")
            words.set(style="italic", bbox={"facecolor": "white", "edgecolor": "none", "pad": 1})
    axes.set_xlim(-5.0, 5.6)
    axes.set_ylim(-2.1, 6.5)
    return figure


DIAGRAMS = {"geometry": geometry, "scheme": scheme, "data-flow": data_flow}


def draw(folder: Path) -> None:
    """Write every diagram to a folder."""
    with mpl.rc_context(STYLE):
        for name, figure in DIAGRAMS.items():
            figure().savefig(folder / f"{name}.svg", metadata={"Date": None})


if __name__ == "__main__":
    draw(FOLDER)
