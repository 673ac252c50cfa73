"""The solid fraction of a settled bed of three classes against published models of mixtures."""

import numpy as np
import pytest

from millscale import _core
from millscale.engine.material_block import material_block
from millscale.packing.bed import bed_record
from millscale.packing.charge import Room, pack, write_data
from mixture import charge_of
from published_mixtures import linear_packing, rod_spacing, rods
from scene import HEAD, STOCK_CONTACTS, run, with_contacts

pytestmark = pytest.mark.engine

DENSITY, GRAVITY = 2678.0, 9.81
# Radii [m] and shares by mass.
THREE = ((0.008, 0.3), (0.012, 0.3), (0.02, 0.4))
ONE = ((0.012, 1.0),)
RADII, SHARES = np.array(THREE).T
LARGE = Room(_core.Lifters(0.4, 0.0, 0.0, 0.0, 0), 0.2)


def settled_fraction(folder, sizes, count, room, seed, settle, friction):
    """Return the solid fraction of a bed that fell into a resting drum."""
    folder.mkdir()
    ball, types = charge_of(sizes), len(sizes) + 1
    packing = pack(room, ball, count, np.random.default_rng(seed))
    radius = room.liner.radius
    write_data(packing, [DENSITY] * len(sizes), 1.02 * radius, folder / "charge.data", types)

    def of_pairs(value):
        return [value] * types**2

    block = material_block(
        [5.98e7] * types,
        [0.3] * types,
        restitution=of_pairs(0.1),
        friction=of_pairs(friction),
        rolling_friction=of_pairs(0.02 * friction),
    )
    # A seventh of the Rayleigh time of the smallest ball.
    step = 5e-3 * min(radius for radius, _ in sizes)
    deck = (
        f"{HEAD}read_data charge.data\n{block}neighbor 0.004 bin\n{STOCK_CONTACTS}\n"
        f"pair_coeff * *\ntimestep {step!r}\nfix liner all wall/mill mill mill type {types}\n"
        f"fix mill all mill/similarity radius {radius!r} gravity {GRAVITY} omega 1 "
        f"ball_radius {ball.radius!r} start never\n"
        "fix integrate all nve/sphere\nthermo_modify lost error\n"
        f"run {round(settle / step)}\n"
        "write_dump all custom settled.dump x y z vx vy vz radius modify format "
        f'"{" ".join(["%.9g"] * 7)}"\n'
    )
    result = run(folder, with_contacts(deck))
    assert result.code == 0, result.text[-600:]
    return bed_record(folder / "settled.dump", room, GRAVITY)["bulk_fraction"]


def fractions(folder, room, counts, seeds, settle=0.6, friction=0.0):
    """Return the mean solid fractions of beds of one size and of three classes, and print them."""
    one, three = (
        float(
            np.mean(
                [
                    settled_fraction(
                        folder / f"{len(sizes)}-{seed}", sizes, count, room, seed, settle, friction
                    )
                    for seed in seeds
                ]
            )
        )
        for sizes, count in zip((ONE, THREE), counts, strict=True)
    )
    models = [model(RADII, SHARES, one) for model in (rods, linear_packing)]
    off = ", ".join(f"{three / of_model - 1.0:+.2%}" for of_model in models)
    print(f"friction {friction}: {one:.4f}, {three:.4f}; from rods, linear packing: {off}")
    return one, three


@pytest.mark.validate
def test_a_bed_of_three_classes_is_as_dense_as_the_rods_of_farr_and_groot(tmp_path):
    # Without friction balls settle to the densest random packing, of which the models are.
    one, three = fractions(tmp_path, LARGE, (4500, 6500), (1, 2, 3))
    # 1 % is the tolerance of the issue. A bed's fraction has a standard error of 0.25 % by its
    # sample points and as much by chance: 0.3 % of the ratio of two means of three beds.
    assert three == pytest.approx(rods(RADII, SHARES, one), rel=0.01)
    # The linear model is of balls placed one by one to the best effect, so chance stays below it.
    assert one < three < linear_packing(RADII, SHARES, one)


@pytest.mark.validate
def test_friction_keeps_a_bed_of_three_classes_looser_than_the_rods(tmp_path):
    # The models know no friction, so no tolerance follows from them: 2.8 % less was measured.
    one, three = fractions(tmp_path, LARGE, (4500, 6500), (1, 2, 3), friction=0.545)
    assert one < three < 0.99 * rods(RADII, SHARES, one)


def test_a_small_bed_of_three_classes_is_nearly_as_dense(tmp_path):
    # A third of the balls, so twice the chance, and one bed: 2 standard errors of 0.8 %, and as
    # the walls of a small drum loosen both beds up to 0.5 %, 2 %.
    room = Room(_core.Lifters(0.3, 0.0, 0.0, 0.0, 0), 0.15)
    one, three = fractions(tmp_path, room, (1800, 2600), (1,), settle=0.4)
    assert three == pytest.approx(rods(RADII, SHARES, one), rel=0.02)
    assert one < three < linear_packing(RADII, SHARES, one)


def test_rods_of_one_size_have_the_spacing_that_farr_and_groot_give():
    # Published with four digits, 0.7654 for the fraction 0.6435.
    assert rod_spacing(0.6435) == pytest.approx(0.7654, abs=1e-4)


@pytest.mark.parametrize(
    ("model", "radii", "shares", "mono", "expected", "error"),
    [
        # Balls of 1 : 1.0001 are of one size.
        (rods, [1.0, 1.0001], [0.5, 0.5], 0.6, 0.6, 1e-4),
        (linear_packing, [1.0, 1.0001], [0.5, 0.5], 0.6, 0.6, 1e-4),
        # Dust between large balls fills the rest with its own bed, without effect on them.
        (linear_packing, [1e-9, 1.0], [0.1, 0.9], 0.6, 0.6 / 0.9, 1e-6),
        # Large balls in dust: the volume beside them is a bed of dust.
        (linear_packing, [1e-9, 1.0], [0.7, 0.3], 0.6, 0.6 / (1.0 - 0.4 * 0.3), 1e-6),
        (rods, [1e-3, 1.0], [0.7, 0.3], 0.6, 0.6 / (1.0 - 0.4 * 0.3), 0.005),
    ],
)
def test_the_models_have_their_limits(model, radii, shares, mono, expected, error):
    found = model(np.array(radii), np.array(shares), mono)
    assert found == pytest.approx(expected, rel=error)
