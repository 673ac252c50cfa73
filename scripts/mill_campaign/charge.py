"""The initial packing of a charge, from the bottom of the mill up, as a data file of the engine."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mill_core
import numpy as np
from scipy.spatial import cKDTree

from mill_campaign.ball_sizes import draw_radii
from mill_campaign.config import Ball
from mill_campaign.errors import CampaignError

FILE = "charge.data"
# Gap between the places of the lattice, in ball diameters, used up by random displacements.
# Measured on a settled slice of the S = 2.6 mill: 0.03 across the axis only leaves a crystal (solid
# fraction 0.65, six-fold order 0.74); 0.15 in all directions a random bed (0.58, 0.04).
SLACK = 0.15
# Balls of the lattice may just touch; rounding must not make them overlap.
ROUNDING = 1e-6


@dataclass(frozen=True)
class Room:
    """Where balls may be put.

    Attributes:
        liner: mill_core.Liner.
        length: period along the axis [m].
        gap: kept clear of the liner, whose panels cut its arcs [m].
    """

    liner: mill_core.Liner
    length: float
    gap: float = 0.0


@dataclass(frozen=True)
class Packing:
    """Balls at rest that touch neither each other nor the liner.

    Attributes:
        centres: (n, 3) float, x, y, z [m], 0 <= y < length.
        radii: (n,) float [m].
        length: period along y [m].
    """

    centres: np.ndarray
    radii: np.ndarray
    length: float


def write_charge(case: Mapping[str, Any], folder: Path) -> None:
    """Write charge.data of a multi-ball case to a folder.

    Raises:
        CampaignError: the balls do not fit into the mill.
    """
    ball, room = case["ball"], room_of(case)
    sizes = Ball(ball["radius_m"], ball["density_kg_m3"], ball["radius_std_m"], ball["truncation"])
    packing = pack(room, sizes, ball["count"], np.random.default_rng(case["seed"]))
    write_data(packing, sizes.density, case["domain"]["half_box_m"], Path(folder) / FILE)


def room_of(case: Mapping[str, Any]) -> Room:
    """Room for the charge of a case."""
    return Room(liner_of(case), case["mill"]["simulated_length_m"], case["wall"]["chord_error_m"])


def liner_of(case: Mapping[str, Any]) -> mill_core.Liner:
    """The scaled mill's liner as case.json states it."""
    mill = case["mill"]
    return mill_core.Liner(
        mill["radius_m"],
        mill["lifter_top_radius_m"],
        mill["lifter_top_width_m"],
        mill["groove_width_m"],
        mill["lifters"],
        mill["phase_rad"],
    )


def pack(room: Room, ball: Ball, count: int, random: np.random.Generator) -> Packing:
    """Pack balls on columns along the axis that stand on a hexagonal lattice of the cross-section.

    Columns are filled from the lowest up and shifted along the axis at random. Every ball is then
    displaced at random within its share of the lattice's slack, so that no ball can reach another:
    neighbouring columns stay a largest diameter apart, and so do balls of one column.

    Raises:
        CampaignError: there are fewer places than balls.
    """
    radii = draw_radii(ball, count, random)
    largest = float(radii.max())
    columns, per_column = _places(room, largest)
    if per_column * len(columns) < count:
        most = per_column * len(columns)
        raise CampaignError(FILE, "", f"{count} balls do not fit", f"<= {most} balls")
    needed = columns[: math.ceil(count / per_column)]
    column = np.repeat(np.arange(len(needed)), per_column)[:count]
    place = np.tile(np.arange(per_column), len(needed))[:count]
    spacing = room.length / per_column
    play = max(0.0, 0.5 * spacing - largest * (1.0 + ROUNDING))
    shift = random.uniform(0.0, room.length, len(needed))[column]
    y = place * spacing + shift + play * random.uniform(-1.0, 1.0, count)
    angle = random.uniform(0.0, math.tau, count)
    reach = (SLACK - ROUNDING) * largest * random.uniform(0.0, 1.0, count)
    x = needed[column, 0] + reach * np.cos(angle)
    z = needed[column, 1] + reach * np.sin(angle)
    return Packing(np.column_stack([x, _wrapped(y, room.length), z]), radii, room.length)


def capacity(room: Room, largest: float) -> int:
    """The most balls of a radius `largest` [m] that `pack` finds a place for."""
    columns, per_column = _places(room, largest)
    return per_column * len(columns)


def _places(room: Room, largest: float) -> tuple[np.ndarray, int]:
    """(n, 2) float, x and z of the columns [m] from the lowest up, and the balls of a column."""
    spacing = 2.0 * largest * (1.0 + SLACK)
    height = spacing * math.sqrt(3.0) / 2.0
    n, rows = math.ceil(room.liner.radius / spacing) + 1, math.ceil(room.liner.radius / height) + 1
    i, row = np.meshgrid(np.arange(-n, n + 1), np.arange(-rows, rows + 1))
    points = np.column_stack([((i + 0.5 * (row % 2)) * spacing).ravel(), (row * height).ravel()])
    clear = room.liner.nearest(points).distance >= largest * (1.0 + SLACK) + room.gap
    columns = points[clear][np.lexsort((points[clear, 0], points[clear, 1]))]
    return columns, max(1, math.floor(room.length / spacing))


def _wrapped(y: np.ndarray, length: float) -> np.ndarray:
    """Positions in [0, length), also where rounding takes the remainder to `length`."""
    wrapped = np.mod(y, length)
    return np.where(wrapped >= length, 0.0, wrapped)


def periodic_tree(packing: Packing) -> tuple[cKDTree, np.ndarray]:
    """Tree of the centres, periodic along y, and the point (3,) [m] to take off positions first.

    A tree is periodic in all axes or none: in x and z the period is put out of reach, for points up
    to a largest diameter outside the centres.
    """
    reach = 2.0 * packing.radii.max()
    origin = packing.centres.min(axis=0) - reach
    period = np.ptp(packing.centres, axis=0) + 4.0 * reach
    origin[1], period[1] = 0.0, packing.length
    return cKDTree(packing.centres - origin, boxsize=period), origin


def largest_overlap(packing: Packing) -> float:
    """Largest overlap of two balls, also across the periodic ends [m]; 0 if none overlap."""
    if packing.length < 2.0 * packing.radii.max():
        return float(2.0 * packing.radii.max() - packing.length)
    centres, radii = packing.centres, packing.radii
    tree, _ = periodic_tree(packing)
    pairs = tree.query_pairs(2.0 * radii.max(), output_type="ndarray")
    if len(pairs) == 0:
        return 0.0
    apart = np.abs(centres[pairs[:, 0]] - centres[pairs[:, 1]])
    apart[:, 1] = np.minimum(apart[:, 1], packing.length - apart[:, 1])
    touching = radii[pairs].sum(axis=1)
    return max(0.0, float((touching - np.linalg.norm(apart, axis=1)).max()))


def write_data(packing: Packing, density: float, half_box: float, path: Path) -> None:
    """Write a packing as a data file of atom style granular: id type diameter density x y z.

    Type 1 is a ball; type 2, the liner's, has none. Written under another name and renamed.
    """
    header = (
        f"initial packing, SI units\n\n{len(packing.radii)} atoms\n2 atom types\n\n"
        f"{-half_box!r} {half_box!r} xlo xhi\n0.0 {packing.length!r} ylo yhi\n"
        f"{-half_box!r} {half_box!r} zlo zhi\n\nAtoms\n\n"
    )
    rows = zip((2.0 * packing.radii).tolist(), packing.centres.tolist(), strict=True)
    lines = (
        f"{i} 1 {diameter!r} {density!r} {x!r} {y!r} {z!r}\n"
        for i, (diameter, (x, y, z)) in enumerate(rows, 1)
    )
    part = path.with_name(path.name + ".part")
    with part.open("w") as stream:
        stream.write(header)
        stream.writelines(lines)
    part.replace(path)
