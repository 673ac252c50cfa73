"""Balls and liner for ParaView."""

import shutil
import xml.etree.ElementTree as ET

import numpy as np
import pytest
import pyvista as pv
from numpy.testing import assert_allclose

from millscale.analysis.shapes.cross_section import turned
from millscale.analysis.shapes.snapshots import snapshots_near
from millscale.report.paraview import write_paraview
from millscale.runs.dumps import dump_files, read_dump
from synthetic_case import record_stages


@pytest.fixture
def case_folder(throws, tmp_path):
    folder = tmp_path / "case"
    shutil.copytree(throws / "cases/mb-cg-paper-S2.600-fixed-seed1", folder)
    pv.read(folder / "liner.stl").save(folder / "liner.vtp")
    record_stages(folder)
    return folder


def test_each_time_has_its_balls_and_the_liner_turned_to_it(case_folder):
    collection = write_paraview(case_folder)
    entries = ET.parse(collection).getroot().findall("Collection/DataSet")
    names = [(float(e.get("timestep")), e.get("part"), e.get("file")) for e in entries]
    assert len(names) == 6
    assert [part for _, part, _ in names] == ["0", "1"] * 3
    step = list(dump_files(case_folder))[-1]
    dump = read_dump(dump_files(case_folder)[step])
    balls = pv.read(collection.parent / f"balls.{step:09d}.vtp")
    assert_allclose(balls.points, dump.positions, rtol=1e-6)
    assert_allclose(balls["radius"], dump["radius"])
    assert_allclose(balls["c_detach[24]"], dump["c_detach[24]"])
    start = read_dump(next(iter(dump_files(case_folder).values())))
    assert np.array_equal(balls["rising"] == 1, start["x"] < 0.0)
    angle = snapshots_near(case_folder, [1.0])[0].mill_angle
    rest = pv.read(case_folder / "liner.vtp")
    liner = pv.read(collection.parent / f"liner.{step:09d}.vtp")
    assert_allclose(liner.points[:, [0, 2]], turned(rest.points[:, [0, 2]], angle), atol=1e-6)
    assert_allclose(liner.points[:, 1], rest.points[:, 1])
    # The mill starts at 0 rad at time 0 in the made-up series.
    omega = 1.0 * np.sqrt(2.6)
    assert_allclose(
        sorted({time for time, _, _ in names}), np.array([0.0, 0.5, 1.0]) / omega, atol=2e-4
    )
