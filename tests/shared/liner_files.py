"""Outlines of known liners, and the files in which a person would give them."""

import math
from pathlib import Path

import ezdxf
import numpy as np

from millscale import _core
from millscale.liner.lengths import LENGTHS
from millscale.liner.lifter_rows import LifterRow, rows_outline, step_outline, wave_outline
from millscale.liner.outline import Outline, flattened
from millscale.liner.sector import COUNTER, Placing, profile_of

NOWHERE = Path("nowhere")
NOISE = 2e-3  # of a scan, in both directions [m]
INSUNITS = {"in": 1, "ft": 2, "mm": 4, "cm": 5, "m": 6}


def families(R=1.0):
    """Return one pitch of each family, in the direction of rotation, by name."""
    h = 0.06 * R
    worn = LifterRow(58 / 152 * h, 0.05 * R, math.radians(47), math.radians(20), 0.01 * R)
    new = LifterRow(h, 0.08 * R, math.radians(14), math.radians(14))
    low = LifterRow(0.4 * h, 0.08 * R, math.radians(10), math.radians(10))
    lap = LifterRow(h, 0.05 * R, math.radians(20), math.radians(70), 0.01 * R)
    half = math.pi / 8
    smooth = Outline(
        NOWHERE,
        R * np.array([[math.cos(half), -math.sin(half)], [math.cos(half), math.sin(half)]]),
        np.array([math.tan(0.5 * half), 0.0]),
        ("a", "b"),
        closed=False,
    )
    return {
        "smooth": smooth,
        "wave": wave_outline(NOWHERE, R, h, 12),
        "rib": rows_outline(NOWHERE, R, (new,), 8),
        "step": step_outline(NOWHERE, R, h, 0.1, 0.0, 10),
        "ship-lap": rows_outline(NOWHERE, R, (lap,), 8),
        "hi-lo": rows_outline(NOWHERE, R, (new, low), 12),
        "worn": rows_outline(NOWHERE, R, (worn,), 8),
    }


def shape_of(outline, R=1.0):
    """Return the profile of an outline in the direction of rotation."""
    return profile_of(outline, Placing(R, turns=COUNTER))[0]


def write_csv(path, outline, unit="mm", error=1e-4):
    """Write points of an outline, with chords in place of arcs."""
    points = flattened(outline, error)[0] / LENGTHS[unit]
    rows = "".join(f"{x:.5f},{y:.5f}\n" for x, y in points)
    path.write_text(f"x_{unit},y_{unit}\n{rows}")


def write_scan(path, outline, noise=NOISE, count=400):
    """Write points at equal distances along an outline, moved at random in both directions by up to
    `noise`."""
    chain, _ = flattened(outline, 1e-5)
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(chain, axis=0), axis=1))])
    at = np.linspace(0.0, along[-1], count)
    points = np.column_stack([np.interp(at, along, chain[:, k]) for k in (0, 1)])
    points += np.random.default_rng(7).uniform(-noise, noise, points.shape)
    rows = "".join(f"{1e3 * x:.3f},{1e3 * y:.3f}\n" for x, y in points)
    path.write_text("x_mm,y_mm\n" + rows)
    return points


def write_dxf(path, outline, unit="mm", insunits=True, layer="liner"):
    """Write an outline as a polyline with bulges."""
    drawing = ezdxf.new("R2010")
    drawing.header["$INSUNITS"] = INSUNITS[unit] if insunits else 0
    points = outline.points / LENGTHS[unit]
    rows = [(x, y, b) for (x, y), b in zip(points.tolist(), outline.bulges.tolist(), strict=True)]
    drawing.modelspace().add_lwpolyline(
        rows, format="xyb", close=outline.closed, dxfattribs={"layer": layer}
    )
    drawing.saveas(path)


def apart(one, other, most=1.2):
    """Return the largest difference of the distances of points from two liners [m]."""
    points = np.random.default_rng(3).uniform(-most, most, (4000, 2))
    return float(np.abs(one.nearest(points).distance - other.nearest(points).distance).max())


def apart_turned(one, other, most=0.004):
    """Return the same for the best of small turns: the middle of a lifter's top is not sharp."""
    turned = (
        _core.Profile(list(one.nodes), one.sectors, one.phase + angle)
        for angle in np.linspace(-most, most, 41)
    )
    return min(apart(shape, other) for shape in turned)


def trapezoids(R=1.0):
    return _core.Lifters(R, 0.92 * R, 0.06 * R, 0.6 * R, 8)
