"""A charge for OVITO: extended XYZ, read back by its own rules."""

import re

import numpy as np
import pyvista as pv
from numpy.testing import assert_allclose

from millscale.analysis.finished_campaign import load_campaign
from millscale.analysis.shapes.cross_section import turned
from millscale.analysis.shapes.snapshots import snapshots_of
from millscale.exports.command import export
from millscale.runs.dumps import read_dump

CASE = "mb-cg-paper-S2.600-fixed-seed1"


def frames(path):
    """Return of each frame its second line as a dictionary, and its columns by property."""
    lines = path.read_text().splitlines()
    while lines:
        count = int(lines[0])
        about = {k: v.strip('"') for k, v in re.findall(r'(\w+)=("[^"]*"|\S+)', lines[1])}
        rows = np.array([line.split() for line in lines[2 : 2 + count]], float)
        columns, at = {}, 0
        properties = about["Properties"].split(":")
        for name, kind, width in zip(*(properties[i::3] for i in range(3)), strict=True):
            columns[name] = rows[:, at : at + int(width)]
            assert kind == "R" or (columns[name] == np.round(columns[name])).all()
            at += int(width)
        assert at == rows.shape[1]
        yield about, columns
        lines = lines[2 + count :]


def test_frames_hold_the_dumps_with_radii_and_the_liner_turns(throws, tmp_path):
    to = tmp_path / "ovito"
    (path,) = export(throws, "ovito", to, [CASE]).files
    charge = next(x for x in load_campaign(throws).charges if x.id == CASE)
    snapshots, mill = snapshots_of(charge.folder), charge.case.mill
    found = list(frames(path))
    assert len(found) == len(snapshots)
    rest = pv.read(charge.folder / "liner.stl")
    for number, ((about, columns), snapshot) in enumerate(zip(found, snapshots, strict=True)):
        dump = read_dump(snapshot.path)
        assert_allclose(columns["pos"], dump.positions, rtol=1e-8)
        assert_allclose(columns["radius"][:, 0], dump["radius"])
        assert_allclose(columns["id"][:, 0], dump["id"])
        assert_allclose(columns["type"][:, 0], dump["type"])
        assert_allclose(columns["last_lifter"][:, 0], dump["c_detach[24]"])
        assert float(about["mill_angle_rad"]) == np.float64(f"{snapshot.mill_angle:.9g}")
        assert int(about["Timestep"]) == dump.step
        # The box holds the mill: all balls lie in it.
        edges = np.array(about["Lattice"].split(), float).reshape(3, 3)
        low = np.array(about["Origin"].split(), float)
        assert (columns["pos"] >= low).all() and (columns["pos"] <= low + np.diag(edges)).all()
        assert edges[1, 1] == np.float64(f"{mill.simulated_length_m:.9g}")
        assert about["pbc"] == "F T F"
        liner = pv.read(path.with_name(f"liner.{number:05d}.stl"))
        assert liner.n_cells == rest.n_cells
        expected = turned(rest.points[:, [0, 2]], snapshot.mill_angle)
        assert_allclose(np.sort(liner.points[:, 0]), np.sort(np.float32(expected[:, 0])), atol=1e-6)
