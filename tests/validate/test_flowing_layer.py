"""The flowing layer of beds whose flow is known."""

import math

import numpy as np
import pytest

from millscale.validate.flowing_layer import (
    GRID,
    Fields,
    _populations,
    _speed_at_wall,
    fields_of,
    layer_of,
    slopes_of,
)
from synthetic_case import case_document, typed

TILT, DEPTH, SPEED, FRACTION = 0.6, 0.2, 1.2, 0.55
GRAVITY, DIAMETER = 2.4, 0.01
DOWN, NORMAL = (
    np.array([math.cos(TILT), -math.sin(TILT)]),
    -np.array([math.sin(TILT), math.cos(TILT)]),
)
SURFACE = np.linspace(-0.8, 0.8, 101)[:, None] * DOWN


def sliding(tilt_speed=0.0):
    """A bed below a straight surface through the axis that turns with the mill, over which a layer
    slides with a speed that falls linearly to 0 at DEPTH; its speed may grow along the surface."""
    x, z = np.meshgrid(GRID.nodes, GRID.nodes)
    along, depth = x * DOWN[0] + z * DOWN[1], x * NORMAL[0] + z * NORMAL[1]
    fraction = np.where(depth > 0.0, FRACTION, 0.0)
    extra = (SPEED + tilt_speed * along) * np.clip(1.0 - depth / DEPTH, 0.0, None)
    vx, vz = z + extra * DOWN[0], -x + extra * DOWN[1]
    return Fields(fraction, fraction * vx, fraction * vz, *(np.zeros_like(x) for _ in range(3)))


def test_speed_and_shear_rate_are_those_put_in():
    layer = layer_of(sliding(), SURFACE, GRAVITY, DIAMETER)
    # In the middle of the surface the mill moves at right angles to it; the layer ends where its
    # own speed is that of the mill, which falls with the depth: 1.2 (1 - d / 0.2) = d.
    end = SPEED / (1.0 + SPEED / DEPTH)
    assert layer.depth == pytest.approx(end, abs=0.006)
    assert layer.depth_diameters == pytest.approx(layer.depth / DIAMETER)
    assert layer.shear_rate == pytest.approx(SPEED / DEPTH, rel=0.02)
    assert layer.surface_speed == pytest.approx(SPEED, rel=0.05)
    assert layer.solid_fraction == pytest.approx(FRACTION, rel=0.01)


def test_friction_without_acceleration_is_the_slope_and_pressure_the_weight():
    layer = layer_of(sliding(), SURFACE, GRAVITY, DIAMETER)
    assert layer.slope_friction == pytest.approx(math.tan(TILT), rel=1e-6)
    assert layer.balance_friction == pytest.approx(math.tan(TILT), rel=1e-6)
    pressure = FRACTION * GRAVITY * math.cos(TILT) * 0.5 * layer.depth
    number = SPEED / DEPTH * DIAMETER / math.sqrt(pressure)
    assert layer.inertial_number == pytest.approx(number, rel=0.05)


def test_balls_that_gain_speed_need_less_friction():
    """A momentum flux that grows downhill by q per length takes q from the shear stress."""
    still = sliding()
    x, z = np.meshgrid(GRID.nodes, GRID.nodes)
    along = x * DOWN[0] + z * DOWN[1]
    flux, q = still.fraction * along, 0.4
    moving = Fields(
        still.fraction,
        still.momentum_x,
        still.momentum_z,
        *(q * flux * f for f in (DOWN[0] ** 2, DOWN[0] * DOWN[1], DOWN[1] ** 2)),
    )
    layer = layer_of(moving, SURFACE, GRAVITY, DIAMETER)
    slope = (GRAVITY * math.sin(TILT) - q) / (GRAVITY * math.cos(TILT))
    assert layer.balance_friction == pytest.approx(slope, rel=0.03)
    assert layer.slope_friction == pytest.approx(math.tan(TILT), rel=1e-6)


def test_fields_are_means_over_the_dumps():
    centres = np.array([[0.1, -0.3], [0.4, 0.2]])
    velocity = np.array([[1.0, 2.0], [-1.0, 0.5]])
    areas = np.array([0.01, 0.02])
    both = np.vstack([centres, centres]), np.vstack([velocity, 3.0 * velocity])
    fields = fields_of(*both, np.tile(areas / 2.0, 2))
    cell = GRID.step**2
    assert fields.fraction.sum() * cell == pytest.approx(areas.sum())
    assert fields.momentum_x.sum() * cell == pytest.approx(2.0 * areas @ velocity[:, 0])
    assert fields.flux_xz.sum() * cell == pytest.approx(5.0 * areas @ velocity.prod(axis=1))


def test_balls_that_turn_with_the_mill_have_its_speed_and_others_are_told_apart():
    case = typed(case_document("multi-ball", "constant-gravity", "paper", 2.6, 10))
    angle = np.linspace(-0.7, 0.7, 50)
    centres = 0.95 * np.column_stack([np.sin(angle), -np.cos(angle)])
    velocity = np.column_stack([centres[:, 1], -centres[:, 0]])
    assert _speed_at_wall(case, centres, velocity) == pytest.approx(1.0)
    assert _speed_at_wall(case, centres, 0.9 * velocity) == pytest.approx(0.9)
    flying = np.arange(50) < 10
    flows = (np.arange(50) >= 10) & (np.arange(50) < 25)
    speeds = np.where(flows[:, None], -velocity, velocity)
    found = _populations(centres, speeds, flying, 0.98)
    assert [x["share"] for x in found.values()] == pytest.approx([0.2, 0.3, 0.5])
    total = 0.5 * (0.98 * 0.95) ** 2
    assert [x["kinetic"] for x in found.values()] == pytest.approx(
        [0.2 * total, 0.3 * total, 0.5 * total]
    )


def layers(policy, S, friction, number):
    layer = dict.fromkeys(("slope_friction", "balance_friction", "centre_friction"), friction)
    return {"policy": policy, "S": S, "layer": layer | {"inertial_number": number}}


def test_the_exponent_of_friction_follows_from_two_policies():
    """Friction of the bed 0.8 + 0.12 ln S + 0.1 ln(friction): q = 0.12 / 0.1."""
    rows = [layers("paper", 1.0, 0.8, 0.1)]
    for S in (1.7, 2.6, 4.0):
        rows.append(layers("paper", S, 0.8 + 0.12 * math.log(S), 0.1 * S**0.8))
        rows.append(layers("friction-matched", S, 0.8 + 0.02 * math.log(S), 0.1 * S))
    found = slopes_of(rows)
    assert found["paper"]["exponent_of_inertial_number"] == pytest.approx(0.8)
    assert found["exponent_of_friction"]["centre_friction"] == pytest.approx(1.2)
    assert "exponent_of_friction" not in slopes_of(rows[:2])
