"""Power models: published examples, the same formulas in other ways, limits, similar mills."""

from __future__ import annotations

import doctest
import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

import millscale.power_models as power_models
from millscale.power_models import (
    MODELS,
    Mill,
    austin_power,
    bond_power,
    charge_shape,
    hogg_fuerstenau_power,
    models_for,
    morrell_gross_power,
    morrell_net_power,
    no_load_power,
)
from millscale.power_models.mill import STANDARD_GRAVITY

FOOT = 0.3048
STEEL_BED = 7800.0 * 0.6  # balls of steel with voids of 0.4 [kg/m^3]
BALL_MILL = Mill(4.0, 5.0, 0.35, 0.72, STEEL_BED)


def test_hogg_fuerstenau_gives_the_mill_of_moly_cop_tools():
    """BallSim_Direct of Moly-Cop Tools (J. E. Sepulveda), base case: 3,885 kW net, 4,316.1 kW with
    losses of 10 %, for pulp of 72 % solids and ore of 2.8 t/m^3.

    The powers, the pulp and the losses are as github.com/fsantibanezleal/CAOS_OreFlow transcribes
    them (methods/data/oracles.json). Its mill, 18.5 ft by 22 ft at J = 0.38, 72 % of the critical
    speed, 35 degrees and balls of 7.75 t/m^3, is from memory.
    """
    pulp = 1.0 / (0.72 / 2.8 + 0.28)
    bulk_density = 1e3 * (0.6 * 7.75 + 0.4 * pulp)
    mill = Mill(18.5 * FOOT, 22.0 * FOOT, 0.38, 0.72, bulk_density)
    net = hogg_fuerstenau_power(mill)
    assert net == pytest.approx(3885e3, rel=0.005)
    assert net / 0.9 == pytest.approx(4316.1e3, rel=0.005)


@pytest.mark.parametrize("filling", [0.15, 0.25, 0.35, 0.45])
def test_hogg_fuerstenau_lifts_the_centroid_of_a_segment(filling):
    """Independent of its constants: the torque is M g times the distance of the centroid of a
    segment of the circle from the axis, times sin(alpha)."""
    half = brentq(lambda b: (2.0 * b - math.sin(2.0 * b)) / (2.0 * math.pi) - filling, 0.0, math.pi)
    centroid = 2.0 / 3.0 * math.sin(half) ** 3 / (math.pi * filling)  # over R
    mill = replace(BALL_MILL, filling=filling)
    angle = math.radians(40.0)
    arm = mill.torque_number(hogg_fuerstenau_power(mill, angle)) / math.sin(angle)
    assert arm == pytest.approx(centroid, rel=0.01)


def test_bond_is_the_same_in_feet_and_short_tons():
    """Rowland's form for feet, short tons and kW: 3.1 D^0.3 (3.2 - 3 J) phi (...) (from memory)."""
    diameter, J, phi = BALL_MILL.diameter / FOOT, BALL_MILL.filling, BALL_MILL.fraction_of_critical
    per_ton = 3.1 * diameter**0.3 * (3.2 - 3.0 * J) * phi * (1.0 - 0.1 / 2.0 ** (9.0 - 10.0 * phi))
    short_tons = BALL_MILL.ball_mass / 907.18474
    assert bond_power(BALL_MILL) == pytest.approx(1e3 * per_ton * short_tons, rel=0.001)


def test_bond_is_the_same_for_the_density_of_steel():
    """Form of public programs (metengineer.com): 7.33 J phi (1 - 0.937 J) (...) rho_ball L D^2.3,
    with rho_ball in t/m^3 of the steel, of which 0.6 fills the bed."""
    D, J, phi = BALL_MILL.diameter, BALL_MILL.filling, BALL_MILL.fraction_of_critical
    speed = phi * (1.0 - 0.1 / 2.0 ** (9.0 - 10.0 * phi))
    power_kw = 7.33 * J * (1.0 - 0.937 * J) * speed * 7.8 * BALL_MILL.length * D**2.3
    assert bond_power(BALL_MILL) == pytest.approx(1e3 * power_kw, rel=0.005)


def test_bond_takes_the_balls_of_a_wet_charge_alone():
    wet = replace(BALL_MILL, bulk_density=5400.0, ball_bulk_density=STEEL_BED)
    assert bond_power(wet) == bond_power(BALL_MILL)
    assert austin_power(wet) == pytest.approx(austin_power(BALL_MILL) * 5400.0 / STEEL_BED)


def test_austin_of_balls_alone_is_the_equation_with_rock_and_water():
    """The whole bracket, with densities of rock and water that a charge of balls does not have."""
    D, L, J = BALL_MILL.diameter, BALL_MILL.length, BALL_MILL.filling
    phi, ball, slurry = BALL_MILL.fraction_of_critical, 7.8, 0.0
    bracket = (1.0 - 0.3) * slurry * J + 0.6 * J * (ball - slurry)
    speed = phi * (1.0 - 0.1 / 2.0 ** (9.0 - 10.0 * phi))
    power_kw = 10.6 * D**2.5 * L * (1.0 - 1.03 * J) * bracket * speed
    assert austin_power(BALL_MILL) == pytest.approx(1e3 * power_kw, rel=1e-12)


# Compartments of a dry ball mill: L [m], J, no-load and net power [kW].
CEMENT = ((3.60, 0.2748, 41.94, 341.97), (7.00, 0.2663, 72.35, 650.69))


def cement_mill(length: float, filling: float) -> Mill:
    return Mill(3.27, length, filling, 0.7267, STEEL_BED)


@pytest.mark.parametrize("length, filling, no_load, net", CEMENT)
def test_morrell_gives_both_compartments_of_a_cement_mill(length, filling, no_load, net):
    """A. S. Erdem, S. L. Ergun, A. H. Benzer, Calculation of the power draw of dry
    multi-compartment ball mills, Physicochem. Probl. Miner. Process. 38 (2004) 221-230.

    Its figures are as github.com/fsantibanezleal/CAOS_ChargeCascade quotes them in its tests; the
    density of the charge is not among them. Steel of 7.8 t/m^3 with voids of 0.4 is assumed: both
    compartments ask for 4.684 t/m^3, which is that to 0.1 %.
    """
    mill = cement_mill(length, filling)
    assert no_load_power(mill) == pytest.approx(1e3 * no_load, rel=0.005)
    assert morrell_net_power(mill) == pytest.approx(1e3 * net, rel=0.005)


def test_morrell_gives_the_power_of_the_whole_cement_mill():
    gross = sum(morrell_gross_power(cement_mill(length, J)) for length, J, _, _ in CEMENT)
    assert gross == pytest.approx(1365.04e3, rel=0.005)


def test_both_compartments_of_the_cement_mill_have_one_density():
    """The net power is proportional to the density, so the assumption above does not enter."""
    density = [net / morrell_net_power(cement_mill(L, J)) for L, J, _, net in CEMENT]
    assert density[0] == pytest.approx(density[1], rel=1e-4)


@pytest.mark.parametrize("filling, speed", [(0.2, 0.6), (0.35, 0.72), (0.45, 0.85)])
def test_morrell_is_the_integral_over_its_velocity_profile(filling, speed):
    mill = replace(BALL_MILL, filling=filling, fraction_of_critical=speed)
    shape, g = charge_shape(mill), mill.gravity
    R, r_i, z = mill.radius, shape.inner_radius, shape.slip
    edge = mill.omega * R

    def velocity(r: float) -> float:
        return edge * (r - z * r_i) / (R - z * r_i)

    lifted = quad(lambda r: r * velocity(r), r_i, R)[0]
    drop = quad(math.cos, shape.toe, shape.shoulder)[0]
    thrown = quad(lambda r: 0.5 * velocity(r) ** 3, r_i, R)[0]
    power = mill.bulk_density * mill.length * (g * lifted * drop + thrown)
    assert morrell_net_power(mill) == pytest.approx(power, rel=1e-9)


def test_the_active_charge_of_morrell_fills_the_area_between_toe_and_shoulder():
    shape = charge_shape(BALL_MILL)
    angle = 2.0 * math.pi + shape.shoulder - shape.toe
    area = 0.5 * angle * (BALL_MILL.radius**2 - shape.inner_radius**2)
    cross_section = math.pi * BALL_MILL.radius**2
    assert area == pytest.approx(shape.active * BALL_MILL.filling * cross_section)
    assert shape.toe > math.pi > shape.shoulder > 0.0


def test_a_centrifuging_charge_of_morrell_lifts_nothing():
    fast = charge_shape(replace(BALL_MILL, fraction_of_critical=1.1))
    assert fast.toe == fast.shoulder == 0.5 * math.pi
    assert fast.active == 1.0


DIAMETERS = (3.0, 4.0, 5.0, 6.0)
# Exponent of the power and that of torque / (M g R) over D, of similar mills.
EXPONENTS = {
    "Hogg-Fuerstenau": (3.5, 0.0),
    "Bond": (3.3, -0.2),
    "Austin": (3.5, 0.0),
    "Morrell C, net": (3.5, 0.0),
}


@pytest.mark.parametrize("name", EXPONENTS)
def test_similar_mills_of_3_to_6_m(name):
    """Same J, share of the critical speed, L / D and bed. All but Bond keep torque / (M g R)."""
    model = next(model for model in MODELS if model.name == name)
    mills = [replace(BALL_MILL, diameter=D, length=1.25 * D) for D in DIAMETERS]
    powers = [model.power(mill) for mill in mills]
    torques = [mill.torque_number(power) for mill, power in zip(mills, powers, strict=True)]
    of_power, of_torque = EXPONENTS[name]
    assert slope(powers) == pytest.approx(of_power, abs=1e-9)
    assert slope(torques) == pytest.approx(of_torque, abs=1e-9)
    assert (max(torques) / min(torques) - 1.0 < 0.02) == (name != "Bond")


def test_the_motor_of_similar_mills_follows_a_smaller_exponent():
    """Morrell C, gross: the no-load power goes as D^2.87, so the whole is between 2.87 and 3.5."""
    mills = [replace(BALL_MILL, diameter=D, length=1.25 * D) for D in DIAMETERS]
    assert slope([no_load_power(mill) for mill in mills]) == pytest.approx(2.87, abs=1e-9)
    assert 3.4 < slope([morrell_gross_power(mill) for mill in mills]) < 3.5


def slope(values: list[float]) -> float:
    return float(np.polyfit(np.log(DIAMETERS), np.log(values), 1)[0])


@pytest.mark.parametrize("model", MODELS, ids=lambda model: model.name)
def test_power_goes_with_length_and_density(model):
    longer = replace(BALL_MILL, length=2.0 * BALL_MILL.length)
    denser = replace(BALL_MILL, bulk_density=2.0 * STEEL_BED)
    power = model.power(BALL_MILL)
    idle = no_load_power(BALL_MILL) if model.name == "Morrell C, gross" else 0.0
    more_idle = no_load_power(longer) if idle else 0.0
    assert model.power(longer) - more_idle == pytest.approx(2.0 * (power - idle))
    assert model.power(denser) - idle == pytest.approx(2.0 * (power - idle))


def test_gravity_scales_the_models_that_have_it():
    """At the same share of the critical speed the power follows g^1.5."""
    moon = replace(BALL_MILL, gravity=STANDARD_GRAVITY / 4.0)
    for power in (hogg_fuerstenau_power, morrell_net_power):
        assert power(moon) == pytest.approx(power(BALL_MILL) / 8.0)


def test_a_mill_within_all_limits():
    rows = models_for(BALL_MILL)
    assert [row.name for row in rows] == [model.name for model in MODELS]
    assert all(row.outside_of == () and row.power_kw > 0.0 for row in rows)
    assert rows[1].power_kw == pytest.approx(1e-3 * bond_power(BALL_MILL))


def test_limits_that_a_mill_lies_outside_of():
    small = Mill(0.3, 0.3, 0.6, 0.95, 1600.0, gravity=1.62)
    outside = {row.name: row.outside_of for row in models_for(small)}
    assert outside["Bond"] == (
        "diameter D 0.3 m, below 2.4 m",
        "filling J 0.6, above 0.5",
        "share of the critical speed 0.95, above 0.9",
        "gravity 1.62 m/s^2, below 9.76 m/s^2",
    )
    assert "gravity" not in " ".join(outside["Morrell C, net"])
    assert all(outside.values())


@pytest.mark.parametrize("filling", [0.05, 0.5, 0.95])
@pytest.mark.parametrize("speed", [0.05, 0.5, 1.05, 2.0])
def test_a_mill_that_a_model_has_no_power_for_is_outside_of_it(filling, speed):
    rows = models_for(Mill(1.0, 1.0, filling, speed, 1600.0))
    assert all(row.outside_of for row in rows if row.power_kw is None)
    assert all(math.isfinite(row.power_kw) for row in rows if row.power_kw is not None)


def test_morrell_refuses_a_charge_without_room():
    with pytest.raises(ValueError, match=r"no room .* at J = 0\.95, 50 % of the critical speed"):
        charge_shape(replace(BALL_MILL, filling=0.95, fraction_of_critical=0.5))


@pytest.mark.parametrize("filling", np.linspace(0.1, 0.48, 5))
@pytest.mark.parametrize("speed", np.linspace(0.48, 0.89, 5))
def test_morrell_has_a_charge_within_its_limits(filling, speed):
    shape = charge_shape(replace(BALL_MILL, filling=filling, fraction_of_critical=speed))
    assert 0.0 < shape.inner_radius < BALL_MILL.radius


@pytest.mark.parametrize(
    "key, value, accepted",
    [
        ("filling", 30.0, "a share above 0 and below 1"),
        ("fraction_of_critical", 0.0, "a number above 0"),
        ("diameter", math.nan, "a number above 0"),
        ("bulk_density", -1.0, "a number above 0"),
        ("ball_bulk_density", 0.0, "a number above 0"),
    ],
)
def test_a_value_that_no_mill_has(key, value, accepted):
    with pytest.raises(ValueError) as refused:
        replace(BALL_MILL, **{key: value})
    assert str(refused.value) == f"{key} of a mill: {value!r}; accepted: {accepted}"


def test_the_example_of_the_package():
    results = doctest.testmod(power_models)
    assert results.attempted > 0
    assert results.failed == 0
