"""`millscale export`: files, folders that are kept, and errors."""

import json
import shutil

import pytest

import millscale as ms
from in_process import millscale

CASE = "mb-cg-paper-S2.600-fixed-seed1"


@pytest.fixture
def runs_folder(throws, tmp_path):
    copy = tmp_path / "runs"
    shutil.copytree(throws, copy)
    return copy


def refused(*arguments):
    """Return the error line of a command with wrong input."""
    done = millscale("export", *arguments)
    assert done.returncode == 2 and done.stdout == ""
    (line,) = done.stderr.splitlines()
    return line


def test_each_format_has_its_folder_in_the_runs_folder(runs_folder):
    done = millscale("export", runs_folder, "--csv", "--ovito", "--only", CASE, "--every", "2")
    assert done.returncode == 0, done.stderr
    first = runs_folder / "export/csv/cases.csv"
    assert done.stdout.splitlines() == [
        *map(str, (first, first.parent / CASE / "series.csv")),
        str(runs_folder / "export/ovito" / CASE / "charge.xyz"),
    ]
    assert len(list((runs_folder / "export/ovito" / CASE).glob("liner.*.stl"))) == 2
    record = json.loads((runs_folder / "export/ovito/export.json").read_text())
    assert (record["format"], record["cases"]) == ("ovito", [CASE])
    # The runs folder is as usable as before.
    assert millscale("export", runs_folder, "--csv", "--to", runs_folder / "again").returncode == 0


def test_an_earlier_export_is_replaced_when_asked_and_nothing_else_is(runs_folder, tmp_path):
    line = (runs_folder, "--csv", "--only", CASE)
    assert millscale("export", *line).returncode == 0
    kept = runs_folder / "export/csv/cases.csv"
    kept.write_text("mine")
    assert "export/csv: is there; --replace writes it again" in refused(*line)
    assert kept.read_text() == "mine"
    assert millscale("export", *line, "--replace").returncode == 0
    assert kept.read_text() != "mine"
    (tmp_path / "home").mkdir()
    (tmp_path / "home/letter").write_text("dear")
    assert "is no earlier export" in refused(*line, "--to", tmp_path / "home", "--replace")
    assert (tmp_path / "home/letter").read_text() == "dear"


def test_wrong_words_are_explained(runs_folder):
    assert "no format given; accepted: --paraview, --csv, --ovito" in refused(runs_folder)
    assert "finished is" in refused(runs_folder, "--csv", "--only", "mb-cg-paper-S2.6")
    assert "--every: got 0; accepted: >= 1" in refused(runs_folder, "--csv", "--every", "0")
    assert "one format" in refused(runs_folder, "--csv", "--ovito", "--to", "x")


def test_a_single_ball_and_a_case_without_dumps_are_left_out_with_a_reason(runs, runs_folder):
    done = refused(runs, "--paraview", "--only", "sb-*-S2.600")
    assert "nothing to export: sb-cg-paper-S2.600: a single ball has no dumps" in done
    shutil.rmtree(runs_folder / "cases" / CASE / "dump")
    done = millscale("export", runs_folder, "--ovito", "--only", "*seed1", "--every", "3")
    assert done.returncode == 0
    assert f"{CASE}: left out: it has no dumps" in done.stderr


def test_a_missing_liner_is_explained(runs_folder):
    (runs_folder / "cases" / CASE / "liner.stl").unlink()
    assert "liner.stl" in refused(runs_folder, "--ovito", "--only", CASE)


def test_python_writes_the_same_files(runs_folder, tmp_path):
    assert millscale("export", runs_folder, "--csv", "--only", CASE).returncode == 0
    files = ms.open(runs_folder).export("csv", tmp_path / "tables", only=CASE)
    assert files[0] == tmp_path / "tables/cases.csv"
    for path in (runs_folder / "export/csv").rglob("*.csv"):
        twin = tmp_path / "tables" / path.relative_to(runs_folder / "export/csv")
        assert twin.read_bytes() == path.read_bytes()
