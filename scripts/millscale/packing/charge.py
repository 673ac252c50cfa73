"""The initial packing of a charge, from the bottom of the mill up, as a data file of the engine."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from millscale import _core
from millscale.campaign.campaign import Ball, BallClass
from millscale.errors import CampaignError
from millscale.packing.ball_sizes import class_counts, draw_kinds, draw_radii, mean_volume
from millscale.packing.random_block import close_pairs, random_block
from millscale.runs.atom_types import atom_types
from millscale.runs.case_file import Balls, Case
from millscale.runs.liner import liner_of
from millscale.runs.writing import writing

FILE = "charge.data"
# Volume of balls over volume, tried from the densest. A settled bed has 0.58 to 0.61, so a charge
# packed at 0.55 falls by a few balls only; thin slices take less.
FRACTIONS = (0.55, 0.50, 0.45, 0.40)
# Balls in the block that is repeated, and its least width in mean diameters.
BLOCK = 4000
WIDTH = 6.0
# The same in largest diameters, of a mixture.
LEAST_WIDTH = 3.0
# Of the places expected: the ends of a bed do not fall on whole balls.
SURE = 0.95
# Points to a radius, for an area that is good to a percent.
GRID = 100


@dataclass(frozen=True)
class Room:
    """Where balls may be put.

    Attributes:
        liner: _core.Profile.
        length: period along the axis, or distance of the end walls [m].
        gap: kept clear of the liner, whose panels cut its arcs [m].
        closed: end walls at 0 and `length` instead of a period.
    """

    liner: _core.Profile
    length: float
    gap: float = 0.0
    closed: bool = False


@dataclass(frozen=True)
class Packing:
    """Balls at rest that touch neither each other nor the liner.

    Attributes:
        centres: (n, 3) float, x, y, z [m], 0 <= y < length.
        radii: (n,) float [m].
        length: period along y, or distance of the end walls [m].
        closed: end walls instead of a period.
        kinds: (n,) int, class of each ball from 0 on; None: all of one.
    """

    centres: np.ndarray
    radii: np.ndarray
    length: float
    closed: bool = False
    kinds: np.ndarray | None = None


def write_charge(case: Case, folder: Path) -> None:
    """Write charge.data of a multi-ball case to a folder.

    Raises:
        CampaignError: the balls do not fit into the mill.
    """
    ball, room = case.ball, room_of(case)
    packing = pack(room, sizes_of(ball), ball.count, np.random.default_rng(case.seed))
    densities = [one.density_kg_m3 for one in ball.classes] or [ball.density_kg_m3]
    types = len(atom_types(case).all)
    write_data(packing, densities, case.domain.half_box_m, Path(folder) / FILE, types)


def sizes_of(ball: Balls) -> Ball:
    """Return the sizes of the balls of a case."""
    classes = tuple(
        BallClass(one.radius_m, one.density_kg_m3, one.count / ball.count) for one in ball.classes
    )
    return Ball(ball.radius_m, ball.density_kg_m3, ball.radius_std_m, ball.truncation, classes)


def room_of(case: Case) -> Room:
    """Return the room for the charge of a case."""
    mill = case.mill
    closed = mill.ends != "periodic"
    return Room(liner_of(mill), mill.simulated_length_m, case.wall.chord_error_m, closed)


def pack(room: Room, ball: Ball, count: int, random: np.random.Generator) -> Packing:
    """Pack balls from the bottom of the mill up to a level, at random and almost as dense as a bed.

    A random block that repeats itself fills the plane of the cross-section; what does not lie clear
    of the liner is taken away, whatever its size, and the lowest balls of each class are kept. The
    block is as long as the mill, so the ends fit, also as walls.

    Raises:
        CampaignError: there are fewer places than balls.
    """
    centres, radii, kinds, width = _block(room, ball, count, random)
    counts = np.array(class_counts(ball, count) if ball.classes else [count])
    clearance = float(radii.max()) + room.gap
    beside = width * np.arange(-math.ceil(room.liner.radius / width) - 1, room.liner.radius / width)
    offset = random.uniform(0.0, width, 2)
    chosen, places, found = [], [], np.zeros(len(counts), int)
    # Rows of blocks, the lowest first; they do not overlap in height.
    for level in beside:
        x = (centres[:, 0] + offset[0] + beside[:, None]).ravel()
        z = np.tile(centres[:, 2] + offset[1] + level, len(beside))
        section = np.column_stack([x, z])
        clear = np.flatnonzero(room.liner.nearest(section).distance >= clearance)
        places.append(section[clear])
        chosen.append(clear % len(radii))
        found += np.bincount(kinds[clear % len(radii)], minlength=len(counts))
        if (found >= counts).all():
            break
    else:
        raise CampaignError(FILE, "", f"{count} balls do not fit", f"<= {found.sum()} balls")
    section, which = np.concatenate(places), np.concatenate(chosen)
    order = np.argsort(section[:, 1], kind="stable")
    kept = [order[kinds[which[order]] == k][:n] for k, n in enumerate(counts)]
    lowest = np.concatenate(kept)
    lowest = lowest[np.argsort(section[lowest, 1], kind="stable")]
    section, which = section[lowest], which[lowest]
    packed = np.column_stack([section[:, 0], centres[which, 1], section[:, 1]])
    return Packing(packed, radii[which], room.length, room.closed, kinds[which])


def capacity(room: Room, ball: Ball) -> int:
    """Return a number of balls that `pack` always finds places for."""
    largest = ball.largest
    area = _free_area(room.liner, largest + room.gap)
    return int(SURE * FRACTIONS[-1] * area * room.length / mean_volume(ball))


def _free_area(liner: _core.Profile, clear: float) -> float:
    """Return the area of the cross-section farther than a distance [m] from the liner [m^2].

    That of the liner moved inward, which cuts corners at lifter edges a little; where the grooves
    close by that, of the points of a grid.
    """
    try:
        return liner.offset(clear).area
    except ValueError:
        spacing = liner.radius / GRID
        grid = spacing * np.arange(-GRID, GRID + 1)
        points = np.stack(np.meshgrid(grid, grid), axis=-1).reshape(-1, 2)
        return float((liner.nearest(points).distance >= clear).sum()) * spacing**2


def _block(
    room: Room, ball: Ball, count: int, random: np.random.Generator
) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Return the centres (n, 3), radii (n,) and classes (n,) of the balls of a random block, and
    its width in x and z [m]."""
    volume = mean_volume(ball)
    narrowest = 2.0 * WIDTH * ball.radius
    if ball.classes:
        narrowest = 2.0 * max(WIDTH * ball.mean_by_number, LEAST_WIDTH * ball.largest)
    for fraction in FRACTIONS:
        least = math.ceil(fraction * narrowest**2 * room.length / volume)
        number = max(least, min(count, BLOCK))
        kinds = draw_kinds(ball, number, random)
        radii = (
            np.array([one.radius for one in ball.classes])[kinds]
            if ball.classes
            else draw_radii(ball, number, random)
        )
        solid = 4.0 / 3.0 * math.pi * float((radii**3).sum())
        width = math.sqrt(solid / (fraction * room.length))
        centres = random_block(radii, np.array([width, room.length, width]), random, room.closed)
        if centres is not None:
            return centres, radii, kinds, width
    raise CampaignError(
        FILE, "", f"no packing of {FRACTIONS[-1]} found in {room.length:g} m", "a longer slice"
    )


def periodic_tree(packing: Packing) -> tuple[cKDTree, np.ndarray]:
    """Return a tree of the centres, periodic along y unless closed, and its origin, (3,) float [m].

    The origin is subtracted from positions before a query.

    A tree is periodic in all axes or none: where there is no period it is put out of reach, for
    points up to a largest diameter outside the centres.
    """
    reach = 2.0 * packing.radii.max()
    origin = packing.centres.min(axis=0) - reach
    period = np.ptp(packing.centres, axis=0) + 4.0 * reach
    if not packing.closed:
        origin[1], period[1] = 0.0, packing.length
    return cKDTree(packing.centres - origin, boxsize=period), origin


def largest_overlap(packing: Packing) -> float:
    """Return the largest overlap of two balls [m], also across periodic ends; at least 0."""
    if not packing.closed and packing.length < 2.0 * packing.radii.max():
        return float(2.0 * packing.radii.max() - packing.length)
    return max(0.0, float(overlaps(packing)[1].max(initial=0.0)))


def overlaps(packing: Packing, gap: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Return pairs of neighbours, (n, 2) int, and their overlaps [m], (n,) float.

    All pairs with a separation up to `gap` [m] are among them, also across periodic ends. Their
    overlap is negative.
    """
    centres, radii = packing.centres, packing.radii
    tree, origin = periodic_tree(packing)
    pairs = close_pairs(centres - origin, radii, tree.boxsize, gap)
    apart = np.abs(centres[pairs[:, 0]] - centres[pairs[:, 1]])
    if not packing.closed:
        apart[:, 1] = np.minimum(apart[:, 1], packing.length - apart[:, 1])
    touching = radii[pairs].sum(axis=1)
    return pairs, touching - np.linalg.norm(apart, axis=1)


def write_data(
    packing: Packing, densities: Sequence[float], half_box: float, path: Path, types: int = 2
) -> None:
    """Write a packing as a data file of atom style granular: id type diameter density x y z.

    The first types are the classes of balls; walls have the others. Written under another name and
    renamed.

    Args:
        densities: of each class [kg/m^3].
    """
    header = (
        f"initial packing, SI units\n\n{len(packing.radii)} atoms\n{types} atom types\n\n"
        f"{-half_box!r} {half_box!r} xlo xhi\n0.0 {packing.length!r} ylo yhi\n"
        f"{-half_box!r} {half_box!r} zlo zhi\n\nAtoms\n\n"
    )
    kinds = packing.kinds if packing.kinds is not None else np.zeros(len(packing.radii), int)
    rows = zip(
        kinds.tolist(), (2.0 * packing.radii).tolist(), packing.centres.tolist(), strict=True
    )
    lines = (
        f"{i} {kind + 1} {diameter!r} {densities[kind]!r} {x!r} {y!r} {z!r}\n"
        for i, (kind, diameter, (x, y, z)) in enumerate(rows, 1)
    )
    with writing(path) as file:
        file.write(header.encode("ascii"))
        file.writelines(line.encode("ascii") for line in lines)
