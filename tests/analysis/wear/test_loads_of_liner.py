"""Loads on the liner: force on a lifter, toe and shoulder by it, wear of the physical mill."""

import math

import numpy as np
import pytest

from millscale.analysis.wear.lifter_load import high_arc, lifter_loads
from millscale.analysis.wear.loads import LIFTERS, MAP, read_liner_loads
from millscale.analysis.wear.rate import mean_rate, physical_flux, wear_rate
from millscale.analysis.wear.result import read_liner_loads_result
from millscale.runs.liner import liner_of
from millscale.runs.untrusted import RunFolderError
from synthetic_case import case_document, typed
from synthetic_loads import PRESSURE, SLIP, write_loads

FIRST, COUNT = 12, 60


@pytest.fixture
def case():
    return typed(case_document("multi-ball", "constant-gravity", "paper", 2.6, 100))


@pytest.fixture
def loads(tmp_path, case):
    write_loads(tmp_path, case, FIRST, COUNT)
    return read_liner_loads(tmp_path, case)


def test_a_pressure_on_a_lifter_is_a_force_by_its_foot(loads, case):
    (load,) = lifter_loads(loads, case)
    liner = liner_of(case.mill)
    # A closed surface in a pressure has no force: the faces and the top have that of the chord
    # between the feet.
    foot = 2.0 * liner.radius * math.sin(math.pi / liner.sectors - math.asin(
        0.5 * liner.groove_width / liner.radius))  # fmt: skip
    loaded = load.size > 0.5 * load.size.max()
    assert loaded.sum() == COUNT
    np.testing.assert_allclose(load.outward[loaded], PRESSURE * foot, rtol=1e-9)
    assert np.abs(load.along).max() < 1e-9 * PRESSURE * foot
    assert load.size[~loaded].max() < 1e-9 * PRESSURE * foot


def test_toe_and_shoulder_are_where_the_force_begins_and_ends(loads, case):
    (load,) = lifter_loads(loads, case)
    liner, places = liner_of(case.mill), len(loads.places)
    # The lifter trails its sector by half a pitch.
    begin = FIRST * 2.0 * np.pi / places - 0.5 * liner.pitch
    assert load.toe == pytest.approx(np.pi - begin)
    assert load.shoulder == pytest.approx(np.pi - begin - COUNT * 2.0 * np.pi / places)


@pytest.mark.parametrize(("first", "count"), [(0, 1), (3, 50), (90, 20), (99, 1), (40, 99)])
def test_the_arc_of_a_step_is_found_across_the_end(first, count):
    values = np.ones(100)
    values[(first + np.arange(count)) % 100] = 3.0
    assert high_arc(values) == (first, count)


def test_no_arc_without_a_step():
    assert high_arc(np.full(30, 2.0)) is None


def test_wear_of_the_physical_mill(loads, case):
    rate = wear_rate(loads, case, "archard")
    # Constant gravity: energy per area and time as S^1.5.
    assert physical_flux(case) == pytest.approx(2.6**1.5)
    np.testing.assert_allclose(rate.flux, 2.6**1.5 * SLIP, rtol=1e-9)
    np.testing.assert_allclose(rate.error, 0.0, atol=1e-9)
    assert rate.mean == pytest.approx(2.6**1.5 * SLIP)
    assert wear_rate(loads, case, "finnie").mean == 0.0
    twice = mean_rate([rate, rate])
    np.testing.assert_allclose(twice.flux, rate.flux)


def test_wear_scales_as_the_power_over_the_area():
    for scheme, exponent in (("constant-gravity", 1.5), ("constant-speed", 3.0)):
        case = typed(case_document("multi-ball", scheme, "paper", 2.0, 100))
        assert physical_flux(case) == pytest.approx(2.0**exponent)


def test_the_result_holds_means_over_the_window(tmp_path, case, loads):
    result = read_liner_loads_result(tmp_path, case)
    area = loads.bins.edges[-1] * case.mill.lifters * case.mill.simulated_length_m
    assert result.slip_power_W == pytest.approx(SLIP * area)
    assert sum(result.slip_share.values()) == pytest.approx(1.0)
    share = loads.bins.widths[loads.bins.faces == "groove"].sum() / loads.bins.edges[-1]
    assert result.slip_share["groove"] == pytest.approx(share)
    assert result.lifters[0].toe_rad > result.lifters[0].shoulder_rad


@pytest.mark.parametrize(
    ("name", "edit", "cause"),
    [
        (LIFTERS, lambda text: text.rsplit("\n", 3)[0], "rows are not whole"),
        (LIFTERS, lambda text: text.replace("slip_work_J", "slip"), "no column slip_work_J"),
        (MAP, lambda text: text.replace("1,0,", "1,x,", 1), "could not convert"),
        (MAP, lambda text: text.split("\n")[0] + "\n", "no rows"),
    ],
)
def test_files_that_are_not_whole_are_refused(tmp_path, case, loads, name, edit, cause):
    path = tmp_path / name
    path.write_text(edit(path.read_text()))
    with pytest.raises(RunFolderError, match=cause):
        read_liner_loads(tmp_path, case)
