"""Liners of all families, from tables and drawings, run in the engine; few unless asked for.

    python -m pytest tests/liner -m validate

runs every family from CSV and DXF, in mm and in inches, and from a noisy scan, through plan, run
and report.
"""

import json
import re

import numpy as np
import pytest

from in_process import millscale
from liner_files import families, shape_of, write_csv, write_dxf, write_scan
from millscale.cases.decks import copy_decks
from millscale.cases.generate import generate
from millscale.cases.parameters import write_parameters
from millscale.packing.charge import write_charge
from millscale.runs.case_folder import load_case
from scene import run_file
from small_campaign import SINGLE_BALLS, TEXT

pytestmark = pytest.mark.engine
FAMILIES = families()


def campaign(folder, name, ending, unit, rotation=1.0):
    """Write a small campaign with a liner from a file."""
    path = folder / f"liner.{ending}"
    if ending == "csv":
        write_csv(path, FAMILIES[name], unit, error=2e-4)
    else:
        write_dxf(path, FAMILIES[name], unit)
    return campaign_of(path, "tolerance_mm = 0.5" if ending == "csv" else "", rotation)


def campaign_of(path, tolerance, rotation=1.0, R=1.0):
    """Write a small campaign of mill radius R beside the file of its liner."""
    head, _, tail = TEXT.partition("[liner]")
    keys = f'[liner]\nprofile = "{path.name}"\nturns = "counter-clockwise"\n{tolerance}\n'
    text = head + keys + "[ball]" + tail.partition("[ball]")[2]
    text = text.replace("rotation_angle_rad = 1.0", f"rotation_angle_rad = {rotation}")
    text = text.replace("count = [50]", "count = [150]")
    text = text.replace("radius_m = 1.0", f"radius_m = {R}")
    text = text.replace("speed_rad_s = 2.0", f"speed_rad_s = {2.0 / np.sqrt(R)}")
    file = path.with_name("c.toml")
    file.write_text(text)
    return file


def test_a_high_low_liner_in_inches_carries_a_charge(tmp_path):
    cases = generate(campaign(tmp_path, "hi-lo", "dxf", "in", rotation=0.3), tmp_path / "runs")
    case = next(case for case in cases if case.kind == "multi-ball")
    assert case.mill.lifters == 6 and case.liner_file.name == "liner.dxf"
    folder = tmp_path / "decks"
    folder.mkdir()
    copy_decks(("settle.in", "mill.in"), folder)
    write_parameters(case, folder)
    write_charge(case, folder)
    (folder / "dump").mkdir()
    for deck in ("settle.in", "mill.in"):
        done = run_file(folder, deck)
        assert done.code == 0, done.text[-2000:]
    header, *rows = (folder / "series.csv").read_text().splitlines()
    last = dict(zip(header.split(","), map(float, rows[-1].split(",")), strict=True))
    assert last["balls"] == 150 and last["drive_work_J"] > 0.0
    assert 0.0 < last["box_rotating_mass_fraction"] < 1.0
    # Balls lie in several of the twelve grooves, which have numbers of their own.
    dump = sorted((folder / "dump").glob("charge.*"))[-1].read_text().splitlines()
    column = dump[8].split()[2:].index("c_detach[24]")
    carried = {float(row.split()[column]) for row in dump[9:]}
    assert len(carried - {-1.0}) >= 2 and max(carried) < 12.0


@pytest.mark.validate
@pytest.mark.parametrize("unit", ["mm", "in"])
@pytest.mark.parametrize("ending", ["csv", "dxf"])
@pytest.mark.parametrize("name", FAMILIES)
def test_a_family_runs_and_is_reported(tmp_path, name, ending, unit):
    results, _ = reported(campaign(tmp_path, name, ending, unit))
    assert len(results["single_ball"]) == 2 and len(results["multi_ball"]) == 1


@pytest.mark.validate
@pytest.mark.parametrize("name", FAMILIES)
def test_a_noisy_scan_runs_and_is_reported(tmp_path, name):
    """400 points of one pitch of a mill of 8 m, with 2 mm of noise, within 6 mm."""
    R, true = 4.0, shape_of(families(4.0)[name], 4.0)
    write_scan(tmp_path / "scan.csv", families(R)[name])
    results, planned = reported(campaign_of(tmp_path / "scan.csv", "tolerance_mm = 6", R=R))
    assert len(results["single_ball"]) == 2 and len(results["multi_ball"]) == 1
    found = re.search(r"400 points are (\d+) lines and arcs, none farther than (\S+) m", planned)
    pieces, error = int(found[1]), float(found[2])
    assert pieces <= 20 and error <= 6e-3
    case = load_case(tmp_path / "runs" / "cases" / SINGLE_BALLS[0])
    print(
        f"{name:9}{pieces:3} pieces, error {1e3 * error:.2f} mm, area {case.mill.area_m2:.4f} m2"
        f" of {true.area:.4f} m2"
    )
    # The section is within the error of points whose noise has no mean.
    assert abs(case.mill.area_m2 - true.area) < error * 2.0 * np.pi * R


def reported(file):
    """Plan, run and report a campaign; return its results and what the plan printed."""
    runs = file.with_name("runs")
    environment = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    printed = []
    for line in (("plan", file), ("run", file, "--runs", runs), ("report", runs)):
        done = millscale(*line, **environment)
        assert done.returncode == 0, done.stdout + done.stderr
        printed.append(" ".join((done.stdout + done.stderr).split()))
    results = json.loads((runs / "report" / "results.json").read_text())
    assert results["missing"] == {}
    assert (runs / "report" / "index.html").exists()
    return results, printed[0]
