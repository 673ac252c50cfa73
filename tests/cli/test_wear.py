"""`millscale wear` and the section of the report: from loads on a liner to the next campaign."""

import json

import numpy as np
import pytest

from in_process import millscale
from millscale.analysis.wear.measured_profile import fit_laws
from millscale.liner.given import Source, liner_from_file
from millscale.runs.liner import liner_of
from synthetic_case import finish_case, typed, write_campaign
from synthetic_charge import write_charge
from synthetic_loads import SLIP, write_loads

SCHEME = "constant-gravity"


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """A runs folder with one charge whose liner slips evenly."""
    folder = tmp_path_factory.mktemp("runs")
    case = write_charge(folder, SCHEME)
    document = json.loads((case / "case.json").read_text())
    document["deck"]["liner_loads"] = "on"
    (case / "case.json").write_text(json.dumps(document))
    write_loads(case, typed(document), 20, 60)
    finish_case(case)
    write_campaign(folder, [case.name])
    return folder


def wear(runs, *words):
    return millscale("wear", runs, *words)


def refused(runs, *words):
    """Return the error line of a command with wrong input."""
    done = wear(runs, *words)
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    return line


def test_even_slip_wears_the_liner_evenly(runs, tmp_path):
    path = tmp_path / "worn.csv"
    # Energy per area and time of the physical mill times constant and time.
    depth = 2.6**1.5 * SLIP * 1e-10 * 500 * 3600.0
    done = wear(runs, "--hours", 500, "--constant", 1e-10, "--to", path)
    assert done.returncode == 0, done.stderr
    assert f"deepest wear {1e3 * depth:.3g} mm" in done.stdout
    radius = float(done.stdout.split("radius_m = ")[1].split()[0])
    assert radius == pytest.approx(3.9 + depth, abs=2e-4)
    given = liner_from_file(Source(path, turns="counter-clockwise"), radius, 0.0)
    case = typed(json.loads(next(runs.glob("cases/*/case.json")).read_text()))
    new = liner_of(case.mill).scaled(1.0 / case.S)
    points = np.random.default_rng(4).uniform(-3.5, 3.5, (2000, 2))
    before, after = (x.nearest(points).distance for x in (new, given.shape))
    assert np.median((after - before)[before > 0.0]) == pytest.approx(depth, rel=0.02)
    assert "more than" not in done.stderr


def test_deep_wear_is_warned_of(runs, tmp_path):
    done = wear(runs, "--hours", 8000, "--constant", 1e-10, "--to", tmp_path / "worn.csv")
    assert done.returncode == 0, done.stderr
    assert "warning: the deepest wear" in done.stderr
    assert "steps, each with a campaign of the worn profile" in done.stderr


def test_the_report_has_a_section_of_the_liner(runs):
    done = millscale("report", runs)
    assert done.returncode == 0, done.stderr
    page = (runs / "report/index.html").read_text()
    assert '<section id="liner">' in page and 'href="#liner"' in page
    assert len(list((runs / "report").glob("*-liner-map.png"))) == 1
    assert len(list((runs / "report").glob("*-lifter-load.png"))) == 1
    assert len(list((runs / "report").glob("*-wear.png"))) == 1


def test_the_constant_of_a_measured_profile_is_found(runs, tmp_path):
    path = tmp_path / "worn.csv"
    # Even wear keeps the height and narrows the lifter.
    assert wear(runs, "--hours", 4000, "--constant", 1e-10, "--to", path).returncode == 0
    found = fit_laws(runs, path, 4000.0, None, None)
    # The loads have no impacts, so Finnie's law does not wear.
    (archard,) = found.laws
    assert archard.law == "archard"
    assert archard.constant == pytest.approx(1e-10, rel=5e-3)
    assert archard.rms < 0.01 * found.unworn_rms
    assert found.height == pytest.approx(archard.worn.height, rel=1e-3)
    done = wear(runs, "--hours", 2000, "--measured", path)
    assert done.returncode == 0, done.stderr
    # Half of the time needs twice the constant.
    (row,) = (line for line in done.stdout.splitlines() if "archard" in line)
    assert float(row.split("│")[2]) == pytest.approx(2e-10, rel=1e-2)


def test_a_profile_of_another_mill_is_refused(runs, tmp_path):
    path = tmp_path / "other.csv"
    path.write_text("r_mm,angle_deg\n3900,-6\n3900,-3\n3700,-2\n3700,2\n3900,3\n3900,6\n")
    line = refused(runs, "--hours", 1, "--measured", path)
    assert "has 30 lifter pitches, the mill of the campaign 25" in line


@pytest.mark.parametrize(
    ("words", "cause"),
    [
        (("--hours", -1, "--constant", 1e-10), "--hours: got -1"),
        (("--hours", 1, "--constant", 0), "--constant: got 0"),
        (("--hours", "nan", "--constant", 1), "--hours: got nan"),
        (("--hours", 1, "--constant", 1e-10, "--law", "rust"), '--law: got "rust"'),
        (("--hours", 1, "--constant", 1e-10, "--S", 1.5), "no case of S = 1.5 has loads"),
        (("--hours", 1, "--constant", 1e-10, "--plate", -1), "--plate: got -1"),
        (("--hours", 1, "--measured", "x.csv"), "--measured: with --constant, --to"),
        (("--hours", 1), "--constant, --to: missing"),
        (("--hours", 1e9, "--constant", 1e-10), "--hours: wears the liner by up to"),
    ],
)
def test_wrong_words_give_one_line(runs, tmp_path, words, cause):
    line = refused(runs, *words, "--to", tmp_path / "worn.csv")
    assert cause in line
    assert not (tmp_path / "worn.csv").exists()


def test_runs_without_loads_are_refused(tmp_path):
    case = write_charge(tmp_path, SCHEME)
    finish_case(case)
    write_campaign(tmp_path, [case.name])
    line = refused(tmp_path, "--hours", 1, "--constant", 1, "--to", tmp_path / "worn.csv")
    assert "no finished case has loads on the liner" in line
    assert "liner_loads = true in [multi_ball]" in line
