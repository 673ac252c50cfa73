"""Tables of cases: headings with units, numbers as in the files they come from."""

import csv
import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

from millscale.analysis.finished_campaign import load_campaign
from millscale.analysis.shapes.shape import shape_of
from millscale.analysis.shapes.snapshots import snapshots_of
from millscale.exports.command import export
from millscale.runs.dumps import read_dump

CASE = "mb-cg-paper-S2.600-fixed-seed1"


@pytest.fixture(scope="module")
def folder(throws, tmp_path_factory):
    to = tmp_path_factory.mktemp("tables") / "csv"
    written = export(throws, "csv", to, [CASE, "mb-cg-paper-S1*"])
    assert written.files[0] == to / "cases.csv" and written.left_out == {}
    return to


def table(path):
    """Return the columns of a table by heading, as text."""
    with path.open(newline="", encoding="utf-8") as file:
        heading, *rows = csv.reader(file)
    return dict(zip(heading, zip(*rows, strict=True), strict=True))


def test_the_cases_have_a_unit_in_each_heading_that_needs_one(folder, throws):
    cases = table(folder / "cases.csv")
    assert {"id", "S", "radius [m]", "power [kW]", "gravity [m/s2]"} <= cases.keys()
    by_id = {charge.id: charge for charge in load_campaign(throws).charges}
    for name, radius in zip(cases["id"], cases["radius [m]"], strict=True):
        assert float(radius) == pytest.approx(by_id[name].case.mill.radius_m, rel=1e-8)


def test_the_series_is_that_of_the_case(folder, throws):
    series = table(folder / CASE / "series.csv")
    charge = next(x for x in load_campaign(throws).charges if x.id == CASE)
    assert_allclose(np.float64(series["drive power [W]"]), charge.series["drive_power_W"])
    assert_allclose(np.float64(series["mill angle [rad]"]), charge.series["mill_angle_rad"])


def test_shapes_and_contours_are_those_of_the_dumps(folder, throws):
    charge = next(x for x in load_campaign(throws).charges if x.id == CASE)
    shapes = table(folder / CASE / "shapes.csv")
    contours = table(folder / CASE / "contours.csv")
    angles = np.float64(contours["mill angle [rad]"])
    radius = charge.case.physical.radius_m - charge.case.physical.ball_radius_m
    for number, snapshot in enumerate(snapshots_of(charge.folder)):
        shape = shape_of(read_dump(snapshot.path), snapshot, charge.case)
        toe = shapes["toe [deg]"][number]
        assert toe == ("" if shape.ends is None else f"{math.degrees(shape.ends.toe):.9g}")
        own = np.isclose(angles, snapshot.mill_angle, atol=1e-8)
        x = np.float64(contours["x / (R - a)"])[own]
        assert_allclose(x, np.vstack(shape.contour.lines)[:, 0], atol=1e-8)
        physical = np.float64(contours["x in the physical mill [m]"])[own]
        assert_allclose(physical, radius * x, atol=1e-7)


def test_balls_have_readable_columns(folder, throws):
    balls = table(folder / CASE / "balls.00001.csv")
    dump = read_dump(snapshots_of(throws / "cases" / CASE)[1].path)
    assert_allclose(np.float64(balls["x [m]"]), dump["x"])
    assert_allclose(np.float64(balls["radius [m]"]), dump["radius"])
    assert_allclose(np.float64(balls["last lifter"]), dump["c_detach[24]"])
