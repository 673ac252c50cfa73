"""The angle at which balls were thrown, from where they are."""

import numpy as np
import pytest

from millscale.analysis.shapes.throw_angle import FEWEST_BALLS, throw_angle
from millscale.runs.dumps import Dump
from synthetic_case import case_document, typed

BALLS, ANGLE = 40, 0.7


def thrown(case, time):
    """Balls that left the liner's path at ANGLE, each after its own time in flight [s]."""
    mill = case.mill
    radius, omega, g = mill.radius_m, mill.omega_rad_s, mill.gravity_m_s2
    x0, z0 = -radius * np.sin(ANGLE), radius * np.cos(ANGLE)
    vx, vz = omega * z0, omega * -x0
    return {
        "id": np.arange(BALLS, dtype=float),
        "x": x0 + vx * time,
        "z": z0 + vz * time - 0.5 * g * time**2,
        "vx": np.full(BALLS, vx),
        "vz": vz - g * time,
        "c_detach[1]": np.full(BALLS, 3.0),
        "c_detach[22]": time,
    }


@pytest.fixture
def case():
    return typed(case_document("multi-ball", "constant-gravity", "paper", 2.6, BALLS))


@pytest.fixture
def radius(case):
    """Of the circle outside which flights are throws [m]."""
    return 0.9 * case.mill.radius_m


def test_balls_on_parabolas_lead_back_to_where_they_left(case, radius):
    columns = thrown(case, np.linspace(0.05, 0.6, BALLS))
    assert throw_angle(Dump(0, columns), case, radius) == pytest.approx(ANGLE, abs=1e-12)


def test_the_angle_is_the_median(case, radius):
    """A few balls that left at the top do not move it."""
    columns = thrown(case, np.linspace(0.05, 0.6, BALLS))
    late = np.arange(BALLS) >= BALLS - 15
    time, g = columns["c_detach[22]"], case.mill.gravity_m_s2
    for name, value in (("vx", 0.0), ("vz", -g * time), ("x", 0.0)):
        columns[name] = np.where(late, value, columns[name])
    top = case.mill.radius_m - 0.5 * g * time**2
    columns["z"] = np.where(late, top, columns["z"])
    assert throw_angle(Dump(0, columns), case, radius) == pytest.approx(ANGLE, abs=1e-12)


def test_only_confirmed_flights_count(case, radius):
    columns = thrown(case, np.linspace(0.05, 0.6, BALLS))
    strange = np.arange(BALLS) < BALLS - FEWEST_BALLS
    places = {"x": 0.0, "z": case.mill.radius_m, "vx": 0.0, "vz": 0.0}
    for name, value in (("c_detach[1]", 2.0), ("c_detach[22]", 0.0)):
        changed = {"c_detach[22]": 1e-6, **places, name: value}
        spoiled = columns | {k: np.where(strange, v, columns[k]) for k, v in changed.items()}
        assert throw_angle(Dump(0, spoiled), case, radius) == pytest.approx(ANGLE, abs=1e-12)


def test_flights_that_began_inside_the_circle_are_no_throws(case, radius):
    columns = thrown(case, np.linspace(0.05, 0.6, BALLS))
    assert throw_angle(Dump(0, columns), case, 1.01 * case.mill.radius_m) is None
    rolling = np.arange(BALLS) < BALLS - FEWEST_BALLS
    spoiled = columns | {"x": np.where(rolling, columns["x"] + 0.4, columns["x"])}
    assert throw_angle(Dump(0, spoiled), case, radius) == pytest.approx(ANGLE, abs=1e-12)
    assert throw_angle(Dump(0, spoiled), case, 0.0) != pytest.approx(ANGLE, abs=1e-3)


def test_few_balls_or_a_missing_column_give_none(case, radius):
    columns = thrown(case, np.linspace(0.05, 0.6, BALLS))
    few = np.where(np.arange(BALLS) < FEWEST_BALLS - 1, 3.0, 2.0)
    assert throw_angle(Dump(0, columns | {"c_detach[1]": few}), case, radius) is None
    del columns["c_detach[22]"]
    assert throw_angle(Dump(0, columns), case, radius) is None


def test_balls_that_hop_behind_the_toe_are_not_thrown(case):
    columns = thrown(case, np.linspace(0.05, 0.6, BALLS))
    hops = np.arange(BALLS) < BALLS - FEWEST_BALLS
    drop = 0.5 * case.mill.gravity_m_s2 * 0.01**2
    radius = case.mill.radius_m
    for name, value in (("vx", 0.0), ("vz", 0.0), ("c_detach[22]", 0.01), ("x", 0.6 * radius)):
        columns[name] = np.where(hops, value, columns[name])
    columns["z"] = np.where(hops, -0.6 * radius - drop, columns["z"])
    assert throw_angle(Dump(0, columns), case, 0.5 * radius) == pytest.approx(ANGLE, abs=1e-12)
    columns["c_detach[1]"] = np.where(hops, 3.0, 2.0)
    assert throw_angle(Dump(0, columns), case, 0.5 * radius) is None
