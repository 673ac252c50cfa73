"""Balls and liner for ParaView."""

import shutil
import subprocess
import xml.etree.ElementTree as ET

import numpy as np
import pytest
import pyvista as pv
from numpy.testing import assert_allclose

from millscale.analysis.finished_campaign import load_campaign
from millscale.analysis.shapes.cross_section import turned
from millscale.analysis.shapes.snapshots import snapshots_of
from millscale.exports.command import export
from millscale.runs.dumps import read_dump

CASE = "mb-cg-paper-S2.600-fixed-seed1"
PVPYTHON = shutil.which("pvpython")


@pytest.fixture(scope="module")
def folder(throws, tmp_path_factory):
    to = tmp_path_factory.mktemp("paraview") / "files"
    (state,) = export(throws, "paraview", to, [CASE]).files
    assert state == to / CASE / "charge.pvsm"
    return state.parent


@pytest.fixture(scope="module")
def charge(throws):
    return next(x for x in load_campaign(throws).charges if x.id == CASE)


def collection(path):
    entries = ET.parse(path).getroot().findall("Collection/DataSet")
    return [(float(entry.get("timestep")), path.parent / entry.get("file")) for entry in entries]


def test_each_time_has_its_balls_and_the_liner_turned_to_it(folder, charge):
    balls, liners = (collection(folder / f"{name}.pvd") for name in ("balls", "liner"))
    snapshots = snapshots_of(charge.folder)
    assert len(balls) == len(liners) == len(snapshots) == 3
    # The mill starts at 0 rad at time 0 in the made-up series.
    omega = charge.case.mill.omega_rad_s
    rest = pv.read(charge.folder / "liner.stl").points
    first = read_dump(snapshots[0].path)
    for (time, ball_file), (same, liner_file), snapshot in zip(
        balls, liners, snapshots, strict=True
    ):
        assert time == same == pytest.approx(snapshot.mill_angle / omega, abs=2e-4)
        dump, points = read_dump(snapshot.path), pv.read(ball_file)
        assert_allclose(points.points, dump.positions, rtol=1e-6)
        assert_allclose(points["radius"], dump["radius"])
        assert_allclose(points["last_lifter"], dump["c_detach[24]"])
        assert np.array_equal(points["rising"] == 1, first["x"] < 0.0)
        liner = pv.read(liner_file).points
        assert_allclose(liner[:, [0, 2]], turned(rest[:, [0, 2]], snapshot.mill_angle), atol=1e-6)
        assert_allclose(liner[:, 1], rest[:, 1])


def test_the_state_names_files_that_are_there_and_refers_to_known_proxies(folder):
    root = ET.parse(folder / "charge.pvsm").getroot()
    names = [
        element.get("value") for element in root.iterfind(".//Property[@name='FileName']/Element")
    ]
    assert names == [str(folder / "balls.pvd"), str(folder / "liner.pvd")]
    known = {proxy.get("id") for proxy in root.iter("Proxy") if proxy.get("id")}
    used = {proxy.get("value") for proxy in root.iter("Proxy") if proxy.get("value")}
    assert used and used <= known
    items = {item.get("id") for item in root.iterfind("*/ProxyCollection/Item")}
    assert items and items <= known


@pytest.mark.skipif(PVPYTHON is None, reason="ParaView is not installed")
def test_paraview_shows_spheres_of_the_radius(folder, tmp_path):
    program = (
        "from paraview.simple import *\n"
        f"LoadState({str(folder / 'charge.pvsm')!r})\n"
        "view = GetActiveView()\n"
        "balls = FindSource('balls.pvd')\n"
        "look = GetDisplayProperties(balls, view)\n"
        "assert look.Representation == 'Point Gaussian', look.Representation\n"
        "assert look.SetScaleArray[1] == 'radius', look.SetScaleArray\n"
        "assert view.ViewTime == max(balls.TimestepValues)\n"
        f"SaveScreenshot({str(tmp_path / 'picture.png')!r}, view)\n"
    )
    (tmp_path / "show.py").write_text(program)
    done = subprocess.run(
        [PVPYTHON, "--force-offscreen-rendering", tmp_path / "show.py"],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "picture.png").stat().st_size > 10_000
