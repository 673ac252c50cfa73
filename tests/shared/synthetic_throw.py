"""Charges with a flat bed, curtains that are known bands, and a known mass in the box."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.path import Path as Polygon

from millscale.analysis.shapes.cross_section import liner_outline
from millscale.analysis.shapes.curtain import Lifters
from synthetic_case import case_document, finish_case, typed, write_campaign, write_case
from synthetic_charge import charge_columns, write_liner
from synthetic_shapes import packed_bed

END = 1.0  # mill angle of the last dump [rad]
DUMPS = (0.0, 0.5, 1.0)
CURTAIN_BALLS = 120
BED_HEIGHT = -0.2  # over R - a
DROP = 0.03  # by which the bed of the scaled mill lies lower
SHIFT = 0.04  # by which its curtains lie to the right
BALL_RADIUS = 0.1  # of the physical mill; shrinks with it, so that a few thousand balls fill it
FLOW_MEAN, FLOW_SHIFT = 0.03, 0.2


def throw_case(scheme: str, S: float, seed: int, stiffness: str = "fixed") -> dict[str, Any]:
    """Return case.json of a mill with large balls."""
    case = case_document("multi-ball", scheme, "paper", S, 1, sample_angle=0.01)
    case["ball"]["radius_m"] = BALL_RADIUS / S
    case["seed"] = seed
    case["material"]["stiffness"] = stiffness
    case["id"] += f"-{stiffness}-seed{seed}"
    return case


def throw_columns(case: dict[str, Any], mill_angle: float) -> dict[str, np.ndarray]:
    """Return the ball columns of a dump, lengths in m: the bed inside the turned liner, then two
    curtains, the fourth and the sixth."""
    unit = case["mill"]["radius_m"] - case["ball"]["radius_m"]
    scaled = case["S"] > 1.0
    a, length = case["ball"]["radius_m"] / unit, case["mill"]["simulated_length_m"] / unit
    bed, _ = packed_bed(a, length, 0.0, BED_HEIGHT - DROP * scaled, seed=case["seed"])
    liner = Polygon(liner_outline(typed(case), mill_angle) / unit)
    bed = bed[liner.contains_points(bed[:, [0, 2]])]
    bed = np.random.default_rng(0).permutation(bed)
    lifters = Lifters(25, 0.0, np.arccos(3.9 / 9.81))  # Eq. 4
    left = [k for k in range(25) if lifters.number(k, mill_angle) in (4, 6)]
    generator = np.random.default_rng(100 + case["seed"])
    falling = []
    for i in range(len(left)):
        low, high = [-0.5 + 0.4 * i, 0.0, 0.0], [-0.3 + 0.4 * i, length, 0.6]
        moved = np.array([SHIFT * scaled, 0.0, 0.0])
        falling.append(generator.uniform(low, high, (CURTAIN_BALLS, 3)) + moved)
    places = unit * np.vstack([bed, *falling])
    flying = np.arange(len(places)) >= len(bed)
    lifter = np.append(np.zeros(len(bed)), np.repeat(left, CURTAIN_BALLS))
    return {
        **dict(zip("xyz", places.T, strict=True)),
        "radius": np.full(len(places), case["ball"]["radius_m"]),
        "c_detach[1]": np.where(flying, 3, 2),
        "c_detach[24]": lifter,
    }


def write_throw(runs: Path, case: dict[str, Any], states: bool = True) -> Path:
    """Write a case with series, dumps and liner.

    Args:
        states: whether dumps name the lifters and the series holds the mass in the box.
    """
    charges = {angle: throw_columns(case, angle) for angle in DUMPS}
    count = min(columns["x"].size for columns in charges.values())
    case["ball"]["count"] = count
    charges = {  # as many balls in all: the first of the bed are left out, anywhere in it
        angle: {name: values[-count:] for name, values in columns.items()}
        for angle, columns in charges.items()
    }
    series = charge_columns(case, END)
    if states:
        angle = series["mill_angle_rad"] - FLOW_SHIFT * (case["S"] > 1.0)
        series["box_fixed_mass_fraction"] = FLOW_MEAN + 0.01 * np.sin(2.0 * np.pi * angle)
        series["box_rotating_mass_fraction"] = series["box_fixed_mass_fraction"] + 0.01
    folder = write_case(runs, case, series)
    (folder / "dump").mkdir()
    for angle, columns in charges.items():
        step = round(angle / (case["mill"]["omega_rad_s"] * case["time"]["step_s"]))
        _write_dump(folder / f"dump/charge.{step:09d}.liggghts", step, columns, states)
    write_liner(folder / "liner.stl", case)
    return folder


def write_throws(runs: Path) -> Path:
    """Write a campaign: the physical mill, two seeds at S = 2.6, and its twin at constant speed."""
    folders = [
        write_throw(runs, throw_case(*mill))
        for mill in (
            ("constant-gravity", 1.0, 1),
            ("constant-gravity", 2.6, 1),
            ("constant-gravity", 2.6, 2),
            ("constant-speed", 2.6, 1),
        )
    ]
    for folder in folders:
        finish_case(folder)
    write_campaign(runs, [folder.name for folder in folders])
    return runs


def _write_dump(path: Path, step: int, columns: dict[str, np.ndarray], states: bool) -> None:
    kept = {name: v for name, v in columns.items() if states or not name.startswith("c_")}
    count = columns["x"].size
    table = np.column_stack([np.arange(1, count + 1), np.ones(count), *kept.values()])
    header = (
        f"ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n{count}\n"
        f"ITEM: BOX BOUNDS ff pp ff\n-2 2\n0 1\n-2 2\nITEM: ATOMS id type {' '.join(kept)} "
    )
    np.savetxt(path, table, header=header, comments="", fmt="%.9g")
