"""Mixtures of three classes of balls and of 1 : 10: forces and torques against stock."""

from dataclasses import replace

import numpy as np
import pytest

from bed import assert_same, run_bed
from millscale import _core
from millscale.campaign.campaign import Ball, BallClass
from millscale.engine.material_block import material_block
from millscale.packing.charge import Room, pack, write_data
from scene import HEAD, STOCK_CONTACTS, with_contacts

pytestmark = pytest.mark.engine

DRUM = _core.Lifters(0.5, 0.0, 0.0, 0.0, 0)
LENGTH = 0.1
# Radii and shares by mass of the classes, number of balls, factor by which they are swollen.
MIXTURES = {
    "1 : 1.5 : 2.5": (((0.008, 0.3), (0.012, 0.3), (0.02, 0.4)), 600, 1.015),
    "1 : 10": (((0.004, 0.3), (0.04, 0.7)), 2000, 1.06),
}
DENSITIES = (2700.0, 7800.0, 4000.0)


def _deck(folder, name):
    """A deck, up to its first run, of a packing whose balls are swollen until they overlap."""
    sizes, count, swollen = MIXTURES[name]
    numbers = [mass / radius**3 for radius, mass in sizes]
    classes = tuple(
        BallClass(radius, 1.0, n / sum(numbers))
        for (radius, _), n in zip(sizes, numbers, strict=True)
    )
    ball = Ball(sum(a * m for a, m in sizes), 1.0, 0.0, 2.0, classes)
    packing = pack(Room(DRUM, LENGTH), ball, count, np.random.default_rng(4))
    packing = replace(packing, radii=swollen * packing.radii)
    kinds, types = len(classes), len(classes) + 1
    folder.mkdir(exist_ok=True)
    write_data(packing, DENSITIES[:kinds], 0.6, folder / "charge.data", types)
    random = np.random.default_rng(7)

    def of_pairs(low, high):
        values = random.uniform(low, high, (types, types))
        return (0.5 * (values + values.T)).ravel()

    block = material_block(
        random.uniform(3e7, 9e7, types),
        random.uniform(0.2, 0.4, types),
        restitution=of_pairs(0.2, 0.8),
        friction=of_pairs(0.2, 0.6),
        rolling_friction=of_pairs(0.01, 0.1),
    )
    moving = "".join(
        f"group kind{k} type {k}\nvelocity kind{k} set {0.3 * k} {-0.2 * k} {0.1 - 0.15 * k}\n"
        for k in range(1, types)
    )
    return (
        f"{HEAD}read_data charge.data\n{block}neighbor 0.004 bin\n{STOCK_CONTACTS}\n"
        f"pair_coeff * *\ntimestep 1e-5\n{moving}"
        f"fix liner all wall/mill mill mill type {types}\n"
        "fix mill all mill/similarity radius 0.5 gravity 9.81 omega 3 ball_radius 0.01 start now\n"
        "fix integrate all nve/sphere\nthermo_modify lost error\n"
    )


def types_of(folder):
    """Type of each ball, in the order of ids."""
    lines = (folder / "charge.data").read_text().partition("Atoms\n\n")[2].splitlines()
    return np.array([int(line.split()[1]) for line in lines])


@pytest.mark.parametrize("steps", [0, 1])
@pytest.mark.parametrize("name", MIXTURES)
def test_forces_and_torques_of_a_mixture_are_those_of_stock(tmp_path, name, steps):
    deck = _deck(tmp_path, name)
    stock = run_bed(tmp_path, deck, steps)
    fast = run_bed(tmp_path, with_contacts(deck, "fast", "memory stock"), steps)
    assert np.abs(stock["fx fy fz"]).max() > 1.0
    assert np.abs(stock["tqx tqy tqz"]).max() > 1e-5
    # Balls of every class are in contact.
    touched = np.abs(stock["fx fy fz"]).max(axis=1) > 1.0
    assert set(types_of(tmp_path)[touched]) == set(types_of(tmp_path))
    assert_same(fast, stock, 1e-12)
