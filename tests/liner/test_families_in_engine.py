"""Liners of all families, from tables and drawings, run in the engine; few unless asked for.

    python -m pytest tests/liner -m validate

runs every family from CSV and DXF, in mm and in inches, through plan, run and report.
"""

import json

import pytest

from in_process import millscale
from liner_files import families, write_csv, write_dxf
from millscale.cases.decks import copy_decks
from millscale.cases.generate import generate
from millscale.cases.parameters import write_parameters
from millscale.packing.charge import write_charge
from scene import run_file
from small_campaign import TEXT

pytestmark = pytest.mark.engine
FAMILIES = families()


def campaign(folder, name, ending, unit, rotation=1.0):
    """Write a small campaign with a liner from a file."""
    path = folder / f"liner.{ending}"
    if ending == "csv":
        write_csv(path, FAMILIES[name], unit, error=2e-4)
    else:
        write_dxf(path, FAMILIES[name], unit)
    head, _, tail = TEXT.partition("[liner]")
    keys = f'[liner]\nprofile = "{path.name}"\nturns = "counter-clockwise"\n'
    keys += "tolerance_mm = 0.5\n" if ending == "csv" else ""
    text = head + keys + "[ball]" + tail.partition("[ball]")[2]
    text = text.replace("rotation_angle_rad = 1.0", f"rotation_angle_rad = {rotation}")
    text = text.replace("count = [50]", "count = [150]")
    (folder / "c.toml").write_text(text)
    return folder / "c.toml"


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
    file, runs = campaign(tmp_path, name, ending, unit), tmp_path / "runs"
    environment = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    for line in (("plan", file), ("run", file, "--runs", runs), ("report", runs)):
        done = millscale(*line, **environment)
        assert done.returncode == 0, done.stdout + done.stderr
    results = json.loads((runs / "report" / "results.json").read_text())
    assert len(results["single_ball"]) == 2 and len(results["multi_ball"]) == 1
    assert results["missing"] == {}
    assert (runs / "report" / "index.html").exists()
