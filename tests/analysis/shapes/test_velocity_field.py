"""Mean velocity over the cross-section, of charges whose velocity is known."""

import numpy as np
import pytest
from msgspec import structs
from numpy.testing import assert_allclose

from millscale.analysis.shapes.velocity_field import FEWEST_BALLS, velocity_field
from millscale.runs.case_file import BallClass
from millscale.runs.dumps import Dump
from synthetic_case import case_document, typed


@pytest.fixture
def case():
    return typed(case_document("multi-ball", "constant-gravity", "paper", 2.6, 10))


def turning(case, count=60_000):
    """A dump of a charge that turns with the mill as a rigid body."""
    mill = case.mill
    generator = np.random.default_rng(1)
    x, z = generator.uniform(-1.0, 1.0, (2, count)) * mill.radius_m
    inside = np.hypot(x, z) < 0.95 * mill.radius_m
    x, z = x[inside], z[inside]
    omega = mill.omega_rad_s  # positive turns the bottom towards -x
    return Dump(
        0,
        {
            "id": np.arange(1.0, x.size + 1.0),
            **{"x": x, "y": np.zeros(x.size), "z": z, "vx": omega * z, "vz": -omega * x},
            "radius": np.full(x.size, case.ball.radius_m),
        },
    )


def test_a_rigid_rotation_is_found_in_every_cell(case):
    field = velocity_field(turning(case), case)
    unit = case.mill.radius_m - case.ball.radius_m
    x, z = np.meshgrid(field.middles, field.middles)
    radius = np.hypot(x, z) * unit / case.mill.radius_m
    inside = radius < 0.9
    # A cell is its width across; the mean place of its balls is within half of that.
    half = 0.5 * (field.edges[1] - field.edges[0])
    assert_allclose(field.velocity[0][inside], (z * unit / case.mill.radius_m)[inside], atol=half)
    assert_allclose(field.velocity[1][inside], (-x * unit / case.mill.radius_m)[inside], atol=half)
    assert_allclose(field.speed[inside], radius[inside], atol=half)
    assert np.isnan(field.speed[radius > 1.0]).all()


def test_dumps_add_up_and_cells_of_few_balls_have_no_velocity(case):
    dump = turning(case)
    one = velocity_field(dump, case)
    both = one + one
    assert both.balls.sum() == 2 * len(dump)
    assert_allclose(both.mass, 2.0 * one.mass)
    known = one.balls >= FEWEST_BALLS
    assert_allclose(both.speed[known], one.speed[known])
    alone = Dump(0, {name: values[: FEWEST_BALLS - 1] for name, values in dump.columns.items()})
    assert np.isnan(velocity_field(alone, case).speed).all()


def test_the_mean_is_by_mass(case):
    light, heavy = BallClass(0.02, 1000.0, 3), BallClass(0.02, 3000.0, 3)
    case = structs.replace(case, ball=structs.replace(case.ball, classes=(light, heavy)))
    same = np.zeros(6)
    kinds = np.array([1.0, 2.0] * 3)
    columns = {"id": np.arange(1.0, 7.0), "type": kinds, "x": same, "y": same, "z": same}
    columns |= {"vx": np.where(kinds == 1.0, 1.0, 2.0), "vz": same, "radius": same + 0.02}
    speed = np.nanmax(velocity_field(Dump(0, columns), case).speed)
    scale = case.mill.omega_rad_s * case.mill.radius_m
    assert speed * scale == pytest.approx(0.25 * 1.0 + 0.75 * 2.0)


def test_a_dump_without_velocities_has_no_field(case):
    dump = turning(case)
    columns = {name: values for name, values in dump.columns.items() if name != "vz"}
    assert velocity_field(Dump(0, columns), case) is None
