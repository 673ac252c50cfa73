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
        "c_detach[23]": np.ones(BALLS),
    }


@pytest.fixture
def case():
    return typed(case_document("multi-ball", "constant-gravity", "paper", 2.6, BALLS))


def test_balls_on_parabolas_lead_back_to_where_they_left(case):
    columns = thrown(case, np.linspace(0.05, 0.6, BALLS))
    assert throw_angle(Dump(0, columns), case) == pytest.approx(ANGLE, abs=1e-12)


def test_only_flights_from_the_outermost_layer_count(case):
    columns = thrown(case, np.linspace(0.05, 0.6, BALLS))
    strange = np.arange(BALLS) % 2 == 0
    for name, value in (("c_detach[1]", 2.0), ("c_detach[22]", 0.0), ("c_detach[23]", 0.0)):
        spoiled = columns | {name: np.where(strange, value, columns[name])}
        spoiled["x"] = columns["x"] + 0.3 * strange
        assert throw_angle(Dump(0, spoiled), case) == pytest.approx(ANGLE, abs=1e-12)


def test_few_balls_or_a_missing_column_give_none(case):
    columns = thrown(case, np.linspace(0.05, 0.6, BALLS))
    few = np.where(np.arange(BALLS) < FEWEST_BALLS - 1, 1.0, 0.0)
    assert throw_angle(Dump(0, columns | {"c_detach[23]": few}), case) is None
    del columns["c_detach[22]"]
    assert throw_angle(Dump(0, columns), case) is None


def test_balls_that_hop_behind_the_toe_are_not_thrown(case):
    columns = thrown(case, np.linspace(0.05, 0.6, BALLS))
    hops = np.arange(BALLS) % 2 == 0
    drop = 0.5 * case.mill.gravity_m_s2 * 0.01**2
    radius = case.mill.radius_m
    for name, value in (("vx", 0.0), ("vz", 0.0), ("c_detach[22]", 0.01), ("x", 0.6 * radius)):
        columns[name] = np.where(hops, value, columns[name])
    columns["z"] = np.where(hops, -0.6 * radius - drop, columns["z"])
    assert throw_angle(Dump(0, columns), case) == pytest.approx(ANGLE, abs=1e-12)
    columns["c_detach[23]"] = np.where(hops, 1.0, 0.0)
    assert throw_angle(Dump(0, columns), case) is None
