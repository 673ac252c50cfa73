"""`millscale breakage` and the section of the report."""

import json

import pytest

from in_process import millscale
from synthetic_case import finish_case, write_campaign, write_case
from synthetic_impacts import write_spectra
from synthetic_mills import charge_case, columns_of, write_mills
from synthetic_ore import ore_text, write_ore


@pytest.fixture
def runs(tmp_path):
    """A runs folder of S = 1 with spectra."""
    runs = tmp_path / "runs"
    case = charge_case(1.0, 1)
    case["deck"]["impacts"] = "on"
    folder = write_case(runs, case, columns_of(case))
    write_spectra(folder, case, 5.0 * case["ball"]["count"])
    finish_case(folder)
    write_campaign(runs, [folder.name])
    return runs


def test_the_command_writes_what_the_report_shows(runs, tmp_path):
    before = millscale("report", runs)
    assert before.returncode == 0, before.stderr
    assert 'id="breakage"' not in (runs / "report/index.html").read_text()
    done = millscale("breakage", runs, "--ore", write_ore(tmp_path / "mine.toml"))
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("Post-processing: the simulation has balls and no ore")
    assert "catches 3 particles, and they take 80 % of its dissipated energy" in done.stdout
    assert "selection function [1/min]" in done.stdout
    assert (runs / "breakage/breakage.png").stat().st_size > 1000
    document = json.loads((runs / "breakage/breakage.json").read_text())
    assert document["mills"][0]["sizes"][0]["rate"] > 0.0 and document["ore"]["particles"] == 3
    after = millscale("report", runs)
    assert after.returncode == 0, after.stderr
    page = (runs / "report/index.html").read_text()
    assert '<section id="breakage">' in page and 'href="#breakage"' in page
    assert "Post-processing: the simulation has balls and no ore" in page
    assert (runs / "report/breakage.png").is_file()


def test_json_holds_the_numbers_of_the_file(runs, tmp_path):
    done = millscale("breakage", runs, "--ore", write_ore(tmp_path / "mine.toml"), "--json")
    printed = json.loads(done.stdout)
    written = json.loads((runs / "breakage/breakage.json").read_text())
    assert printed == {key: written[key] for key in printed}


def test_an_ore_in_the_folder_that_was_damaged_stops_the_report(runs):
    (runs / "breakage").mkdir()
    (runs / "breakage/ore.toml").write_text(ore_text().replace("b = 0.8", "b = -1"))
    done = millscale("report", runs)
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert "breakage/ore.toml" in line and "jk.b" in line


def test_wrong_input_is_one_line(runs, tmp_path):
    done = millscale("breakage", runs, "--ore", tmp_path / "none.toml")
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1
    without = write_mills(tmp_path / "without", charge_case(1.0, 1))
    done = millscale("breakage", without, "--ore", write_ore(tmp_path / "mine.toml"))
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert "no finished case has spectra of its impacts" in line
    assert "impacts = true in [multi_ball]" in line
