"""A charge that turns as a rigid block: series, dumps and liner of a multi-ball case."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from millscale.analysis.shapes.cross_section import liner_outline, turned
from synthetic_case import case_document, typed, write_case

DUMP_ANGLES = (0.0, 0.5, 1.0)


def write_charge(runs: Path, scheme: str, balls: int = 150, radii: Sequence[float] = ()) -> Path:
    """Make a case of S = 2.6 with series, dumps and liner; with radii its balls are of these
    classes in turn."""
    case = case_document("multi-ball", scheme, "paper", 2.6, balls, sample_angle=0.02)
    case["ball"]["radius_m"] = 0.06
    if radii:
        case["ball"]["classes"] = [
            {"radius_m": x, "density_kg_m3": 2678.0, "count": len(range(k, balls, len(radii)))}
            for k, x in enumerate(radii)
        ]
    folder = write_case(runs, case, charge_columns(case))
    start = block(case, balls)
    (folder / "dump").mkdir()
    for angle in DUMP_ANGLES:
        step = round(angle / (case["mill"]["omega_rad_s"] * case["time"]["step_s"]))
        write_dump(folder / f"dump/charge.{step:09d}.liggghts", step, _turn(start, angle), case)
    write_liner(folder / "liner.stl", case)
    return folder


def charge_columns(case: dict[str, Any], end: float = 1.0) -> dict[str, np.ndarray]:
    """Return the series of a steady charge: means are known, and an oscillation has whole periods
    in each half. The torque is that of its weight and angular momentum."""
    mill, count = case["mill"], case["ball"]["count"]
    mass = case["ball"]["mass_kg"] * count
    angle = np.linspace(0.0, end, 201)
    wave, turns = np.sin(8.0 * np.pi * angle / end), 8.0 * np.pi / end
    time = angle / mill["omega_rad_s"]
    weight = mass * mill["gravity_m_s2"] * mill["radius_m"]
    work = weight * (0.37 * angle + 0.02 * (1.0 - np.cos(turns * angle)) / turns)
    momentum = (work - 0.37 * weight * angle) / mill["omega_rad_s"]
    ones = np.ones_like(angle)
    return {
        "step": np.round(time / case["time"]["step_s"]),
        "time_s": time,
        "mill_angle_rad": angle,
        "balls": count * ones,
        "mass_kg": mass * ones,
        "kinetic_translation_J": 0.3 * mass * (mill["omega_rad_s"] * mill["radius_m"]) ** 2 * ones,
        "kinetic_rotation_J": 0.01 * ones,
        "potential_J": -0.4 * weight * ones,
        "centre_x_m": -0.37 * mill["radius_m"] * ones,
        "centre_z_m": -0.4 * mill["radius_m"] * ones,
        "angular_momentum_Nms": 0.1 * weight + momentum,
        "drive_work_J": work,
        "drive_torque_Nm": weight * (0.37 + 0.02 * wave),
        "drive_power_W": weight * (0.37 + 0.02 * wave) * mill["omega_rad_s"],
        "alternating_torque_Nm": 1e-3 * weight * np.where(np.arange(angle.size) % 2, 1.0, -1.0),
        "balls_on_wall": 0.2 * count * ones,
        "balls_in_bed": 0.5 * count * ones,
        "balls_in_flight": 0.3 * count * ones,
        "liner_slip": 0.04 * ones,
    }


def block(case: dict[str, Any], balls: int) -> np.ndarray:
    """Return centres in the lower half, (balls, 3)."""
    generator = np.random.default_rng(1)
    reach = 0.85 * case["mill"]["radius_m"]
    points = generator.uniform([-reach, 0.0, -reach], [reach, 0.38, 0.0], (20 * balls, 3))
    return points[np.hypot(points[:, 0], points[:, 2]) < reach][:balls]


def write_dump(path: Path, step: int, centres: np.ndarray, case: dict[str, Any]) -> None:
    """Write a LIGGGHTS custom dump, its balls in reverse order."""
    classes = case["ball"].get("classes", [case["ball"]])
    kinds = np.arange(len(centres)) % len(classes)
    lines = [
        f"{i + 1} {k + 1} {x:.9g} {y:.9g} {z:.9g} 0 0 0 {classes[k]['radius_m']:g} "
        for i, (k, (x, y, z)) in enumerate(zip(kinds, centres, strict=True))
    ]
    header = (
        f"ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n{len(lines)}\n"
        "ITEM: BOX BOUNDS ff pp ff\n-2 2\n0 1\n-2 2\n"
        "ITEM: ATOMS id type x y z vx vy vz radius \n"
    )
    path.write_text(header + "\n".join(reversed(lines)) + "\n")


def write_liner(path: Path, case: dict[str, Any]) -> None:
    """Write an ASCII STL of the liner at rest, axis-long triangles."""
    outline = liner_outline(typed(case), 0.0)
    length = case["mill"]["length_m"]
    facets = []
    for (x0, z0), (x1, z1) in pairwise(outline):
        a, b, c, d = (x0, 0.0, z0), (x1, 0.0, z1), (x1, length, z1), (x0, length, z0)
        for triangle in ((a, b, c), (a, c, d)):
            corners = "\n".join("vertex {:.9g} {:.9g} {:.9g}".format(*p) for p in triangle)
            facets.append(f"facet normal 0 0 0\nouter loop\n{corners}\nendloop\nendfacet")
    path.write_text("solid liner\n" + "\n".join(facets) + "\nendsolid liner\n")


def _turn(centres: np.ndarray, angle: float) -> np.ndarray:
    x_z = turned(centres[:, [0, 2]], angle)
    return np.column_stack([x_z[:, 0], centres[:, 1], x_z[:, 1]])
