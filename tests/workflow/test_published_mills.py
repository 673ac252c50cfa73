"""Ten campaigns of published mills, written from the documentation alone."""

import json
import subprocess
import sys

import pytest

from millscale.campaign.build import load_campaign
from millscale.campaign.reader import campaign_tree
from millscale.campaign.writer import toml_text
from millscale.workflow.plan import plan_rows
from paper_campaign import CAMPAIGNS

MILLS = sorted((CAMPAIGNS / "mills").glob("*.toml"))
# The short runs: mill rotation [rad], and slice in ball diameters.
ROTATION_RAD, SLICE_DIAMETERS = 0.2, 2.0


def test_ten_mills_from_the_laboratory_to_the_largest():
    diameters = [2.0 * load_campaign(path).mill.radius for path in MILLS]
    assert len(MILLS) == 10
    assert (min(diameters), max(diameters)) == (0.3048, 12.0)


@pytest.mark.parametrize("path", MILLS, ids=lambda path: path.stem)
def test_a_published_mill_is_planned_without_warnings_and_names_its_source(path):
    head = path.read_text(encoding="utf-8").partition("[campaign]")[0]
    for part in ("# Source: ", "# Figures of the source", "# Assumed: "):
        assert part in head
    texts = [text for row in plan_rows(load_campaign(path)) for text in row["warnings"]]
    assert texts == []


def test_a_mill_shorter_than_four_balls_needs_its_end_walls(tmp_path):
    text = (CAMPAIGNS / "mills" / "venugopal-900-mm.toml").read_text(encoding="utf-8")
    path = tmp_path / "without.toml"
    path.write_text(text.replace('ends = "turning"\n', ""), encoding="utf-8")
    (row,) = plan_rows(load_campaign(path))
    assert row["warnings"] == [
        "the mill is 3 ball diameters long and has no end walls, which carry a part of so short a "
        'charge: mill.ends = "turning" adds them'
    ]


def test_bonds_mill_has_the_charge_of_the_standard():
    (row,) = plan_rows(load_campaign(CAMPAIGNS / "mills" / "bond-305-mm.toml"))
    assert row["balls"] == 285
    assert row["total_mass_kg"] == pytest.approx(20.125, rel=2e-3)


@pytest.mark.engine
@pytest.mark.validate
@pytest.mark.parametrize("path", MILLS, ids=lambda path: path.stem)
def test_a_short_slice_of_a_published_mill_runs_to_its_report(path, tmp_path):
    tree, charge = campaign_tree(path), load_campaign(path).parts[0].charge
    tree["multi_ball"].pop("revolutions")
    tree["multi_ball"]["rotation_angle_rad"] = ROTATION_RAD
    if charge.slice_length:
        tree["multi_ball"]["slice_diameters"] = SLICE_DIAMETERS
    file, runs = tmp_path / path.name, tmp_path / "runs"
    file.write_text(toml_text(tree), encoding="utf-8")
    for command in (("run", file, "--runs", runs), ("verify", runs), ("report", runs)):
        line = [sys.executable, "-m", "millscale", *map(str, command)]
        done = subprocess.run(line, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr
    (case,) = (runs / "cases").iterdir()
    timing = json.loads((case / "timing.json").read_text(encoding="utf-8"))
    planned = json.loads((case / "case.json").read_text(encoding="utf-8"))
    assert timing["steps"] == planned["time"]["steps"]
    assert (runs / "report" / "index.html").stat().st_size > 10_000
    results = json.loads((runs / "report" / "results.json").read_text(encoding="utf-8"))
    assert [row["id"] for row in results["multi_ball"]] == [case.name]
