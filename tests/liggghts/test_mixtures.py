"""Mixtures of three classes of balls and of 1 : 10: forces against stock, momentum."""

from dataclasses import replace

import numpy as np
import pytest

from bed import assert_same, run_bed
from millscale import _core
from millscale.engine.material_block import material_block
from millscale.packing.charge import Room, pack, write_data
from mixture import charge_of
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


def _deck(folder, name, swell=True):
    """A deck, up to its first run, of a packing, by default swollen until its balls overlap."""
    sizes, count, swollen = MIXTURES[name]
    ball = charge_of(sizes)
    packing = pack(Room(DRUM, LENGTH), ball, count, np.random.default_rng(4))
    if swell:
        packing = replace(packing, radii=swollen * packing.radii)
    kinds, types = len(sizes), len(sizes) + 1
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


def momenta(state, radii, masses):
    """Momentum [kg m/s] and angular momentum about the mill's axis [kg m^2/s] of each ball, (n, 4)
    float."""
    (x, _, z), (vx, _, vz) = state["x y z"].T, state["vx vy vz"].T
    spin = state["omegax omegay omegaz"][:, 1]
    angular = masses * (z * vx - x * vz + 0.4 * radii**2 * spin)
    return np.column_stack([masses[:, None] * state["vx vy vz"], angular])


@pytest.mark.parametrize("options", ["", "memory stock"], ids=["own history", "stock history"])
@pytest.mark.parametrize("name", MIXTURES)
def test_a_free_mixture_keeps_its_momentum(tmp_path, name, options):
    """Without wall and gravity, classes that fly through each other keep the sums of momenta."""
    deck = _deck(tmp_path, name, swell=False)
    free = [line for line in deck.splitlines() if not line.startswith(("fix liner", "fix mill"))]
    free = with_contacts("\n".join(free) + "\n", "fast", options)
    atoms = (tmp_path / "charge.data").read_text().partition("Atoms\n\n")[2]
    rows = np.loadtxt(atoms.splitlines())
    radii = 0.5 * rows[:, 2]
    masses = 4.0 / 3.0 * np.pi * radii**3 * rows[:, 3]
    first, last = (momenta(run_bed(tmp_path, free, steps), radii, masses) for steps in (0, 3000))
    # A quarter of the balls of every class have exchanged a hundredth of their momentum or more.
    exchanged = np.linalg.norm((last - first)[:, :3], axis=1)
    for kind in np.unique(rows[:, 1]):
        own = rows[:, 1] == kind
        assert np.quantile(exchanged[own] / np.linalg.norm(first[own, :3], axis=1), 0.75) > 0.01
    # 3000 steps that each round by 1e-16 of what is added up.
    assert np.abs((last - first).sum(axis=0) / np.abs(first).sum(axis=0)).max() < 3e-13
