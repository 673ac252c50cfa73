"""Runs folders from other machines: none of their files is run, no link leads outside."""

import json
import os
import shutil

import pytest

from millscale.cases.parameters import parameters_text
from millscale.report import build as report
from millscale.report.build import build_report
from millscale.runs.case_file import load_case
from millscale.runs.links import check_folder
from millscale.runs.untrusted import RunFolderError
from small_campaign import CHARGE, SINGLE_BALLS

BALL = SINGLE_BALLS[0]


@pytest.fixture
def victim(tmp_path):
    """A file outside the runs folder."""
    path = tmp_path / "victim"
    path.write_text("precious")
    return path


@pytest.mark.parametrize(
    "place",
    [
        ".millscale.lock",
        "log.workflow",
        f"cases/{BALL}/.millscale.lock",
        f"cases/{BALL}/stage.json.part",
        f"cases/{BALL}/out.result",
        f"cases/{BALL}/series.csv",
        f"cases/{BALL}/rotate.part/dump/charge.000000000.liggghts",
        f"cases/{BALL}/a/b/c/d/e/f/g/h",
        ".snakemake/log/a/b/c",
        f"cases/{CHARGE}/dump",
        f"cases/{BALL}/rotate.part",
        "settled/0123456789abcdef",
        "settled",
        ".jobs",
        "predicted.json",
        "campaign.json.part",
        "campaign.toml",
        "report",
    ],
)
@pytest.mark.parametrize("command", ["run", "generate"])
def test_a_link_to_outside_is_refused_and_its_target_stays(finished, victim, place, command):
    (finished.case(BALL) / "result.json").unlink()
    link = finished.runs / place
    if link.is_dir():
        shutil.rmtree(link)
    link.unlink(missing_ok=True)
    link.parent.mkdir(parents=True, exist_ok=True)
    link.symlink_to(victim)
    done = finished(command)
    text = done.stdout + done.stderr
    assert done.returncode in (1, 2) and f"{link.name}: is a link to {victim}" in text
    assert victim.read_text() == "precious" and link.is_symlink()


@pytest.mark.parametrize(
    "place", [f"{BALL}/result.json", f"{CHARGE}/dump/charge.000000001.liggghts"]
)
def test_a_link_in_place_of_a_product_is_refused_before_work_and_found_by_verify(
    finished, victim, place
):
    link = finished.runs / "cases" / place
    link.unlink(missing_ok=True)
    link.symlink_to(victim)
    with pytest.raises(RunFolderError, match="is a link to"):
        check_folder(link.parents[1] if link.parent.name == "dump" else link.parent)
    assert ("result.json" in place) == (finished("verify").returncode == 1)
    assert victim.read_text() == "precious"


def test_a_case_folder_that_is_a_link_is_refused(finished, tmp_path):
    case = finished.case(BALL)
    case.rename(tmp_path / "elsewhere")
    case.symlink_to(tmp_path / "elsewhere")
    before = sorted((tmp_path / "elsewhere").iterdir())
    done = finished("run")
    assert done.returncode == 2 and "is a link to" in done.stderr
    assert sorted((tmp_path / "elsewhere").iterdir()) == before


def test_links_that_stay_inside_are_accepted(finished):
    (finished.case(BALL) / "earlier.csv").symlink_to("series.csv")
    assert finished("run").returncode == 0


def test_a_pipe_is_refused_not_waited_for(finished):
    os.mkfifo(finished.case(BALL) / "note")
    with pytest.raises(RunFolderError, match="is a pipe"):
        check_folder(finished.case(BALL))


@pytest.mark.parametrize("name", ["snakemake", "millscale", "json", "psutil"])
def test_no_module_of_the_runs_folder_is_run(finished, name):
    witness = finished.runs / "was-run"
    (finished.runs / f"{name}.py").write_text(f"open({str(witness)!r}, 'w')")
    (finished.case(BALL) / "result.json").unlink()
    assert finished("run").returncode == 0
    assert (finished.case(BALL) / "result.json").exists() and not witness.exists()


@pytest.mark.parametrize("entry", ["", "."])
def test_a_relative_python_path_is_that_of_the_command_not_of_the_runs_folder(finished, entry):
    witness = finished.runs / "was-run"
    (finished.runs / "psutil.py").write_text(f"open({str(witness)!r}, 'w')")
    (finished.case(BALL) / "result.json").unlink()
    path = os.pathsep.join([entry, finished.environment()["PYTHONPATH"]])
    assert finished("run", PYTHONPATH=path).returncode == 0
    assert (finished.case(BALL) / "result.json").exists() and not witness.exists()


@pytest.mark.parametrize(
    "case_id", ["../../escaped", "/tmp/escaped", "sb-cg-paper-S1.000/..", "", 3]
)
@pytest.mark.parametrize("command", ["status", "verify"])
def test_an_id_that_leads_outside_is_refused(finished, command, case_id):
    file = finished.runs / "campaign.json"
    file.write_text(json.dumps(json.loads(file.read_text()) | {"cases": [case_id]}))
    done = finished(command)
    assert done.returncode == 2 and "not the id of a case" in done.stderr
    assert len(done.stderr.splitlines()) == 1


@pytest.mark.parametrize(
    ("section", "key", "value"),
    [
        ("deck", "pair", "none\nshell touch escaped"),
        ("deck", "pair", "../../other"),
        ("deck", "a\nshell touch escaped\n", "b"),
        ("deck", "dumps", ["off"]),
        ("wall", "kind", "${scheme}"),
        ("ball", "radius_m", "0.02\nshell touch escaped"),
        ("ball", "radius_m", float("nan")),
        ("mill", "lifters", 10**12),
        ("time", "rotation_steps", 1.5),
    ],
)
def test_no_line_of_case_json_gets_into_a_deck(finished, section, key, value):
    file = finished.case(BALL) / "case.json"
    document = json.loads(file.read_text())
    document[section][key] = value
    file.write_text(json.dumps(document))
    with pytest.raises(RunFolderError):
        parameters_text(load_case(file.parent))


def test_a_case_id_with_a_second_line_is_refused(finished):
    file = finished.case(BALL) / "case.json"
    document = json.loads(file.read_text())
    file.write_text(json.dumps(document | {"id": "sb\nshell touch escaped"}))
    with pytest.raises(RunFolderError, match="id: got"):
        load_case(file.parent)


@pytest.mark.parametrize("name", ["report", "report.part"])
def test_a_report_replaces_a_link_of_its_name_and_what_it_leads_to_stays(
    finished, tmp_path, monkeypatch, name
):
    (elsewhere := tmp_path / "elsewhere").mkdir()
    (elsewhere / "results.json").write_text("precious")
    (finished.runs / name).symlink_to(elsewhere)
    monkeypatch.setattr(report, "_page", lambda campaign, folder, predict: "page")
    monkeypatch.setattr(report, "load_campaign", lambda runs: Nothing(runs))
    build_report(finished.runs)
    assert [x.name for x in elsewhere.iterdir()] == ["results.json"]
    assert (elsewhere / "results.json").read_text() == "precious"
    assert (finished.runs / "report" / "index.html").read_text() == "page"
    assert not (finished.runs / "report").is_symlink()


class Nothing:
    """A campaign with a case and without numbers."""

    def __init__(self, runs):
        self.runs, self.single, self.charges = runs, [1], []

    def results(self):
        return {}
